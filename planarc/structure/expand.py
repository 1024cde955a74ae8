"""Derivatives of the equations, as often as index reduction asks for.

In:   Elimination, Offsets
Out:  Expansion   all equations of the reduced system, each with where it came from

Example: the length of a rod, differentiated twice.

    x*x + y*y = L*L
    2*x*der(x) + 2*y*der(y) = 0
    2*der(x)*der(x) + 2*x*der(der(x)) + ... = 0

The user's equations keep their numbers in the Dae; derivatives follow.

Needs:     no equation that is differentiated holds an input: its derivative is not
           known (an error says so).
Promises:  parameters and discrete variables are constant between events.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.calculus import time_derivative
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Expr, Op, postorder, symbols
from planarc.ir.sorted import SourceEquation
from planarc.structure.alias import Live
from planarc.structure.pantelides import Offsets


class Form(Data):
    """An equation of the reduced system: left = right in kept symbols."""

    index: int  # in Expansion.equations
    left: Expr
    right: Expr
    residual: Expr  # left - right


class Expansion(Data):
    equations: tuple[SourceEquation, ...]
    forms: tuple[tuple[Form, ...], ...]  # of each live equation: itself, derivatives in order


def expand_equations(dae: Dae, live: tuple[Live, ...], offsets: Offsets) -> Expansion:
    table = dae.table
    _refuse_inputs(dae, live, offsets)
    _refuse_delays(dae, live, offsets)
    constant = {p.name for p in dae.parameters} | {v.name for v in dae.discretes}
    derive = time_derivative(table, constant.__contains__)
    equations = [SourceEquation(e) for e in dae.equations]
    forms = []
    for entry, times in zip(live, offsets.differentiated, strict=True):
        left, right = entry.left, entry.right
        tower = [Form(entry.index, left, right, entry.residual)]
        for order in range(1, times + 1):
            left, right = derive(left), derive(right)
            source: Equation = replace(dae.equations[entry.index], left=left, right=right)
            equations.append(SourceEquation(source, tower[-1].index, order))
            tower.append(Form(len(equations) - 1, left, right, table.sub(left, right)))
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


def _refuse_inputs(dae: Dae, live: tuple[Live, ...], offsets: Offsets) -> None:
    names = {v.name for v in dae.inputs}
    wrong = [
        Diagnostic(
            "S306",
            f"the derivative of the input `{symbol.name}` is needed: "
            f"{dae.equations[entry.index].shown} must be differentiated to find the motion",
            dae.equations[entry.index].span,
            hint="give the input through a filter, or prescribe an acceleration",
        )
        for entry, times in zip(live, offsets.differentiated, strict=True)
        for symbol in (symbols(entry.left, entry.right) if names and times else ())
        if symbol.name in names
    ]
    if wrong:
        raise PlanarcError(wrong)
