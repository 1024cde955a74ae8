"""Values of parameter expressions with the parameters as the model sets them.

Only for messages and for comparing two start values: a parameter may be set to
another value without compiling again.
"""

from __future__ import annotations

import math
from typing import Any

from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr


class ParameterNumbers:
    def __init__(self, dae: Dae) -> None:
        self._dae = dae
        self._values: dict[str, Any] | None = None

    def value(self, e: Expr) -> float | None:
        """The number, or None where it has none or needs a function of the model."""
        if e.is_const:
            return float(e.data)
        if self._values is None:
            self._values = {}
            for p in self._dae.parameters:
                self._values[p.name] = self._evaluate(p.value)
        found = self._evaluate(e)
        return None if found is None else float(found)

    def differ(self, a: Expr, b: Expr) -> bool:
        """Whether two values are known to disagree, beyond rounding."""
        if a is b:
            return False
        x, y = self.value(a), self.value(b)
        if x is None or y is None:
            return False
        return not math.isclose(x, y, rel_tol=1e-9, abs_tol=1e-12)

    def _evaluate(self, e: Expr) -> Any:
        values = self._values or {}

        def leaf(symbol: Expr) -> Any:
            found = values.get(symbol.name) if symbol.is_symbol else None
            if found is None:
                raise _Unknown
            return found

        try:
            return evaluate(e, leaf)
        except (_Unknown, ArithmeticError, ValueError):
            return None


class _Unknown(Exception):
    """A symbol without a value."""
