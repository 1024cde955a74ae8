"""Evaluation while compiling: values of constants, parameters and function calls.

In:   flat.Expression
Out:  Value (float, int, bool, str; list for arrays, dict for records)

Array sizes, conditions of components, structural if-equations and ranges of loops
shape the model; the parameters that they depend on are marked structural, which
means that another value of them needs another compilation.

Example: with `parameter Integer n = 2*m; parameter Integer m = 3;` the size of
`Real x[n]` is 6, and both `n` and `m` are structural.

Reference: Modelica Language Specification 3.6, sections 3.8 and 4.5.
"""

from __future__ import annotations

from typing import TypeAlias

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.flatten import bindings, compute, expressions, interpret
from planarc.flatten.conform import expect_scalar
from planarc.flatten.constant import NotConstant, Value, to_expression
from planarc.flatten.environment import Env
from planarc.flatten.tree import Leaf, Scope, Session
from planarc.flatten.variability import variability_of
from planarc.ir import flat, syntax

Frame: TypeAlias = "dict[str, Value]"


def structural_value(expression: flat.Expression, env: Env, what: str) -> Value:
    """The value of an expression that shapes the model; refused when it has none."""
    if isinstance(expression, flat.Literal):
        return expression.value
    try:
        return Evaluator(env.session, mark=True, hidden=env.hidden).value(expression)
    except NotConstant as problem:
        raise error(
            "F281",
            f"{what} must be known when the model is compiled: {problem.reason}",
            problem.span or expression.span,
        ) from None


def try_value(expression: flat.Expression, env: Env, mark: bool = False) -> Value | None:
    """The value, or None when it is not known yet."""
    if isinstance(expression, flat.Literal):
        return expression.value
    try:
        value = Evaluator(env.session, hidden=env.hidden).value(expression)
        if mark:  # only what really had a value is structural
            Evaluator(env.session, mark=True, hidden=env.hidden).value(expression)
        return value
    except NotConstant:
        return None


def literal_value(expression: flat.Expression) -> Value | None:
    """The value of an expression of literals only."""
    if isinstance(expression, flat.Literal):
        return expression.value
    if isinstance(expression, flat.Unary) and expression.op == "not":
        inner = literal_value(expression.operand)
        return None if inner is None else not inner
    if isinstance(expression, flat.Binary):
        left, right = literal_value(expression.left), literal_value(expression.right)
        if left is None or right is None:
            return None
        try:
            return Evaluator(None).value(expression)
        except NotConstant:
            return None
    return None


def evaluate_condition(condition: syntax.Expression, scope: Scope, what: str) -> bool:
    """A structural Boolean."""
    typed = expressions.type_expression(condition, Env(scope))
    expect_scalar(typed, (flat.Base.BOOLEAN,), what)
    return bool(structural_value(typed, Env(scope), what))


def fold_index(index: flat.Expression, env: Env) -> flat.Expression:
    """A subscript as a literal when its value can be known now."""
    if isinstance(index, flat.Literal):
        return index
    if env.function is not None and not index.type.dims:
        return index
    if variability_of(index, env.session, env.hidden) > flat.Variability.PARAMETER:
        return index
    value = try_value(index, env, mark=True)
    return index if value is None else to_expression(value, index.type, index.span)


def range_size(
    start: flat.Expression, step: flat.Expression | None, stop: flat.Expression, env: Env
) -> int | None:
    """The number of values in a range, None when it is known only when run."""
    try:
        values = [
            None if e is None else Evaluator(env.session, mark=True, hidden=env.hidden).value(e)
            for e in (start, step, stop)
        ]
        first, increment, last = (None if v is None else float(v) for v in values)  # type: ignore[arg-type]
    except (NotConstant, TypeError, ValueError):
        return None
    assert first is not None and last is not None
    return range_count(first, 1.0 if increment is None else increment, last, start.span)


def range_count(first: float, step: float, last: float, span: Span) -> int:
    if step == 0:
        raise error("F275", "the step of a range is zero", span)
    return max(0, int((last - first) / step + 1e-12) + 1) if (last - first) / step >= 0 else 0


def package_constant(leaf: Leaf, span: Span) -> flat.Expression:
    """The value of a constant that belongs to a class, not to a component."""
    if leaf.variability is not flat.Variability.CONSTANT:
        raise error(
            "F217",
            f"`{leaf.name}` is no constant: outside of an instance of its class it has no value",
            span,
        )
    try:
        value = Evaluator(leaf.parent.session).leaf_value(leaf)
    except NotConstant as problem:
        raise error(
            "F281",
            f"the constant `{leaf.name}` has no value: {problem.reason}",
            problem.span or leaf.span,
        ) from None
    return to_expression(value, leaf.type, span)


class Evaluator:
    """Values of expressions; `frame` holds the variables of a function being run."""

    def __init__(
        self,
        session: Session | None,
        mark: bool = False,
        frame: Frame | None = None,
        hidden: frozenset[str] = frozenset(),
    ) -> None:
        self.hidden = hidden  # local names, which are no variables of the model
        self.closed = False  # inside a function: only its own variables exist
        self.session = session
        self.mark = mark
        self.frame = frame
        self.depth = 0  # of calls

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
                return [self.value(i) for i in e.items]
            case flat.Range():
                return self._range(e)
            case flat.Index():
                return compute.index(self.value(e.base), self._subscripts(e.subscripts), e.span)
            case flat.Field():
                record = self.value(e.base)
                return _field(record, e.name)
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
        result = compute.binary(e.op, left, self.value(e.right), e.span)
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
                raise NotConstant(f"`{e.name}` is a variable, not a parameter", e.span)
            value = self.leaf_value(leaf)
        if not e.subscripts:
            return value
        return compute.index(value, self._subscripts(e.subscripts), e.span)

    def _leaf(self, name: str) -> Leaf | None:
        if self.session is None or self.closed or name in self.hidden:
            return None
        return self.session.leaves.get(name)

    def _subscripts(self, subscripts: tuple[flat.Expression, ...]) -> list[Value | None]:
        return [None if isinstance(s, flat.Slice) else self.value(s) for s in subscripts]

    def leaf_value(self, leaf: Leaf) -> Value:
        """The value of a constant or parameter from its binding."""
        if leaf.evaluated is not None and (leaf.structural or not self.mark):
            return leaf.evaluated
        if self.mark:
            leaf.structural = True
        binding = bindings.leaf_binding(leaf)
        if binding is None:
            binding = self._from_start(leaf)
        if leaf.evaluating:
            raise error("F282", f"the value of `{leaf.name}` depends on itself", leaf.span)
        leaf.evaluating = True
        try:
            value = Evaluator(self.session, self.mark).value(binding)
        finally:
            leaf.evaluating = False
        leaf.evaluated = _cast(value, leaf.type, binding.type)
        return leaf.evaluated

    def _from_start(self, leaf: Leaf) -> flat.Expression:
        start = bindings.attributes_of(leaf).start
        if start is None or leaf.variability is flat.Variability.CONSTANT:
            kind = leaf.variability.name.lower()
            raise NotConstant(f"the {kind} `{leaf.name}` has no value", leaf.span)
        return start

    def with_frame(self, frame: Frame | None) -> Evaluator:
        inner = Evaluator(self.session, self.mark, frame, self.hidden)
        inner.closed = self.closed
        inner.depth = self.depth
        return inner

    def _range(self, e: flat.Range) -> Value:
        first, last = self.value(e.start), self.value(e.stop)
        step = 1 if e.step is None else self.value(e.step)
        numbers = all(isinstance(v, int | float) for v in (first, last, step))
        if not numbers:
            raise NotConstant("a range needs numbers", e.span)
        count = range_count(float(first), float(step), float(last), e.span)  # type: ignore[arg-type]
        if count > 10_000_000:
            raise error("F252", f"a range of {count:,} values is too long", e.span)
        return [first + k * step for k in range(count)]  # type: ignore[operator]

    def _builtin(self, e: flat.Builtin) -> Value:
        if e.function in compute.IDENTITIES:
            return self.value(e.arguments[-1 if e.function == "smooth" else 0])
        if e.function == "size":
            return self._size(e)
        function = compute.FUNCTIONS.get(e.function)
        if function is None:
            what = "`time`" if e.function == "time" else f"`{e.function}(...)`"
            raise NotConstant(f"{what} has no value before the run", e.span)
        values = [self.value(a) for a in e.arguments]
        return compute.apply(function, values, e)

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

        assert self.session is not None
        function = self.session.functions.get(e.function)
        if function is None:
            raise NotConstant(f"`{e.function}` calls itself", e.span)
        arguments = [self.value(a) for a in e.arguments]
        results = interpret.run_function(function, arguments, self, e.span)
        return results[e.output or 0]

    def _comprehension(self, e: flat.Comprehension) -> Value:
        return compute.reduce(e.reduce, self._iterate(e, 0, dict(self.frame or {})))

    def _iterate(self, e: flat.Comprehension, k: int, frame: Frame) -> list[Value]:
        if k == len(e.iterators):
            return [self.with_frame(frame).value(e.body)]
        name, range_ = e.iterators[k]
        values = self.with_frame(frame).value(range_)
        assert isinstance(values, list)
        found: list[Value] = []
        for value in values:
            inner = self._iterate(e, k + 1, {**frame, name: value})
            nested = e.reduce == "array" and k + 1 < len(e.iterators)
            found += [inner] if nested else inner
        return found


def _field(record: Value, name: str) -> Value:
    if isinstance(record, list):
        return [_field(r, name) for r in record]
    assert isinstance(record, dict)
    return record[name]


def _cast(value: Value, type_: flat.Type, actual: flat.Type) -> Value:
    """An Integer value of a Real variable is a Real."""
    if type_.base is flat.Base.REAL and actual.base is flat.Base.INTEGER:
        return _to_float(value)
    return value


def _to_float(value: Value) -> Value:
    if isinstance(value, list):
        return [_to_float(v) for v in value]
    return float(value) if isinstance(value, int) else value
