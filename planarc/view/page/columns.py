"""Columns of numbers as a page carries them: base64 of little-endian floats, each distinct one
once. What never changes is a number.

32 bits hold seven digits, more than a screen shows; times have 64 bits, so that rows at nearly
the same time stay apart.
"""

from __future__ import annotations

import base64
import math
from typing import Any, TypeAlias

import numpy as np

from planarc.core.arrays import Array
from planarc.evaluate.record import Number
from planarc.ir.insight import Track

#: A number, None where it is not finite, or base64.
Encoded: TypeAlias = "float | str | None"


class Columns:
    """Numbered columns of some rows of a result; `all` holds them encoded."""

    def __init__(self, rows: Array | slice) -> None:
        self._rows = rows
        self._known: dict[object, int] = {}
        self.all: list[Encoded] = []
        self.size = 0  # of all, in characters

    def add(self, values: Track) -> int:
        """The number of a column, equal ones the same."""
        encoded = number(values) if isinstance(values, (int, float)) else self._encode(values)
        if encoded not in self._known:
            self._known[encoded] = len(self.all)
            self.all.append(encoded)
            self.size += len(str(encoded)) + 3
        return self._known[encoded]

    def _encode(self, values: Any) -> Encoded:
        with np.errstate(over="ignore"):  # of a run that blew up: infinite to the page
            own = values[self._rows].astype("<f4")
        if own.size and own[0] == own[-1] and (own == own[0]).all():
            return number(float(own[0]))
        return _text(own)


def encode(values: Array, form: str = "<f4") -> str:
    """Base64 of the numbers; what is not finite is NaN, and there is no -0."""
    with np.errstate(over="ignore"):
        return _text(np.array(values, dtype=form))


def _text(own: Array) -> str:
    """Base64 of numbers that nobody else needs: they are changed in place."""
    own += 0.0  # -0 becomes 0
    finite = np.isfinite(own)
    if not finite.all():
        own[~finite] = np.nan
    return base64.b64encode(own.data).decode("ascii")


def number(value: float) -> float | None:
    """The number with seven digits, one that remembers as it is; None where it is not finite."""
    if isinstance(value, Number):
        return value
    return float(f"{value:.7g}") + 0.0 if math.isfinite(value) else None
