"""The conditions at the start besides the candidates' own start values.

In:   Attributes, steps, initial equations
Out:  start values of variables that are no candidates, guesses of torn unknowns of the
      top level, residuals of the initial equations in kept symbols
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs, Substitution, fold, text
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import Candidate, Fixed, Level, Residual, Step
from planarc.structure.attributes import Attributes


def held_variables(
    table: Exprs,
    attributes: Mapping[Expr, Attributes],
    candidates: Iterable[Candidate],
    levels: Iterable[Level],
) -> tuple[Fixed, ...]:
    """Fixed variables, and what could have been a state and has a start or is a joint's."""
    chosen = {c.symbol for c in candidates}
    levels = tuple(levels)
    heights = {a.target: lv.height for lv in levels for step in lv.steps for a in step.inner}
    solved_with = _solved_with(levels)
    found = []
    for symbol, a in attributes.items():
        height = heights.get(symbol, 0)
        guide = height > 0 and (a.start_written or a.select >= StateSelect.PREFER)
        if symbol not in chosen and (a.fixed or guide):
            start = a.start if a.start is not None else table.zero
            written = a.fixed or a.start_written
            given = (start, a.display, a.span, a.fixed, written, a.select)
            found.append(Fixed(symbol, *given, solved_with.get(symbol, 0), a.holder))
    return tuple(found)


def _solved_with(levels: Sequence[Level]) -> dict[Expr, int]:
    """The height of the candidates that each symbol follows from: positions, velocities, or
    0 for what accelerations take part in. A spring's length is computed with the velocities
    or forces, but follows from positions."""
    found: dict[Expr, int] = {}
    below: dict[Expr, int] = {}  # of expressions; the highest level where nothing moves them
    top = max((level.height for level in levels), default=0)

    def lowest(e: Expr) -> int:
        return min([below[a] for a in e.args]) if e.args else found.get(e, top)

    for level in levels:
        for step in level.steps:
            found.update(dict.fromkeys(step.tears, level.height))
            for a in step.inner:
                found[a.target] = fold(a.value, below, lowest)
    return found


def guess_tears(
    steps: Sequence[Step], attributes: Mapping[Expr, Attributes]
) -> tuple[tuple[Expr, Expr], ...]:
    """Start values of the tears of the top level, where the model gives some."""
    tears = ((tear, attributes.get(tear)) for step in steps for tear in step.tears)
    return tuple((tear, a.start) for tear, a in tears if a is not None and a.start is not None)


def initial_residuals(dae: Dae, rewrite: Substitution, first: int) -> tuple[Residual, ...]:
    """The residuals of the initial equations. `first` is the number of the first initial equation
    among all equations."""
    found = []
    for i, equation in enumerate(dae.initial_equations):
        value = dae.table.sub(rewrite(equation.left), rewrite(equation.right))
        if value.is_const and value.data != 0:
            message = (
                f"the initial equation {equation.shown} contradicts the equations: it comes to"
            )
            problem = f"{message} 0 = {text(value)}"
            raise PlanarcError(Diagnostic("S309", problem, equation.span, hint="remove it"))
        if not value.is_const:
            found.append(Residual(value, first + i))
    return tuple(found)
