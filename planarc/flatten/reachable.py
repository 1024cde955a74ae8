"""Which functions a flat model calls, directly or through others.

Functions that were only run while compiling are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.flatten.gather import Gathered
from planarc.flatten.occurrences import expressions_in
from planarc.flatten.tree import Session
from planarc.flatten.variability import children
from planarc.ir import flat


def called_functions(
    session: Session,
    variables: Iterable[flat.Variable],
    equations: Iterable[flat.Equation],
    found: Gathered,
) -> tuple[flat.Function, ...]:
    """The functions of the model, in the order in which they were made."""
    wanted: set[str] = set()
    todo: list[str] = []

    def need(expressions: Iterable[flat.Expression]) -> None:
        for name in _calls(expressions):
            if name in session.functions and name not in wanted:
                wanted.add(name)
                todo.append(name)

    for variable in variables:
        need(_of_variable(variable))
    need(expressions_in(equations))
    need(expressions_in(found.initial_equations))
    for algorithm in (*found.algorithms, *found.initial_algorithms):
        need(_of_statements(algorithm.statements))
    for visual in found.visuals:
        need(value for _, value in visual.attributes)
    while todo:
        function = session.functions[todo.pop()]
        inner = [*function.outputs, *function.locals]
        need(e for v in inner for e in _of_variable(v))
        need(_of_statements(function.body))
        for name in _related(function):
            if name in session.functions and name not in wanted:
                wanted.add(name)
                todo.append(name)
    return tuple(f for name, f in session.functions.items() if name in wanted)


def _related(function: flat.Function) -> list[str]:
    names = [name for name, _ in function.derivatives]
    return [*names, function.derivative_of[0]] if function.derivative_of else names


def _of_variable(variable: flat.Variable) -> Iterator[flat.Expression]:
    a = variable.attributes
    values = (variable.binding, a.start, a.fixed, a.min, a.max, a.nominal, *variable.sizes)
    yield from (v for v in values if v is not None)


def _calls(expressions: Iterable[flat.Expression]) -> Iterator[str]:
    stack = list(expressions)
    while stack:
        node = stack.pop()
        if isinstance(node, flat.Call | flat.PartialCall):
            yield node.function
        stack.extend(children(node))


def _of_statements(statements: Iterable[flat.Statement]) -> Iterator[flat.Expression]:
    stack = list(statements)
    while stack:
        statement = stack.pop()
        match statement:
            case flat.Assignment(target=target, value=value):
                yield from (target, value)
            case flat.TupleAssignment(targets=targets, value=call):
                yield from (t for t in targets if t is not None)
                yield call
            case flat.IfStatement(branches=branches, otherwise=otherwise):
                yield from (c for c, _ in branches)
                stack += [s for _, body in branches for s in body] + list(otherwise)
            case flat.WhenStatement(branches=branches):
                yield from (c for c, _ in branches)
                stack += [s for _, body in branches for s in body]
            case flat.ForStatement(range=range_, body=body):
                yield range_
                stack += body
            case flat.WhileStatement(condition=condition, body=body):
                yield condition
                stack += body
            case flat.Assert() | flat.Terminate() | flat.Reinit():
                yield from expressions_in([statement])
