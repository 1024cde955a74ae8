"""The past of the signals that a model delays: what a kernel reads and a run writes.

A run appends a *piece* for every step of the integrator: on it each signal is a polynomial
of degree `DEGREE` in x = (t - begin)/width, from 0 to 1. Before the first piece stand the
values at the start, behind the last one the tangent at its end.

Signals jump at events, and the jump comes back a delay later. Which side of it counts
cannot be told from an instant with rounding errors, so the run sets bounds: the instants
of delay i are looked up as if they lay in `bounds[2*i] .. bounds[2*i + 1]`.

Compiled code reads the same numbers through `memory` (see `Memory`).
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_right
from collections.abc import Sequence
from enum import IntEnum
from typing import Final

DEGREE: Final = 5
#: Coefficients of a piece, the constant first.
TERMS: Final = DEGREE + 1


class Memory(IntEnum):
    """Places in `History.memory`, of int64 numbers and addresses."""

    PIECES = 0  # how many
    DELAYS = 1  # how many
    HALVINGS = 2  # of a search among the pieces
    BEGINS = 3  # float64: one a piece
    SCALES = 4  # float64: 1/width of each piece
    TERMS = 5  # float64: of each piece, of each delay, its coefficients
    BOUNDS = 6  # float64: two a delay


class History:
    """The pieces of `delays` signals; each delay has its own."""

    def __init__(self, delays: int) -> None:
        self.delays = delays
        self.bounds = array("d", [-math.inf, math.inf] * delays)
        self.memory = array("q", [0] * len(Memory))
        self._begins, self._scales, self._terms = array("d"), array("d"), array("d")
        if delays:
            self.start(0.0, [0.0] * delays)

    @property
    def size(self) -> int:
        """The number of pieces that are kept."""
        return len(self._begins)

    def start(self, t: float, values: Sequence[float]) -> None:
        """Forget everything; the signals had these values for ever."""
        self._begins, self._scales = array("d", [t]), array("d", [0.0])
        self._terms = array("d", (x for v in values for x in (v, *(0.0,) * DEGREE)))
        self._tail(t, values, [0.0] * self.delays)

    def append(self, begin: float, end: float, terms: Sequence[Sequence[float]]) -> None:
        """A piece behind all others; `terms` are each signal's coefficients in x."""
        width = end - begin
        self._drop_tail()
        self._begins.append(begin)
        self._scales.append(1.0 / width)
        for row in terms:
            self._terms.extend(row)
        values = [math.fsum(row) for row in terms]
        slopes = [math.fsum(k * c for k, c in enumerate(row)) / width for row in terms]
        self._tail(end, values, slopes)

    def merge(
        self, first: float, begin: float, values: Sequence[float]
    ) -> tuple[float, Sequence[float]]:
        """Drop the pieces that lie between two instants; where the next one may begin
        instead, and the signals there (`values` at `begin` itself)."""
        self._drop_tail()
        while len(self._begins) > 1 and first <= self._begins[-1] < begin:
            begin = self._begins[-1]
            values = self._terms[-self.delays * TERMS :: TERMS]
            self._drop_tail()
        self._tail(begin, values, [0.0] * self.delays)
        return begin, values

    def forget(self, before: float) -> None:
        """Drop the pieces that end before an instant, where they are most of all."""
        old = bisect_right(self._begins, before) - 1
        if old > 500 and 2 * old > len(self._begins):
            del self._begins[:old], self._scales[:old]
            del self._terms[: old * self.delays * TERMS]
            self._publish()

    def value(self, index: int, order: int, instant: float) -> float:
        """The signal of a delay at an instant, or its derivative of some order."""
        low, high = self.bounds[2 * index : 2 * index + 2]
        asked = min(max(instant, low), high)
        piece = max(bisect_right(self._begins, asked) - 1, 0)
        scale = self._scales[piece]
        x = (instant - self._begins[piece]) * scale
        first = (piece * self.delays + index) * TERMS
        value = 0.0
        for k in range(DEGREE, order - 1, -1):
            value = value * x + self._terms[first + k] * math.perm(k, order)
        return value * scale**order if order else value

    # The piece behind the last one

    def _tail(self, t: float, values: Sequence[float], slopes: Sequence[float]) -> None:
        self._begins.append(t)
        self._scales.append(1.0)
        for v, s in zip(values, slopes, strict=True):
            self._terms.extend((v, s, *(0.0,) * (DEGREE - 1)))
        self._publish()

    def _drop_tail(self) -> None:
        del self._begins[-1:], self._scales[-1:]
        del self._terms[-self.delays * TERMS :]

    def _publish(self) -> None:
        """Arrays move when they grow."""
        memory, pieces = self.memory, len(self._begins)
        memory[Memory.PIECES] = pieces
        memory[Memory.DELAYS] = self.delays
        memory[Memory.HALVINGS] = (pieces - 1).bit_length()
        memory[Memory.BEGINS] = self._begins.buffer_info()[0]
        memory[Memory.SCALES] = self._scales.buffer_info()[0]
        memory[Memory.TERMS] = self._terms.buffer_info()[0]
        memory[Memory.BOUNDS] = self.bounds.buffer_info()[0]
