"""Discrete variables that need each other at one tick of a clock, solved together.

In:   the sides of their equations, and the variables
Out:  the value of each, free of the others; None where whole numbers or truths hang in a circle

Example: 0 = x - pre(x) - h*r,  r = u - x    ->    x := (pre(x) + h*u)/(1 + h),  r := u - x

Eliminates one variable after the other: those that an equation gives as they stand, then those of
linear ones, rather by a factor that never vanishes. What is left is found by Newton's method from
the values at the tick before, in a loop that ends where the last step was next to nothing, so that
what it left behind is exact.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from planarc.ir.calculus import partial
from planarc.ir.closing import close
from planarc.ir.expr import Expr, Exprs, Substitution
from planarc.structure.linear import Contents, coefficients, solve_affine
from planarc.structure.signs import Signs

Sides = tuple[Expr, Expr]

#: The step of Newton's method, relative to the values, behind which one more changes nothing.
_NEXT_TO_NOTHING = 1e-9
#: A step that is larger than all.
_FIRST = 1e300


def solve_together(
    table: Exprs,
    contents: Contents,
    signs: Signs,
    sides: Sequence[Sides],
    unknowns: Sequence[Expr],
    reals: Collection[Expr],
) -> dict[Expr, Expr] | None:
    """The values of unknowns from as many equations left = right; `reals` are those of them that
    Newton's method may move."""
    rows = list(sides)
    open_ = frozenset(unknowns)
    solved: list[tuple[Expr, Expr]] = []
    while rows:
        found = _pivot(table, contents, signs, rows, open_)
        if found is None:
            break
        i, unknown, value = found
        del rows[i]
        solved.append((unknown, value))
        put_in = Substitution(table, {unknown: value})
        rows = [(put_in(left), put_in(right)) for left, right in rows]
        open_ -= {unknown}
    values: dict[Expr, Expr] = {}
    if rows:
        if not open_.issubset(reals):
            return None
        left_over = [u for u in unknowns if u in open_]
        values |= _by_newton(table, signs, [table.sub(*row) for row in rows], left_over)
    for unknown, value in reversed(solved):
        values[unknown] = Substitution(table, values)(value) if values else value
    return values


def _pivot(
    table: Exprs, contents: Contents, signs: Signs, rows: Sequence[Sides], open_: frozenset[Expr]
) -> tuple[int, Expr, Expr] | None:
    """A row, an unknown that it gives, and its value."""
    for i, (left, right) in enumerate(rows):
        for one, other in ((left, right), (right, left)):
            if one in open_ and one not in contents(other):
                return i, one, other
    possible = [
        (i, unknown, factor)
        for i, (left, right) in enumerate(rows)
        for unknown, factor in sorted(coefficients(table, contents, table.sub(left, right)).items())
        if unknown in open_ and factor is not None and not contents(factor) & open_
    ]
    safe = (p for p in possible if signs.never_zero(p[2]))
    best = next(safe, possible[0] if possible else None)
    if best is None:
        return None
    i, unknown, factor = best
    return i, unknown, solve_affine(table, contents, *rows[i], unknown, factor)


def _by_newton(
    table: Exprs, signs: Signs, rows: Sequence[Expr], unknowns: Sequence[Expr]
) -> dict[Expr, Expr]:
    """The unknowns at which all rows vanish, as what a loop leaves behind."""
    steps = [table.symbol(f"$step[{u.name}]") for u in unknowns]
    slopes = [partial(table, u) for u in unknowns]
    linear = [
        (table.add(*(table.mul(d(row), s) for d, s in zip(slopes, steps, strict=True))), row)
        for row in rows
    ]
    names = {s.name for s in steps}
    found = solve_together(table, Contents(names.__contains__), signs, linear, steps, ())
    assert found is not None  # it is linear in the steps
    moves = [found[s] for s in steps]
    size = table.symbol("$step")
    reach = table.add(table.one, *(table.call("abs", u) for u in unknowns))
    goes_on = table.less(table.mul(table.const(_NEXT_TO_NOTHING), reach), size)
    following = [table.sub(u, move) for u, move in zip(unknowns, moves, strict=True)]
    larger = table.add(*(table.call("abs", move) for move in moves))
    loop, given = close("tick", (*unknowns, size), goes_on, (*following, larger))
    start = (*(table.pre(u.name) for u in unknowns), table.const(_FIRST))
    return {u: table.loop(loop, i, (*start, *given)) for i, u in enumerate(unknowns)}
