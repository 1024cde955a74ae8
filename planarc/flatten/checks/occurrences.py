"""Which variables expressions and equations name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.ir import flat
from planarc.ir.flatwalk import expressions_of_equations, nodes_of


def references_in(expression: flat.Expression) -> Iterator[flat.Reference]:
    """All references in an expression, from left to right."""
    for node in nodes_of((expression,)):
        if isinstance(node, flat.Reference):
            yield node


def names_in(equations: Iterable[flat.Equation]) -> set[str]:
    """The names of all variables in equations, those of asserts left out."""
    real = (e for e in equations if not isinstance(e, flat.Assert | flat.Terminate))
    nodes = nodes_of(expressions_of_equations(real))
    return {node.name for node in nodes if isinstance(node, flat.Reference)}
