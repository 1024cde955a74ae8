"""Forces that redundant constraints leave open: the equations that make them the smallest.

In:   Dae without the constraints that follow from others; the names of cut forces and torques
Out:  Dae of as many equations as unknowns

Where joints hold a motion more than once, as many forces are open as constraints are redundant:
whatever they are, the motion is the same. Of all forces that fit, those are given whose sum of
squares is the smallest. With the equations c(x) = 0 of the part that is open, differentiated as
index reduction asks, and the cut forces f among its unknowns x, (f - b)*(f - b)/2 is stationary
where, with a multiplier m_e for each equation,

    f_i - b_i + sum_e (dc_e/dx_i)*m_e = 0        of a cut force
                sum_e (dc_e/dx_i)*m_e = 0        of an acceleration, or any other unknown

These are as many equations more as there are unknowns, linear in the multipliers. b is zero; it
is there to be changed, since what changes with it was open (`solve.start.sharing`).

Example: two rods a, b side by side carry p. a + b = p is one equation for two forces. With m:
a + m = 0, b + m = 0, so that a = b = p/2.

Needs:     the left out constraints follow from the others (`solve.start.redundancy`).
Promises:  what the equations determine alone stays as it is; forces depend neither on the order
           of equations and unknowns nor on which of the dependent constraints were left out.
Reference: Lagrange's multipliers; F. E. Udwadia, R. E. Kalaba, Analytical Dynamics, 1996,
           chapter 3, for accelerations that do not depend on how reactions are shared.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import SHARING, Dae, Equation, Kind, Parameter, Variable
from planarc.ir.expr import Expr, Exprs, Op, below
from planarc.ir.flat import StateSelect
from planarc.ir.places import point_home
from planarc.structure.alias import Elimination
from planarc.structure.expand import expand_equations
from planarc.structure.linear import coefficients
from planarc.structure.matching import Parts, find_singular_parts, match_equations
from planarc.structure.pipeline import reduce_aliases
from planarc.structure.signs import Signs


class Shared(Data):
    dae: Dae
    open: int  # cut forces and torques that the equations leave open


def surplus_equations(
    dae: Dae, components: Collection[str] = (), forces: Collection[str] = ()
) -> tuple[int, ...]:
    """The equations that find no unknown, as numbers in the Dae: by structure alone.

    Where there is a choice, those of the `components` find none, what a signal is stays said; and
    of these one without `forces`: what repeats others holds a position, and no balance does.
    """
    reduced = reduce_aliases(dae, Signs(dae.parameters))
    rows, live = reduced.unknowns, reduced.elimination.live
    count = len(reduced.elimination.kept)
    sources = [dae.equations[entry.index] for entry in live]
    others = [
        [] if source.generated or source.component in components else row
        for row, source in zip(rows, sources, strict=True)
    ]
    balances = [
        row if own or _names_any(source, forces) else []
        for row, own, source in zip(rows, others, sources, strict=True)
    ]
    matching = match_equations(balances, count, match_equations(others, count))
    matching = match_equations(rows, count, matching)
    return tuple(live[e].index for e in matching.exposed)


def _names_any(equation: Equation, names: Collection[str]) -> bool:
    sides = below((equation.left, equation.right))
    return any(e.op is Op.SYMBOL and e.name in names for e in sides)


def share_forces(dae: Dae, forces: Sequence[str]) -> Shared:
    """The model with open forces of least squares. `forces` are the variables whose squares are
    summed. The same Dae where nothing is open, or more than these.

    Raises PlanarcError S316 where open forces stand in an equation that is not linear in them.
    """
    reduced = reduce_aliases(dae, Signs(dae.parameters))
    kept = reduced.elimination.kept
    if not match_equations(reduced.unknowns, len(kept)).complete:
        return Shared(dae, 0)
    offsets = reduced.offsets(dae)
    active = offsets.active(reduced.rows)
    parts = find_singular_parts(active, len(kept), offsets.matching)
    open_ = {v: dae.table.symbol(kept[v], offsets.highest[v]) for v in parts.under_variables}
    weights = _Weights(dae.table, reduced.elimination, forces)
    if not open_ or not _are_forces(active, parts, {v for v, s in open_.items() if s in weights}):
        return Shared(dae, 0)
    equations = [(e, reduced.elimination.live[e].index) for e in parts.under_equations]
    multipliers = [_multiplier(k, dae.equations[i]) for k, (_, i) in enumerate(equations, 1)]
    unknown = frozenset(open_.values())
    sums = {symbol: weights.terms(symbol) for symbol in open_.values()}
    forms = expand_equations(dae, reduced.elimination.live, offsets).forms
    for (e, i), multiplier in zip(equations, multipliers, strict=True):
        factors = coefficients(dae.table, reduced.contents, forms[e][-1].residual)
        for symbol in (open_[v] for v in active[e] if v in open_):
            factor = factors[symbol]
            if factor is None or not unknown.isdisjoint(reduced.contents(factor)):
                raise _not_linear(dae, dae.equations[i], symbol)
            sums[symbol].append(dae.table.mul(factor, dae.table.symbol(multiplier.name)))
    stationary = (
        Equation(dae.table.add(*terms), dae.table.zero, component=_owner(symbol))
        for symbol, terms in sums.items()
    )
    bias = Parameter(SHARING, Kind.REAL, dae.table.zero, settable=True, protected=True)
    full = replace(
        dae,
        variables=(*dae.variables, *multipliers),
        parameters=(*dae.parameters, bias),
        equations=(*dae.equations, *stationary),
    )
    return Shared(full, len(open_) - len(equations))


def _are_forces(active: Sequence[Sequence[int]], parts: Parts, forces: set[int]) -> bool:
    """Whether all other unknowns of the open part have an equation, so that forces alone are
    open."""
    of: dict[int, list[int]] = {v: [] for v in parts.under_variables if v not in forces}
    number = {e: i for i, e in enumerate(parts.under_equations)}
    for e, i in number.items():
        for v in active[e]:
            if v in of:
                of[v].append(i)
    return match_equations(list(of.values()), len(number)).complete


class _Weights:
    """The sum of squares, in the symbols that remain: a joint's force may be another's."""

    def __init__(self, table: Exprs, elimination: Elimination, forces: Sequence[str]) -> None:
        self._table = table
        self._counts: dict[Expr, tuple[int, float]] = {}
        for i, name in enumerate(forces):
            e, sign = elimination.rewrite(table.symbol(name)), 1
            if e.op is Op.NEG:
                e, sign = e.args[0], -1
            if e.is_symbol:
                count, bias = self._counts.get(e, (0, 0.0))
                # Any numbers will do for the bias that have nothing to do with each other.
                self._counts[e] = count + 1, bias + sign * math.cos(1.0 + i)

    def __contains__(self, symbol: object) -> bool:
        return symbol in self._counts

    def terms(self, symbol: Expr) -> list[Expr]:
        """The terms of the slope of the sum of squares."""
        if symbol not in self._counts:
            return []
        t, (count, bias) = self._table, self._counts[symbol]
        return [
            t.mul(t.const(float(count)), symbol),
            t.neg(t.mul(t.const(bias), t.symbol(SHARING))),
        ]


def _multiplier(number: int, source: Equation) -> Variable:
    return Variable(
        f"{SHARING}[{number}]",
        state_select=StateSelect.NEVER,
        protected=True,
        component=source.component,
        span=source.span,
    )


def _owner(symbol: Expr) -> str:
    return symbol.name.rpartition(".")[0].rpartition(".")[0]


def _not_linear(dae: Dae, equation: Equation, symbol: Expr) -> PlanarcError:
    found = Diagnostic(
        "S316",
        f"redundant joints leave forces open, and {equation.shown} is not linear in "
        f"`{symbol.name}`: the motion depends on how they are shared",
        equation.span,
        hint="replace a joint by a freer one, so that the equations determine its forces",
    )
    return PlanarcError(point_home(dae, found, equation.component))
