"""What holds at the start besides the candidates' own start values.

In:   Attributes, steps, initial equations
Out:  Fixed variables that are no candidates, guesses of torn unknowns of the top level,
      residuals of the initial equations in kept symbols
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs, Substitution, text
from planarc.ir.sorted import Block, Candidate, Fixed, Residual, Step
from planarc.structure.attributes import Attributes


def held_variables(
    table: Exprs, attributes: Mapping[Expr, Attributes], candidates: Iterable[Candidate]
) -> tuple[Fixed, ...]:
    chosen = {c.symbol for c in candidates}
    return tuple(
        Fixed(symbol, a.start if a.start is not None else table.zero, a.display, a.span)
        for symbol, a in attributes.items()
        if a.fixed and symbol not in chosen
    )


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
