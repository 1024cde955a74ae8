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

from collections.abc import Collection, Iterable, Mapping, Sequence
from math import gcd

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
        x.data[0] for e in live for x in contents(e.left) | contents(e.right) if x.data[1]
    }  # differentiated ones
    whole = {k: x for k, e in enumerate(live) if (x := _terms(table, contents, e))}
    others = {k: _others(terms, states) for k, terms in whole.items()}
    pivots: dict[Expr, tuple[int, Row]] = {}  # in the order in which they were found
    result = list(live)
    for k in _shared(others):
        row = _reduced(table, _row(table, k, live[k], whole[k]), pivots)
        if row is None:
            continue
        free = _others(row.terms, states)
        if free:
            pivots[min(free, key=lambda x: x.id)] = len(pivots), row
        elif row.terms and len(frozenset().union(*(others[i] for i in row.used))) >= len(row.used):
            terms = (table.mul(table.const(c), x) for x, c in row.terms.items())
            total = table.add(*terms, row.rest)
            result[k] = Live(live[k].index, table.zero, total, table.neg(total))
    return result


def _terms(table: Exprs, contents: Contents, e: Live) -> dict[Expr, int]:
    """The factors of an equation of unknowns, none of them differentiated, where all of them are
    whole numbers; else nothing."""
    inside = contents(e.residual)
    if e.rates or not 0 < len(inside) <= MOST_TERMS or any(x.data[1] for x in inside):
        return {}
    factors = coefficients(table, contents, e.residual)
    terms = {x: int(f.data) for x, f in factors.items() if f is not None and _is_whole(f)}
    return terms if len(terms) == len(factors) else {}


def _row(table: Exprs, k: int, e: Live, terms: dict[Expr, int]) -> Row:
    without = Substitution(table, dict.fromkeys(terms, table.zero))
    return Row(terms, without(e.residual), frozenset((k,)))


def _shared(others: Mapping[int, frozenset[Expr]]) -> list[int]:
    """The rows in which every unknown may cancel: each of theirs stands in another one, too."""
    holders: dict[Expr, set[int]] = {}
    for k, unknowns in others.items():
        for x in unknowns:
            holders.setdefault(x, set()).add(k)
    dropped: set[int] = set()
    stack = [k for found in holders.values() if len(found) == 1 for k in found]
    while stack:
        k = stack.pop()
        if k not in dropped:
            dropped.add(k)
            for x in others[k]:
                holders[x].discard(k)
                stack += holders[x] if len(holders[x]) == 1 else ()
    return [k for k in others if k not in dropped]


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
