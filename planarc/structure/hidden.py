"""Constraints between states that cancelling terms hide.

In:   the equations that remain after alias elimination
Out:  the same, where one that follows from others but for such a constraint is the constraint

Matching and index reduction see which unknowns stand in an equation, not that they cancel when
equations are added. Linear equations whose factors are whole numbers (voltages between nodes,
currents at nodes) are therefore eliminated by numbers: where a combination of k + 1 of them holds
differentiated unknowns only, though these equations name more than k others, it takes the place of
the last one.

Example: two capacitors in parallel, one turned round.

    v1 = p - n                          v1 = p - n
    v2 = n - p                          0 = v1 + v2
    c1*der(v1) = i1, c2*der(v2) = i2    (unchanged)

Promises:  the solutions are the same; equations without such a constraint stay as they are.
Reference: M. Otter, H. Elmqvist, Transformation of differential algebraic array equations to
           index one form, Modelica Conference 2017, section on linear Integer equations.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from math import gcd

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.expr import Expr, Exprs, Substitution
from planarc.structure.alias import Live
from planarc.structure.linear import Contents, coefficients

#: Combinations of more terms than this are not looked at.
MOST_TERMS = 24


class Row(Data):
    """Whole multiples of unknowns and a rest without any, which add up to zero."""

    terms: dict[Expr, int]
    rest: Expr
    used: frozenset[int]  # the equations that it is made of

    def without(self, table: Exprs, pivot: Expr, other: Row) -> Row:
        """The combination with another row in which the pivot cancels."""
        a, b = other.terms[pivot], -self.terms[pivot]
        common = gcd(a, b)
        a, b = a // common, b // common
        terms = {x: a * c for x, c in self.terms.items()}
        for x, c in other.terms.items():
            terms[x] = terms.get(x, 0) + b * c
        rest = table.add(
            table.mul(table.const(a), self.rest), table.mul(table.const(b), other.rest)
        )
        return Row({x: c for x, c in terms.items() if c}, rest, self.used | other.used)


def uncover_constraints(table: Exprs, contents: Contents, live: Sequence[Live]) -> list[Live]:
    """The equations, with hidden constraints in the place of what follows from others."""
    states = {
        x.name for e in live for x in contents(e.left) | contents(e.right) if x.order
    }  # differentiated ones
    rows = {k: row for k, e in enumerate(live) if (row := _row(table, contents, k, e)) is not None}
    others = {k: _others(row.terms, states) for k, row in rows.items()}
    pivots: dict[Expr, tuple[int, Row]] = {}  # in the order in which they were found
    result = list(live)
    for k, first in rows.items():
        row = _reduced(table, first, pivots)
        if row is None:
            continue
        free = _others(row.terms, states)
        if free:
            pivots[min(free, key=lambda x: x.id)] = len(pivots), row
        elif row.terms and len(frozenset().union(*(others[i] for i in row.used))) >= len(row.used):
            total = (table.mul(table.const(c), x) for x, c in row.terms.items())
            result[k] = replace(live[k], left=table.zero, right=table.add(*total, row.rest))
    return result


def _row(table: Exprs, contents: Contents, k: int, e: Live) -> Row | None:
    """An equation of unknowns, none of them differentiated, with whole numbers as factors."""
    root = table.sub(e.left, e.right)
    inside = contents(root)
    if not 0 < len(inside) <= MOST_TERMS or any(x.order for x in inside):
        return None
    factors = coefficients(table, contents, root)
    if not all(
        f is not None and f.is_const and float(f.data).is_integer() for f in factors.values()
    ):
        return None
    terms = {x: int(f.data) for x, f in factors.items() if f is not None}
    rest = Substitution(table, dict.fromkeys(terms, table.zero))(root)
    return Row(terms, rest, frozenset((k,)))


def _is_whole(factor: Expr) -> bool:
    return factor.is_const and float(factor.data).is_integer()


def _others(unknowns: Iterable[Expr], states: Collection[str]) -> frozenset[Expr]:
    return frozenset(x for x in unknowns if x.name not in states)


def _reduced(table: Exprs, row: Row, pivots: dict[Expr, tuple[int, Row]]) -> Row | None:
    """The row without the unknowns that others are solved for; None where it grows long."""
    while present := [x for x in row.terms if x in pivots]:
        first = min(present, key=lambda x: pivots[x][0])
        row = row.without(table, first, pivots[first][1])
        if len(row.terms) > MOST_TERMS:
            return None
    return row
