"""The conditions at the start besides the candidates' own start values.

In:   Attributes, steps, initial equations
Out:  start values of variables that are no candidates, guesses of torn unknowns of the
      top level, residuals of the initial equations in kept symbols
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs, Substitution, postorder, text
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import Assignment, Block, Candidate, Fixed, Level, Residual, Step
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
    heights = {a.target: level.height for level in levels for a in _assignments(level)}
    solved_with = _solved_with(levels)
    found = []
    for symbol, a in attributes.items():
        height = heights.get(symbol, 0)
        guide = height > 0 and (a.start_written or a.select >= StateSelect.PREFER)
        if symbol not in chosen and (a.fixed or guide):
            start = a.start if a.start is not None else table.zero
            written = a.fixed or a.start_written
            found.append(
                Fixed(
                    symbol,
                    start,
                    a.display,
                    a.span,
                    a.fixed,
                    written,
                    a.select,
                    solved_with.get(symbol, 0),
                )
            )
    return tuple(found)


def _solved_with(levels: Sequence[Level]) -> dict[Expr, int]:
    """The height of the candidates that each symbol follows from: positions, velocities, or
    0 for what accelerations take part in. A spring's length is computed with the velocities
    or forces, but follows from positions."""
    found: dict[Expr, int] = {}
    below: dict[Expr, int] = {}  # of expressions; the highest level where nothing moves them
    top = max((level.height for level in levels), default=0)

    def lowest(e: Expr) -> int:
        for node in postorder((e,)):
            if node not in below:
                own = found.get(node, top)
                below[node] = min((below[a] for a in node.args), default=own)
        return below[e]

    for level in levels:
        for step in level.steps:
            if isinstance(step, Block):
                found.update(dict.fromkeys(step.tears, level.height))
            for a in step.inner if isinstance(step, Block) else (step,):
                found[a.target] = lowest(a.value)
    return found


def _assignments(level: Level) -> Iterator[Assignment]:
    for step in level.steps:
        yield from step.inner if isinstance(step, Block) else (step,)


def guess_tears(
    steps: Sequence[Step], attributes: Mapping[Expr, Attributes]
) -> tuple[tuple[Expr, Expr], ...]:
    """Start values of the tears of the top level, where the model gives some."""
    found = []
    for step in steps:
        for tear in step.tears if isinstance(step, Block) else ():
            a = attributes.get(tear)
            if a is not None and a.start is not None:
                found.append((tear, a.start))
    return tuple(found)


def initial_residuals(dae: Dae, rewrite: Substitution, first: int) -> tuple[Residual, ...]:
    """`first` is the number of the first initial equation among all equations."""
    found = []
    for i, equation in enumerate(dae.initial_equations):
        value = dae.table.sub(rewrite(equation.left), rewrite(equation.right))
        if value.is_const and value.data != 0:
            raise PlanarcError(
                Diagnostic(
                    "S309",
                    f"the initial equation `{text(equation.left)} = {text(equation.right)}` "
                    f"contradicts the equations: it comes to 0 = {text(value)}",
                    equation.span,
                    hint="remove it",
                )
            )
        if not value.is_const:
            found.append(Residual(value, first + i))
    return tuple(found)
