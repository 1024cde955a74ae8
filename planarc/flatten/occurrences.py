"""Which variables expressions and equations name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.flatten.variability import children
from planarc.ir import flat


def references_in(expression: flat.Expression) -> Iterator[flat.Reference]:
    """All references in an expression, from left to right."""
    stack: list[flat.Expression] = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, flat.Reference):
            yield node
        stack.extend(reversed(children(node)))


def expressions_in(equations: Iterable[flat.Equation]) -> Iterator[flat.Expression]:
    """The expressions of equations, those inside branches too."""
    stack = list(equations)
    while stack:
        equation = stack.pop()
        match equation:
            case flat.Equality(left=left, right=right):
                items = left.items if isinstance(left, flat.Targets) else (left,)
                yield from (i for i in items if i is not None)
                yield right
            case flat.IfEquation(branches=branches, otherwise=otherwise):
                yield from (c for c, _ in branches)
                stack += [e for _, body in branches for e in body] + list(otherwise)
            case flat.WhenEquation(branches=branches):
                yield from (c for c, _ in branches)
                stack += [e for _, body in branches for e in body]
            case flat.Reinit(variable=variable, value=value):
                yield variable
                yield value
            case flat.Assert(condition=condition, message=message):
                yield condition
                yield message
            case flat.Terminate(message=message):
                yield message


def names_in(equations: Iterable[flat.Equation]) -> set[str]:
    """The names of all variables in equations."""
    return {r.name for e in expressions_in(equations) for r in references_in(e)}
