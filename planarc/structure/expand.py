"""Derivatives of the equations, as often as index reduction asks for.

In:   Elimination, Offsets
Out:  Expansion   all equations of the reduced system, each with where it came from

Example: the length of a rod, differentiated twice.

    x*x + y*y = L*L
    2*x*der(x) + 2*y*der(y) = 0
    2*der(x)*der(x) + 2*x*der(der(x)) + ... = 0

The user's equations keep their numbers in the Dae; derivatives follow.

Needs:     no input of the model is differentiated more than twice (an error says so).
Promises:  parameters and discrete variables are constant between events.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.unit import rate_text
from planarc.ir.calculus import time_derivative
from planarc.ir.dae import Dae, Equation, Kind, Variable
from planarc.ir.expr import Expr, Op, postorder, symbol_text, symbols
from planarc.ir.sorted import SourceEquation
from planarc.structure.alias import Live
from planarc.structure.pantelides import Offsets

#: The highest derivative of an input that is known: that of a spline through its points.
HIGHEST = 2


class Form(Data):
    """An equation of the reduced system: left = right in kept symbols."""

    index: int  # in Expansion.equations
    left: Expr
    right: Expr
    residual: Expr  # left - right
    given: bool = False  # it gives `left` a value whose derivatives are given, too


class Expansion(Data):
    equations: tuple[SourceEquation, ...]
    forms: tuple[tuple[Form, ...], ...]  # of each live equation: itself, derivatives in order


def expand_equations(dae: Dae, live: tuple[Live, ...], offsets: Offsets) -> Expansion:
    table = dae.table
    _refuse_delays(dae, live, offsets)
    counted = [v.name for v in dae.inputs if v.kind is not Kind.REAL]
    constant = {p.name for p in dae.parameters} | {v.name for v in dae.discretes}.union(counted)
    derive = time_derivative(table, constant.__contains__)
    equations = [SourceEquation(e) for e in dae.equations]
    forms = []
    for entry, times in zip(live, offsets.differentiated, strict=True):
        left, right = entry.left, entry.right
        given = bool(entry.rates)
        tower = [Form(entry.index, left, right, entry.residual, given)]
        for order in range(1, times + 1):
            left = derive(left)
            right = entry.rates[order - 1] if order <= len(entry.rates) else derive(right)
            source: Equation = replace(dae.equations[entry.index], left=left, right=right)
            equations.append(SourceEquation(source, tower[-1].index, order))
            tower.append(Form(len(equations) - 1, left, right, table.sub(left, right), given))
        forms.append(tuple(tower))
    return Expansion(tuple(equations), tuple(forms))


def _refuse_delays(dae: Dae, live: tuple[Live, ...], offsets: Offsets) -> None:
    """The past is as smooth as the integrator's steps: its second derivative is not known."""
    wrong = {}
    for entry, times in zip(live, offsets.differentiated, strict=True):
        for e in postorder((entry.left, entry.right)) if dae.delays and times > 1 else ():
            if e.op is Op.PAST:
                wrong[e.data[0]] = times
    if wrong:
        raise PlanarcError(
            Diagnostic(
                "S315",
                f"`{dae.delays[i].text}` must be differentiated {times} times to find the motion",
                dae.delays[i].span,
                hint="delay a derivative, `delay(der(x), T)`, and integrate it",
            )
            for i, times in sorted(wrong.items())
        )


def derivatives_of_inputs(
    dae: Dae, expansion: Expansion, rest: Iterable[Expr]
) -> tuple[Variable, ...]:
    """The derivatives of inputs that values need: they are given from outside, too."""
    known = {v.name: v for v in dae.inputs}
    users = {
        symbol: e.equation
        for e in reversed(expansion.equations if known else ())
        for symbol in symbols(e.equation.left, e.equation.right)
        if symbol.order and symbol.name in known
    }
    wrong = {s.name: s for s in sorted(users, key=_order) if s.order > HIGHEST}
    if wrong:
        raise PlanarcError(
            Diagnostic(
                "S306",
                f"a derivative of order {s.order} of the input `{s.name}` is needed: "
                f"{users[s].shown} must be differentiated to find the motion",
                users[s].span,
                hint="give the input through a filter, or prescribe an acceleration",
            )
            for s in wrong.values()
        )
    others = (s for s in (symbols(*rest) if known else ()) if s.order and s.name in known)
    found = sorted(dict.fromkeys((*users, *others)), key=_order)
    return tuple(_derivative(known[s.name], s) for s in found)


def _order(symbol: Expr) -> tuple[int, str]:
    return symbol.order, symbol.name


def _derivative(of: Variable, symbol: Expr) -> Variable:
    unit = of.unit
    for _ in range(symbol.order):
        unit = rate_text(unit)
    name = symbol_text(symbol.name, symbol.order)
    return Variable(name, unit=unit, causality="input", component=of.component, span=of.span)
