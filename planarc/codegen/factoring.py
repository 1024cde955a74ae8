"""Takes sums that a variable already holds from that variable.

In:   formulas in the order of evaluation
Out:  the same formulas, shorter

Differentiating a formula by time repeats its parts. With

    x = L*cos(phi),  y = L*sin(phi) + h*cos(phi)

known, what index reduction wrote for their derivatives becomes

    -L*sin(phi)*w - h*cos(phi)*w                  ->  -w*y
    -w^2*(...) as four products                   ->  -w^2*x - z*y

as one would write it by hand. A sum counts as known up to a constant factor, also
when it is only a part of a longer sum, or when all its terms carry a common factor.

Needs:     a variable is learnt when the formulas that follow may use it.
Promises:  equal values but for rounding; no formula gets longer.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeAlias

from planarc.ir.expr import Expr, Exprs, Op, fold
from planarc.ir.sorted import Assignment, Block, Level, Residual, Step

Factor: TypeAlias = tuple[Expr, int]  # base and exponent
Monomial: TypeAlias = frozenset[Factor]
Sum: TypeAlias = dict[Monomial, float]

# Where it counts: an enumeration looks up its members by a function.
_CONST, _ADD, _MUL, _NEG, _POW = Op.CONST, Op.ADD, Op.MUL, Op.NEG, Op.POW

#: Length above which sums are left alone, so that the time stays linear in the model.
LONGEST = 24
#: Number of known sums that are compared for one part of a sum.
MOST = 12


def shorten_levels(table: Exprs, levels: Iterable[Level]) -> tuple[Level, ...]:
    """Shorten the formulas of all levels, each by what stands before it."""
    factoring = Factoring(table)
    return tuple(
        Level(level.height, tuple(_shortened(s, factoring) for s in level.steps))
        for level in levels
    )


def _shortened(step: Step, factoring: Factoring) -> Step:
    if isinstance(step, Assignment):
        value = factoring(step.value)
        factoring.learn((step,))
        return Assignment(step.target, value, step.equation)
    inner = []
    for a in step.inner:
        inner.append(Assignment(a.target, factoring(a.value), a.equation))
        factoring.learn((a,))
    residuals = tuple(Residual(factoring(r.value), r.equation) for r in step.residuals)
    return Block(step.tears, tuple(inner), residuals, step.linear)


class Factoring:
    """The sums that variables hold, and shortening by them."""

    def __init__(self, table: Exprs) -> None:
        self._table = table
        self._learnt: list[Assignment] = []  # since a sum was shortened
        self._known: dict[Monomial, list[tuple[Expr, Sum]]] = {}  # by their first products
        self._sums: dict[Expr, Sum] = {}

    def learn(self, assignments: Iterable[Assignment]) -> None:
        """Note that targets hold their values from here on."""
        self._learnt += assignments

    def __call__(self, root: Expr) -> Expr:
        """The formula with known sums taken from their variables."""
        done: dict[Expr, Expr] = {}

        def shortened(e: Expr) -> Expr:
            if not e.args:
                return e
            e = self._table.rebuild(e, tuple(map(done.__getitem__, e.args)))
            return self._shorten(e) if e.op is _ADD else e

        return fold(root, done, shortened)

    def _shorten(self, e: Expr) -> Expr:
        for a in self._learnt:
            if a.value.op is _ADD and len(a.value.args) <= LONGEST:
                terms = self._sum(a.value)
                if len(terms) > 1 and frozenset() not in terms:
                    self._known.setdefault(next(iter(terms)), []).append((a.target, terms))
        self._learnt.clear()
        if len(e.args) > LONGEST or not self._known:
            return e
        terms = known = self._sum(e)
        while len(terms) > 1 and (found := self._find(terms)) is not None:
            used, monomial, scale = found
            terms = {m: c for m, c in terms.items() if m not in used}
            terms[monomial] = terms.get(monomial, 0.0) + scale
        return e if terms is known else self._written(terms)

    def _sum(self, e: Expr) -> Sum:
        found = self._sums.get(e)
        if found is None:
            found = self._sums[e] = _sum(e)
        return found

    def _find(self, terms: Sum) -> tuple[list[Monomial], Monomial, float] | None:
        """A known sum in the terms: the terms it stands for, and what replaces them."""
        for factor, group in _groups(terms):
            for first in group:
                if first not in self._known:
                    continue
                for symbol, known in self._known[first][:MOST]:
                    scale = group[first] / known[first]
                    if scale and all(group.get(m) == scale * c for m, c in known.items()):
                        used = [m | factor for m in known]
                        return used, _times(symbol, factor), scale
        return None

    def _written(self, terms: Sum) -> Expr:
        t = self._table
        return t.add(
            *(
                t.mul(
                    t.const(c),
                    *(b if n == 1 else t.pow(b, t.const(n)) for b, n in sorted(m, key=_place)),
                )
                for m, c in terms.items()
            )
        )


def _place(factor: Factor) -> int:
    return factor[0].id


def _times(symbol: Expr, factor: Monomial) -> Monomial:
    """symbol*factor, for a factor of at most one base."""
    for base, n in factor:
        if base is symbol:
            return frozenset(((base, n + 1),))
    return factor | {(symbol, 1)}


def _groups(terms: Sum) -> Iterator[tuple[Monomial, Sum]]:
    """The terms, then for each factor that several of them share those terms without it."""
    yield frozenset(), terms
    sharing: dict[Factor, list[Monomial]] = {}
    for m in terms:
        for factor in sorted(m, key=_place) if len(m) > 1 else m:
            sharing.setdefault(factor, []).append(m)
    for factor, monomials in sharing.items():
        if len(monomials) > 1:
            common = frozenset((factor,))
            yield common, {m - common: terms[m] for m in monomials}


def _sum(e: Expr) -> Sum:
    """A sum as products with their numbers."""
    found: Sum = {}
    for term in e.args if e.op is _ADD else (e,):
        scale = 1.0
        if term.op is _NEG:
            scale, term = -1.0, term.args[0]
        factors: dict[Expr, int] = {}
        for f in term.args if term.op is _MUL else (term,):
            if f.op is _CONST:
                scale *= f.data
            elif f.op is _POW and _whole(f.args[1]):
                factors[f.args[0]] = factors.get(f.args[0], 0) + int(f.args[1].data)
            else:
                factors[f] = factors.get(f, 0) + 1
        monomial = frozenset(factors.items())
        found[monomial] = found.get(monomial, 0.0) + scale
    return found


def _whole(exponent: Expr) -> bool:
    return exponent.is_const and exponent.data > 0 and float(exponent.data).is_integer()
