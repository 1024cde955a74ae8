"""The evaluator: values of expressions of constants, parameters and function calls.

Parameters are asked for their bindings, functions are run (`interpret`). With `mark`
every parameter that is used becomes structural.
"""

from __future__ import annotations

import operator
import sys

from msgspec import Struct
from msgspec.structs import replace

from planarc.core.diagnostic import error
from planarc.core.prose import listed
from planarc.core.source import Span
from planarc.flatten.refusal import too_large
from planarc.flatten.terms.constant import Frame, NotConstant, Value
from planarc.flatten.tree.demand import attributes_of, leaf_binding
from planarc.flatten.tree.lookup import leaf_named
from planarc.flatten.tree.nodes import Leaf, Session
from planarc.flatten.values import compute
from planarc.ir import flat
from planarc.ir.flatwalk import is_false


def range_count(first: float, step: float, last: float, span: Span) -> int:
    if step == 0:
        raise error("F277", "the step of a range is zero", span)
    steps = (last - first) / step
    if not steps < sys.maxsize:  # not a number either
        raise too_large(f"a range of {steps:g} values is too long", span)
    return max(0, int(steps + 1e-12) + 1) if steps >= 0 else 0


class Evaluator(Struct):
    """Values of expressions."""

    session: Session | None
    mark: bool = False
    frame: Frame | None = None  # the variables of a function being run
    hidden: frozenset[str] = frozenset()  # local names, which are no variables of the model
    closed: bool = False  # inside a function: only its own variables exist
    depth: int = 0  # of calls

    def value(self, e: flat.Expression) -> Value:
        match e:
            case flat.Literal():
                return e.value
            case flat.Reference():
                return self._reference(e)
            case flat.Unary():
                return compute.unary(e.op, self.value(e.operand))
            case flat.Binary():
                return self._binary(e)
            case flat.If():
                for condition, value in e.branches:
                    if self.value(condition):
                        return self.value(value)
                return self.value(e.otherwise)
            case flat.Array():
                return compute.row([self.value(i) for i in e.items], e)
            case flat.Range():
                return self._range(e)
            case flat.Index():
                return compute.index(self.value(e.base), self._subscripts(e.subscripts), e.span)
            case flat.Field():
                return compute.each(operator.itemgetter(e.name), self.value(e.base))
            case flat.Record():
                names = [n for n, _ in e.type.fields]
                return dict(zip(names, [self.value(i) for i in e.items], strict=True))
            case flat.Builtin():
                return self._builtin(e)
            case flat.Call():
                return self._call(e)
            case flat.Comprehension():
                return self._comprehension(e)
        raise NotConstant("this expression has no value before the run", e.span)

    def _binary(self, e: flat.Binary) -> Value:
        left = self.value(e.left)
        if e.op == "and" and left is False:
            return False
        if e.op == "or" and left is True:
            return True
        result = compute.binary(e, left, self.value(e.right))
        if e.type.base is flat.Base.REAL and not e.type.dims and isinstance(result, int):
            return float(result)
        return result

    def _reference(self, e: flat.Reference) -> Value:
        if self.frame is not None and e.name in self.frame:
            value = self.frame[e.name]
            if value is None:
                raise NotConstant(f"`{e.name}` is used before it has a value", e.span)
        else:
            leaf = self._leaf(e.name)
            if leaf is None:
                raise NotConstant(f"`{e.name}` has no value before the run", e.span)
            if leaf.variability > flat.Variability.PARAMETER:
                reason = f"`{e.name}` is a variable, not a parameter"
                raise NotConstant(reason, e.span, e.name)
            value = self.leaf_value(leaf)
        if not e.subscripts:
            return value
        return compute.index(value, self._subscripts(e.subscripts), e.span)

    def _leaf(self, name: str) -> Leaf | None:
        if self.session is None or self.closed or name in self.hidden:
            return None
        return leaf_named(self.session, name)

    def _subscripts(self, subscripts: flat.Expressions) -> list[Value | None]:
        return [None if isinstance(s, flat.Slice) else self.value(s) for s in subscripts]

    def leaf_value(self, leaf: Leaf) -> Value:
        """The value of a constant or parameter from its binding."""
        if self.session is not None and leaf.parent.prefix is not None:
            self.session.asked.append((leaf, self.mark))
        if leaf.evaluated is not None and (leaf.shapes or not self.mark):
            return leaf.evaluated
        if self.mark:
            leaf.structural = leaf.shapes = True
        binding = leaf_binding(leaf)
        if binding is None:
            binding = self._from_start(leaf)
        if leaf.evaluating:
            raise error("F282", f"the value of `{leaf.name}` depends on itself", leaf.span)
        leaf.evaluating = True
        try:
            value = Evaluator(self.session, self.mark).value(binding)
        finally:
            leaf.evaluating = False
        if leaf.type.base is flat.Base.REAL and binding.type.base is flat.Base.INTEGER:
            value = compute.each(float, value)
        leaf.evaluated = value
        return leaf.evaluated

    def _from_start(self, leaf: Leaf) -> flat.Expression:
        attributes = attributes_of(leaf)
        if is_false(attributes.fixed):
            raise NotConstant(f"`{leaf.name}` gets its value at the start of the run", leaf.span)
        start = attributes.start
        if start is None or leaf.variability is flat.Variability.CONSTANT:
            kind = leaf.variability.name.lower()
            raise NotConstant(f"the {kind} `{leaf.name}` has no value", leaf.span)
        return start

    def called(self, frame: Frame) -> Evaluator:
        """An evaluator inside of a call, where only the function's variables exist."""
        return replace(self, frame=frame, closed=True, depth=self.depth + 1)

    def function(self, name: str) -> flat.Function | None:
        """A function that is made already."""
        assert self.session is not None
        return self.session.functions.get(name)

    def _range(self, e: flat.Range) -> Value:
        first, last = self.value(e.start), self.value(e.stop)
        step = 1 if e.step is None else self.value(e.step)
        numbers = all(isinstance(v, int | float) for v in (first, last, step))
        if not numbers:
            raise NotConstant("a range needs numbers", e.span)
        count = range_count(float(first), float(step), float(last), e.span)  # type: ignore[arg-type]
        if count > 10_000_000:
            raise too_large(f"a range of {count:,} values is too long", e.span)
        return [first + k * step for k in range(count)]  # type: ignore[operator]

    def _builtin(self, e: flat.Builtin) -> Value:
        if e.function in compute.IDENTITIES:
            return self.value(e.arguments[-1 if e.function == "smooth" else 0])
        if e.function == "size":
            return self._size(e)
        if e.function == "Enumeration":
            return self._literal(e)
        if not compute.is_known(e.function):
            what = "`time`" if e.function == "time" else f"`{e.function}(...)`"
            raise NotConstant(f"{what} has no value before the run", e.span)
        return compute.apply([self.value(a) for a in e.arguments], e)

    def _literal(self, e: flat.Builtin) -> Value:
        """The literal of a number."""
        number = self.value(e.arguments[0])
        if not isinstance(number, int) or not 1 <= number <= len(e.type.literals):
            raise error("F219", f"`{e.type.name}` has no value {number}", e.span)
        return number

    def _size(self, e: flat.Builtin) -> Value:
        """`size` needs the type only, where that is known."""
        array, *dimension = e.arguments
        dims: list[int | None] = list(array.type.dims)
        if any(d is None for d in dims):
            dims = list(compute.shape(self.value(array)))
        if not dimension:
            return [int(d or 0) for d in dims]
        k = self.value(dimension[0])
        if not isinstance(k, int) or not 1 <= k <= len(dims):
            raise error("F218", f"there is no dimension {k}", e.span)
        return dims[k - 1] or 0

    def _call(self, e: flat.Call) -> Value:
        function = self.function(e.function)
        if function is None:
            raise NotConstant(f"`{e.function}` calls itself", e.span)
        from planarc.flatten.values.interpret import run_function

        arguments = [self.value(a) for a in e.arguments]
        results = run_function(function, arguments, self, e.span)
        return results[e.output or 0]

    def _comprehension(self, e: flat.Comprehension) -> Value:
        sizes = dict.fromkeys(compute.shape(self.value(a))[0] for a in e.alike)
        if len(sizes) > 1:  # of a call for each entry (12.4.6)
            message = f"the arrays of this call differ in size: {listed(map(str, sizes))}"
            raise error("F291", message, e.span)
        return compute.reduce(e.reduce, self._iterate(e, 0, dict(self.frame or {})))

    def _iterate(self, e: flat.Comprehension, k: int, frame: Frame) -> list[Value]:
        if k == len(e.iterators):
            return [replace(self, frame=frame).value(e.body)]
        name, range_ = e.iterators[k]
        values = replace(self, frame=frame).value(range_)
        assert isinstance(values, list)
        found: list[Value] = []
        for value in values:
            inner = self._iterate(e, k + 1, {**frame, name: value})
            nested = e.reduce == "array" and k + 1 < len(e.iterators)
            found += [inner] if nested else inner
        return compute.row(found, e)
