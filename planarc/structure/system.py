"""A level of the reduced system: equations and unknowns that belong together.

At height h below the top stand the equations that are differentiated at least h times,
h derivatives short of their last, and the unknowns likewise. Lower orders of the
unknowns are known there, from the levels below.
"""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct

from planarc.core.data import Data
from planarc.ir.expr import Expr, Exprs, Op
from planarc.structure.algebra import Algebra, Answer
from planarc.structure.expand import Expansion, Form
from planarc.structure.linear import Contents, coefficients, solve_affine
from planarc.structure.pantelides import Offsets
from planarc.structure.signs import Signs

_CONST = Op.CONST  # as in `ir.expr`
#: A number of an equation that is smaller beside another one may be nothing but rounding.
ROUNDING = 1e-15


class Scalar(Data):
    """An equation with its unknowns and, for those it can be solved for, the factor."""

    form: Form
    unknowns: tuple[int, ...]  # numbers in System.unknowns
    factors: Mapping[int, Expr]
    solved: Mapping[int, Answer]  # other closed forms, by the algebraist

    def row(self) -> list[tuple[int, bool]]:
        """Its unknowns, each with whether it is solved for it: beside others, which a method of
        steps looks for, by what has a value everywhere."""
        alone = len(self.unknowns) == 1
        usable = {v for v, answer in self.solved.items() if alone or answer.everywhere}
        return [(v, v in self.factors or v in usable) for v in self.unknowns]


class System(Data):
    height: int
    unknowns: tuple[Expr, ...]
    equations: tuple[Scalar, ...]
    live: tuple[int, ...]  # numbers of the equations among the live ones
    variables: tuple[int, ...]  # numbers of the unknowns among the kept ones


class Systems(Struct):
    """Makes the level systems; the factors of an equation serve all its derivatives."""

    table: Exprs
    contents: Contents
    signs: Signs
    expansion: Expansion
    offsets: Offsets
    names: tuple[str, ...]
    active: list[list[int]]
    algebra: Algebra

    @property
    def heights(self) -> range:
        """The systems from the lowest level up to the top."""
        return range(max(self.offsets.highest, default=0), -1, -1)

    def at(self, height: int) -> System:
        d, c = self.offsets.highest, self.offsets.differentiated
        chosen = [v for v in range(len(d)) if d[v] >= height]
        number = {v: i for i, v in enumerate(chosen)}
        unknowns = tuple(self.table.symbol(self.names[v], d[v] - height) for v in chosen)
        live = tuple(e for e in range(len(c)) if c[e] >= height)
        equations = tuple(self._scalar(e, c[e] - height, number) for e in live)
        return System(height, unknowns, equations, live, tuple(chosen))

    def solve(self, scalar: Scalar, v: int, symbol: Expr) -> Expr:
        """The value of unknown v (`symbol`) from an equation that can be solved for it."""
        if v in scalar.solved:
            return scalar.solved[v].value
        form, factor = scalar.form, scalar.factors[v]
        return solve_affine(self.table, self.contents, form.left, form.right, symbol, factor)

    def _scalar(self, e: int, order: int, number: Mapping[int, int]) -> Scalar:
        form = self.expansion.forms[e][order]
        factors, solved = {}, {}
        active = solvable = self.active[e]
        if form.given:  # it holds other unknowns than its derivatives
            active = [v for v in active if v in number]
            own = {s.name for s in self.contents(form.left)}
            solvable = [v for v in active if self.names[v] in own]
        for v in solvable:
            factor = self._factor(e, order, v)
            if factor is None:
                value = self._closed_form(e, order, v)
                if value is not None:
                    solved[number[v]] = value
            elif self.signs.never_zero(factor):
                factors[number[v]] = factor
        unknowns = tuple(number[v] for v in active)
        return Scalar(form, unknowns, _without_rounding(factors), solved)

    def _closed_form(self, e: int, order: int, v: int) -> Answer | None:
        if order:
            return None  # affine: the tree's rule has decided
        symbol = self.table.symbol(
            self.names[v], self.offsets.highest[v] - self.offsets.differentiated[e]
        )
        return self.algebra.solve(self.expansion.forms[e][0].residual, symbol)

    def _factor(self, e: int, order: int, v: int) -> Expr | None:
        """The factor of unknown v; derivatives are affine in it even where e is not."""
        own = self.offsets.highest[v] - self.offsets.differentiated[e]
        plain = self._of(e, 0).get(self.table.symbol(self.names[v], own))
        if plain is not None or not order:
            return plain
        return self._of(e, 1).get(self.table.symbol(self.names[v], own + 1))

    def _of(self, e: int, order: int) -> Mapping[Expr, Expr | None]:
        return coefficients(self.table, self.contents, self.expansion.forms[e][order].residual)


def _without_rounding(factors: dict[int, Expr]) -> dict[int, Expr]:
    """The factors that may be divided by: a number beside a much larger one may stand for zero, as
    cos(pi/2) = 6e-17 does beside sin(pi/2)."""
    sizes = {v: abs(f.data) for v, f in factors.items() if f.op is _CONST}
    least = ROUNDING * max(sizes.values(), default=0.0)
    return {v: f for v, f in factors.items() if v not in sizes or sizes[v] >= least}
