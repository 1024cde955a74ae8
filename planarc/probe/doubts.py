"""Assertions of the level warning that parameters alone break, told without a run.

In:   Dae
Out:  a warning (R430) for each, at the user's declaration

Parameters have the values of their declarations here; those that follow from the start are left to
the run.

Example: `BodyBox lever(density=7.8, ...)` is of no solid, however it moves.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Op
from planarc.runtime.texts import formatted
from planarc.solve.messages.assertion import assertion_diagnostic


def find_doubts(dae: Dae) -> Iterator[Diagnostic]:
    """The warnings of a model's components about their parameters."""
    values = _Parameters(dae)
    for assertion in (a for a in dae.assertions if a.warning):
        try:
            if values(assertion.condition):
                continue
            texts = [
                part if isinstance(part, str) else formatted(values(part[0]), part[1])
                for part in assertion.message.parts
            ]
        except (KeyError, ArithmeticError, ValueError):
            continue
        yield assertion_diagnostic(dae, None, assertion, "".join(texts))


class _Parameters:
    """Values of expressions of parameters; KeyError where something else is asked for."""

    def __init__(self, dae: Dae) -> None:
        self._declared = {p.name: p.value for p in dae.parameters}
        self._known: dict[str, float] = {}

    def __call__(self, e: Expr) -> float:
        value: float = evaluate(e, self._leaf)
        return value

    def _leaf(self, e: Expr) -> float:
        if e.op is not Op.SYMBOL:
            raise KeyError(e)
        if e.name not in self._known:
            self._known[e.name] = self(self._declared[e.name])
        return self._known[e.name]
