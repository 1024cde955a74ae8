"""Walks over the flat model: the parts of expressions, the expressions of equations.

All walks are iterative and keep the order of the text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from operator import attrgetter
from typing import Any, TypeVar

from planarc.ir import flat

Item = TypeVar("Item", bound=flat.EquationNode)  # an equation or a statement


def children(expression: flat.Expression) -> tuple[flat.Expression, ...]:
    """The direct parts of an expression."""
    parts: tuple[flat.Expression, ...] = _PARTS[type(expression)](expression)
    return parts


def _nothing(_: flat.Expression) -> tuple[flat.Expression, ...]:
    return ()


_PARTS: dict[type, Callable[[Any], tuple[flat.Expression, ...]]] = {
    flat.Literal: _nothing,
    flat.Slice: _nothing,
    flat.Reference: attrgetter("subscripts"),
    flat.Unary: lambda e: (e.operand,),
    flat.Binary: attrgetter("left", "right"),
    flat.If: lambda e: (*chain(*e.branches), e.otherwise),
    flat.Array: attrgetter("items"),
    flat.Record: attrgetter("items"),
    flat.Range: lambda e: (e.start, e.stop) if e.step is None else (e.start, e.step, e.stop),
    flat.Index: lambda e: (e.base, *e.subscripts),
    flat.Field: lambda e: (e.base,),
    flat.Builtin: attrgetter("arguments"),
    flat.Call: attrgetter("arguments"),
    flat.PartialCall: lambda e: tuple(value for _, value in e.bound),
    flat.Comprehension: lambda e: (e.body, *(value for _, value in e.iterators)),
}


def nodes_of(expressions: Iterable[flat.Expression]) -> Iterator[flat.Expression]:
    """Expressions and all their parts, from left to right."""
    stack = list(expressions)
    stack.reverse()
    while stack:
        node = stack.pop()
        yield node
        if parts := _PARTS[type(node)](node):
            stack += parts[::-1]


def names_in(expressions: Iterable[flat.Expression]) -> set[str]:
    """The variables that expressions name."""
    return {node.name for node in nodes_of(expressions) if isinstance(node, flat.Reference)}


#: Operators that lead from one clock to another, and those that lead out of a clocked part.
CONVERSIONS = frozenset({"subSample", "superSample", "shiftSample", "backSample"})
OUTWARDS = frozenset({"hold", "noClock"})


def is_clock(e: flat.Expression) -> bool:
    return e.type.base is flat.Base.CLOCK


def is_clocked_sample(e: flat.Builtin) -> bool:
    """Whether it is `sample(u)` or `sample(u, clock)`, and not `sample(start, interval)`."""
    if e.function != "sample":
        return False
    return len(e.arguments) == 1 or is_clock(e.arguments[1])


def is_false(value: flat.Expression | None) -> bool:
    """True for the literal `false`, and for an array of such."""
    if isinstance(value, flat.Array):
        return bool(value.items) and all(map(is_false, value.items))
    return isinstance(value, flat.Literal) and value.value is False


def expressions_of_variable(variable: flat.Variable) -> Iterator[flat.Expression]:
    """The binding, the attributes, and the sizes."""
    a = variable.attributes
    values = (variable.binding, a.start, a.fixed, a.min, a.max, a.nominal, *variable.sizes)
    yield from (v for v in values if v is not None)


def inside(items: Iterable[Item], whens: bool = True) -> Iterator[Item]:
    """Equations or statements, and those in their branches and loops; without `whens`, not
    those in when-clauses."""
    stack: list[Any] = list(items)
    stack.reverse()
    while stack:
        item = stack.pop()
        yield item
        match item:
            case flat.IfEquation(otherwise=otherwise) | flat.IfStatement(otherwise=otherwise):
                stack.extend(reversed([*chain(*(b for _, b in item.branches)), *otherwise]))
            case flat.WhenEquation() | flat.WhenStatement() if whens:
                stack.extend(reversed([*chain(*(b for _, b in item.branches))]))
            case flat.ForStatement(body=body) | flat.WhileStatement(body=body):
                stack.extend(reversed(body))


def expressions_in(items: Iterable[Item]) -> Iterator[flat.Expression]:
    """The expressions of equations or statements, targets and those inside branches and loops
    too."""
    for item in inside(items):
        match item:
            case flat.Equality(left=left, right=right):
                parts = left.items if isinstance(left, flat.Targets) else (left,)
                yield from (i for i in parts if i is not None)
                yield right
            case flat.Assignment(target=target, value=value):
                yield from (target, value)
            case flat.TupleAssignment(targets=targets, value=call):
                yield from (t for t in targets if t is not None)
                yield call
            case (
                flat.IfEquation() | flat.IfStatement() | flat.WhenEquation() | flat.WhenStatement()
            ):
                yield from (c for c, _ in item.branches)
            case flat.ForStatement(range=range_):
                yield range_
            case flat.WhileStatement(condition=condition):
                yield condition
            case flat.Reinit(variable=variable, value=value):
                yield from (variable, value)
            case flat.Assert(condition=condition, message=message):
                yield from (condition, message)
            case flat.Terminate(message=message):
                yield message
            case flat.Impact(arguments=arguments):
                yield from arguments


def set_by(item: Item) -> Iterator[flat.Reference]:
    """The variables that an assignment sets, or an equation of a when-clause: those that stand
    alone on its left, as whole records, too."""
    targets: Sequence[flat.Expression | None] = ()
    match item:
        case flat.Equality(left=flat.Targets(items)) | flat.TupleAssignment(targets=items):
            targets = items
        case flat.Assignment(target=target):
            targets = (target,)
        case flat.Equality(left=left) if not isinstance(left, flat.Targets):
            targets = (left,)
    for each in targets:
        if each is not None:
            yield from variables_of_target(each)


def assigned_in(statements: Iterable[flat.Statement], whens: bool = True) -> list[str]:
    """The variables that statements assign, each once."""
    return list(dict.fromkeys(v.name for s in inside(statements, whens) for v in set_by(s)))


def with_sources(names: Iterable[str], statements: Iterable[flat.Statement]) -> set[str]:
    """Variables with those that they are assigned from, and these from others."""
    found, grown = set(names), True
    sources = list(_assigned_from(statements))
    while grown:
        before = len(found)
        for target, read in sources:
            if target in found:
                found |= read
        grown = len(found) > before
    return found


def _assigned_from(statements: Iterable[flat.Statement]) -> Iterator[tuple[str, set[str]]]:
    """Each variable that is assigned, with those in its new value."""
    for statement in inside(statements):
        if isinstance(statement, flat.Assignment | flat.TupleAssignment):
            for variable in set_by(statement):
                yield variable.name, names_in((statement.value,))


def variables_of_target(target: flat.Expression) -> Iterator[flat.Reference]:
    """The variables that an assignment sets, in their order."""
    stack = [target]
    while stack:
        match stack.pop():
            case flat.Reference() as variable:
                yield variable
            case flat.Record(items=items) | flat.Array(items=items):
                stack.extend(reversed(items))


def expressions_of_function(function: flat.Function) -> Iterator[flat.Expression]:
    for variable in (*function.inputs, *function.outputs, *function.locals):
        yield from expressions_of_variable(variable)
    yield from expressions_in(function.body)
    yield from function.given


def expressions_of_model(model: flat.FlatModel) -> Iterator[flat.Expression]:
    """The expressions of a model, without those of its functions."""
    for variable in model.variables:
        yield from expressions_of_variable(variable)
    yield from expressions_in(model.initial_equations)
    yield from expressions_in(model.equations)
    for algorithm in (*model.initial_algorithms, *model.algorithms):
        yield from expressions_in(algorithm.statements)
    for visual in model.visuals:
        yield from (value for _, value in visual.attributes)
    yield from (declared.value for declared in model.declared)


def functions_called(
    expressions: Iterable[flat.Expression], functions: Mapping[str, flat.Function]
) -> set[str]:
    """The names of the functions that expressions call, directly or through others."""
    called: set[str] = set()
    todo = list(_calls(expressions))
    while todo:
        name = todo.pop()
        if name in called or name not in functions:
            continue
        called.add(name)
        function = functions[name]
        todo += _calls(expressions_of_function(function))
        todo += [derivative.function for derivative in function.derivatives]
        if function.derivative_of is not None:
            todo.append(function.derivative_of[0])
    return called


def _calls(expressions: Iterable[flat.Expression]) -> Iterator[str]:
    for node in nodes_of(expressions):
        if isinstance(node, flat.Call | flat.PartialCall):
            yield node.function
