"""The checker of the flat model: what every FlatModel promises to `lower`.

In:   FlatModel
Out:  nothing, or BrokenPromise, which is a bug of `flatten` and never the user's fault

Checked: names are declared once, every reference is declared and its subscripts fit,
the sides of equations have one type, calls have all arguments of their function,
bindings fit their variables, conditions are Boolean.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from planarc.core.data import Data
from planarc.ir import flat
from planarc.ir.flatwalk import children, expressions_in, expressions_of_variable, is_clock

_NUMERIC = (flat.Base.REAL, flat.Base.INTEGER)
_LITERALS: Mapping[flat.Base, type | tuple[type, ...]] = {
    flat.Base.REAL: (float, int),
    flat.Base.INTEGER: int,
    flat.Base.BOOLEAN: bool,
    flat.Base.STRING: str,
    flat.Base.ENUMERATION: int,
}


class BrokenPromise(AssertionError):
    """The flat model breaks one of its invariants."""


def check_model(model: flat.FlatModel) -> None:
    """Raise BrokenPromise when the model breaks an invariant."""
    for complaint in _complaints(model):
        raise BrokenPromise(complaint)


def _complaints(model: flat.FlatModel) -> Iterator[str]:
    functions = {f.name: f for f in model.functions}
    scope = _Scope({v.name: v.type for v in model.variables}, functions)
    if len(scope.types) != len(model.variables):
        yield "a variable is declared twice"
    if len(functions) != len(model.functions):
        yield "a function is declared twice"
    yield from scope.variables(model.variables)
    for equation in (*model.equations, *model.initial_equations):
        yield from _in(f"an equation of `{equation.component}`", scope.items((equation,)))
    for algorithm in (*model.algorithms, *model.initial_algorithms):
        place = f"an algorithm of `{algorithm.component}`"
        yield from _in(place, scope.items(algorithm.statements))
    for function in model.functions:
        own = (*function.inputs, *function.outputs, *function.locals)
        inside = _Scope({v.name: v.type for v in own}, functions)
        yield from inside.variables(own)
        place = f"the function `{function.name}`"
        yield from _in(place, inside.items(function.body))
        yield from _in(place, inside.expressions(function.given))
        if not set(function.results) <= {v.name for v in function.outputs}:
            yield f"an external function sets what is no output in {place}"
    drawn = [value for visual in model.visuals for _, value in visual.attributes]
    yield from _in("a visual", scope.expressions(drawn))
    declared = [d.value for d in model.declared]
    yield from _in("what a component declares", scope.expressions(declared))


def _in(place: str, complaints: Iterable[str]) -> Iterator[str]:
    return (f"{complaint} in {place}" for complaint in complaints)


class _Scope(Data):
    """The names that expressions may refer to."""

    types: Mapping[str, flat.Type]
    functions: Mapping[str, flat.Function]

    def variables(self, variables: Iterable[flat.Variable]) -> Iterator[str]:
        for v in variables:
            yield from _in(f"the declaration of `{v.name}`", self._variable(v))

    def _variable(self, v: flat.Variable) -> Iterator[str]:
        a = v.attributes
        for value in (a.start, a.fixed, a.min, a.max, a.nominal):
            if value is not None and value.type.dims not in ((), v.type.dims):
                yield "an attribute has other dimensions than its variable"
        yield from self.expressions(expressions_of_variable(v))
        if v.binding is not None and not same_shape(v.type, v.binding.type):
            yield "the binding has another type"

    def items(self, items: Iterable[flat.Equation | flat.Statement]) -> Iterator[str]:
        """Equations or statements, those inside of others too."""
        everything = list(_with_inner(items))
        loops = [i for i in everything if isinstance(i, flat.ForStatement)]
        iterators = {loop.iterator: loop.range.type.element() for loop in loops}
        inside = _Scope({**self.types, **iterators}, self.functions)
        for item in everything:
            yield from _of_item(item)
        yield from inside.expressions(expressions_in(items))

    def expressions(self, roots: Iterable[flat.Expression]) -> Iterator[str]:
        stack = list(roots)
        while stack:
            node = stack.pop()
            yield from self._of_node(node)
            if not isinstance(node, flat.Comprehension):  # its body sees its own iterators
                stack.extend(children(node))

    def _of_node(self, node: flat.Expression) -> Iterator[str]:
        match node:
            case flat.Reference():
                yield from self._reference(node)
            case flat.Call(function=name):
                local = self.types.get(name)
                function = self.functions.get(name)
                if local is not None and local.base is flat.Base.FUNCTION:
                    return
                if function is None:
                    yield f"the function `{name}` is not declared"
                elif len(function.inputs) != len(node.arguments):
                    yield f"the call of `{name}` is not complete"
            case flat.Record() if len(node.items) != len(node.type.fields):
                yield f"the record {node.type.name} lacks fields"
            case flat.Array() if node.type.dims[:1] != (len(node.items),):
                yield "an array has another length than its type"
            case flat.If(branches=branches) if not all(_is_truth(c) for c, _ in branches):
                yield "a condition is not Boolean"
            case flat.Literal(value=value) if not isinstance(value, _LITERALS[node.type.base]):
                yield f"the literal {value!r} is no {node.type.base.value}"

    def _reference(self, node: flat.Reference) -> Iterator[str]:
        type_ = self.types.get(node.name)
        if type_ is None:
            record = self.types.get(node.name.partition(".")[0])  # a field that is assigned
            if record is None or record.base is not flat.Base.RECORD:
                yield f"`{node.name}` is not declared"
            return
        if len(node.subscripts) > len(type_.dims):
            yield f"`{node.name}` has too many subscripts"
        for subscript, size in zip(node.subscripts, type_.dims, strict=False):
            number = subscript.value if isinstance(subscript, flat.Literal) else 1
            if size is not None and not 1 <= int(number) <= size:
                yield f"a subscript of `{node.name}` is out of range"


def _with_inner(
    items: Iterable[flat.Equation | flat.Statement],
) -> Iterator[flat.Equation | flat.Statement]:
    for item in items:
        yield item
        for _, body in getattr(item, "branches", ()):
            yield from _with_inner(body)
        yield from _with_inner(getattr(item, "otherwise", ()))
        yield from _with_inner(getattr(item, "body", ()))


def _of_item(item: flat.Equation | flat.Statement) -> Iterator[str]:
    conditions = [c for c, _ in getattr(item, "branches", ())]
    match item:
        case flat.Equality(left=left, right=right) if not isinstance(left, flat.Targets):
            if not same_shape(left.type, right.type):
                yield f"an equation of {left.type} and {right.type}"
        case flat.Assignment() | flat.TupleAssignment():
            targets = (item.target,) if isinstance(item, flat.Assignment) else item.targets
            if not all(target is None or _is_target(target) for target in targets):
                yield "what is assigned is no variable"
        case flat.WhileStatement(condition=condition) | flat.Assert(condition=condition):
            conditions.append(condition)
    clocked = isinstance(item, flat.WhenEquation) and is_clock(conditions[0])
    if not clocked and not all(map(_is_truth, conditions)):
        yield "a condition is not Boolean"


def _is_target(target: flat.Expression) -> bool:
    """Whether it is a variable, or several ones."""
    if isinstance(target, flat.Record | flat.Array):
        return all(map(_is_target, target.items))
    return isinstance(target, flat.Reference)


def _is_truth(condition: flat.Expression) -> bool:
    return condition.type.base is flat.Base.BOOLEAN


def same_shape(left: flat.Type, right: flat.Type) -> bool:
    """Equal but for Integer and Real, and for sizes known only when run."""
    bases = left.base is right.base or (left.base in _NUMERIC and right.base in _NUMERIC)
    pairs = zip(left.dims, right.dims, strict=False)
    return (
        bases
        and len(left.dims) == len(right.dims)
        and all(a is None or b is None or a == b for a, b in pairs)
    )
