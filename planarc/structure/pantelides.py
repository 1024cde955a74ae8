"""Index reduction: how often each equation must be differentiated.

In:   signature   for each equation its unknowns, each with its highest order there
Out:  Offsets     differentiations of each equation, highest order of each unknown,
                  and a matching of the system of highest derivatives

An equation that ties states together holds no unknown of highest order, so it
has nothing to be solved for. Differentiating it brings the missing unknown in.
Here is decided only *that*; `expand` writes the derivatives.

An unknown is a whole chain x, der(x), ...: it is unknown at its highest order
d. An equation differentiated c times holds that order when d - c is the order in
which the equation itself has x. While some equations find no unknown of highest
order, every equation that competes with them (is reached by alternating paths)
is differentiated once more, and so are the unknowns matched with these.

Example: two inertias on one rigid shaft, index 2.

    e0   J1*der(w1) =  tau       w1: 1, tau: 0     c = 0, matched with tau
    e1   J2*der(w2) = -tau       w2: 1, tau: 0     c = 0, matched with der(w2)
    e2   w1 = w2                 w1: 0, w2: 0      c = 1, matched with der(w1)

Needs:     a complete matching when the orders are disregarded; without it the
           search would not end.
Promises:  the offsets are the smallest ones that `least` allows; all equations
           with an exposed partner are searched at once, so that the number of
           rounds is bounded by the index, not by the size.
Reference: C. C. Pantelides, SIAM J. Sci. Stat. Comput. 9(2), 1988, 213-231;
           the offsets c, d are those of J. D. Pryce, BIT 41(2), 2001, 364-394.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from planarc.core.data import Data
from planarc.structure.graph import reachable
from planarc.structure.matching import Matching, match_equations

#: Unknowns of each equation, with the highest order of each there.
Signature: TypeAlias = Sequence[Sequence[tuple[int, int]]]


class Offsets(Data):
    differentiated: tuple[int, ...]  # c, of each equation
    highest: tuple[int, ...]  # d, of each unknown
    matching: Matching  # of the equations with the unknowns of highest order

    def active(self, signature: Signature) -> list[list[int]]:
        """The unknowns of highest order in each equation, differentiated as it must be."""
        return _active(signature, self.differentiated, self.highest)


def reduce_index(signature: Signature, least: Sequence[int]) -> Offsets:
    """`least[v]` is an order that unknown v must have at least, because results ask for it."""
    c = [0] * len(signature)
    d = list(least)
    for row in signature:
        for v, order in row:
            d[v] = max(d[v], order)
    matching: Matching | None = None
    while True:
        rows = _active(signature, c, d)
        matching = match_equations(rows, len(d), matching)
        if matching.complete:
            return Offsets(tuple(c), tuple(d), matching)
        partner = matching.equation
        competing = reachable(matching.exposed, [[partner[v] for v in row] for row in rows])
        for e, inside in enumerate(competing):
            if inside:
                c[e] += 1
                if matching.variable[e] >= 0:
                    d[matching.variable[e]] += 1


def _active(signature: Signature, c: Sequence[int], d: Sequence[int]) -> list[list[int]]:
    return [[v for v, order in row if d[v] - c[e] == order] for e, row in enumerate(signature)]
