"""Discrete variables that need each other at one tick of a clock, solved together.

In:   the sides of their equations, and the variables
Out:  the value of each, free of the others; None where the equations are not linear in them

Example: 0 = x - pre(x) - h*r,  r = u - x    ->    x := (pre(x) + h*u)/(1 + h),  r := u - x

Eliminates one variable after the other, rather by a factor that never vanishes.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.expr import Expr, Exprs, Substitution
from planarc.structure.linear import Contents, coefficients, solve_affine
from planarc.structure.signs import Signs


def solve_together(
    table: Exprs,
    contents: Contents,
    signs: Signs,
    sides: Sequence[tuple[Expr, Expr]],
    unknowns: Sequence[Expr],
) -> dict[Expr, Expr] | None:
    """The values of unknowns from as many equations left = right."""
    rows = [table.sub(left, right) for left, right in sides]
    open_ = frozenset(unknowns)
    solved: list[tuple[Expr, Expr]] = []
    while rows:
        found = _pivot(table, contents, signs, rows, open_)
        if found is None:
            return None
        i, unknown, factor = found
        value = solve_affine(table, contents, rows.pop(i), table.zero, unknown, factor)
        solved.append((unknown, value))
        rows = [Substitution(table, {unknown: value})(row) for row in rows]
        open_ -= {unknown}
    values: dict[Expr, Expr] = {}
    for unknown, value in reversed(solved):
        values[unknown] = Substitution(table, values)(value) if values else value
    return values


def _pivot(
    table: Exprs, contents: Contents, signs: Signs, rows: Sequence[Expr], open_: frozenset[Expr]
) -> tuple[int, Expr, Expr] | None:
    """A row, an unknown that it gives, and its factor there."""
    possible = [
        (i, unknown, factor)
        for i, row in enumerate(rows)
        for unknown, factor in sorted(coefficients(table, contents, row).items())
        if unknown in open_ and factor is not None and not contents(factor) & open_
    ]
    safe = (p for p in possible if signs.never_zero(p[2]))
    return next(safe, possible[0] if possible else None)
