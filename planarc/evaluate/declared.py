"""Values of expressions of parameters, which have the values of their declarations."""

from __future__ import annotations

from collections.abc import Container

from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Op


class DeclaredValues:
    """Values of expressions of parameters; KeyError where something else is asked for."""

    def __init__(self, dae: Dae, open_ones: Container[str] = ()) -> None:
        self._declared = {p.name: p.value for p in dae.parameters if p.name not in open_ones}
        self._known: dict[str, float] = {}

    def __call__(self, e: Expr) -> float:
        value: float = evaluate(e, self._leaf)
        return value

    def named(self, *names: str) -> list[float] | None:
        """The values of parameters; None where one is none, or has no value that can be known."""
        try:
            return [self(self._declared[name]) for name in names]
        except (KeyError, ArithmeticError, ValueError):  # as of a function that the user wrote
            return None

    def _leaf(self, e: Expr) -> float:
        if e.op is not Op.SYMBOL:
            raise KeyError(e)
        if e.name not in self._known:
            self._known[e.name] = self(self._declared[e.name])
        return self._known[e.name]
