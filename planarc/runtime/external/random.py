"""Random generators of the xorshift family, with the state in the caller's hands.

A state is a row of 32-bit integers, two for each 64-bit word, the low half first; the
generator of 1,024 bits keeps the number of its present word behind them. A word, taken
as a signed integer, gives a number in (0, 1].

Reference: S. Vigna, "An experimental exploration of Marsaglia's xorshift generators,
scrambled", ACM Trans. Math. Softw. 42(4), 2016; "Further scramblings of Marsaglia's
xorshift generators", J. Comput. Appl. Math. 315, 2017.
"""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Sequence

_WORD = (1 << 64) - 1
_HALF = (1 << 32) - 1
#: A row without a local seed takes this prime number; its first numbers are not used.
_NO_LOCAL_SEED, _WARM = 715827883, 10


def xorshift64star(state: Sequence[float]) -> list[float]:
    """The next state of two integers, and a number in (0, 1]."""
    (x,) = _words(state, 1)
    x ^= x >> 12
    x ^= (x << 25) & _WORD
    x ^= x >> 27
    x = (x * 2685821657736338717) & _WORD
    return [*_halves(x), _unit(x)]


def xorshift128plus(state: Sequence[float]) -> list[float]:
    """The next state of four integers, and a number in (0, 1]."""
    older, newer = _words(state, 2)
    older ^= (older << 23) & _WORD
    total = ((older ^ newer ^ (older >> 17) ^ (newer >> 26)) + newer) & _WORD
    return [*_halves(newer), *_halves(total), _unit(total)]


def xorshift1024star(state: Sequence[float]) -> list[float]:
    """The next state of 33 integers, and a number in (0, 1]."""
    words = _words(state, 16)
    place = int(state[32]) & 15
    first = words[place]
    place = (place + 1) & 15
    second = words[place]
    second ^= (second << 31) & _WORD
    second ^= second >> 11
    words[place] = first = first ^ (first >> 30) ^ second
    drawn = (first * 1181783497276652981) & _WORD
    return [*(h for word in words for h in _halves(word)), place, _unit(drawn)]


class _Row:
    """A row of numbers without a state of its own in the model: where it stands, and the last
    instant and number of each place that draws from it."""

    def __init__(self, seed: int) -> None:
        state: list[float] = [_NO_LOCAL_SEED, seed]
        for _ in range(_WARM):
            state = xorshift64star(state)[:2]
        while len(state) <= 32:
            state += xorshift64star(state[-2:])[:2]
        self._state, self._drawn = state[:33], dict[float, tuple[float, float]]()

    def number(self, place: float, time: float) -> float:
        """The next number; while an event is iterated, the same at its place."""
        before, found = self._drawn.get(place, (math.nan, 0.0))
        if before != time:
            *self._state, found = xorshift1024star(self._state)
            self._drawn[place] = time, found
        return found


class _Rows(threading.local):
    """The rows of this thread's run, by their seeds."""

    def __init__(self) -> None:
        self.of: dict[int, _Row] = {}


_rows = _Rows()


def forget() -> None:
    """A run begins: all rows stand at their beginning."""
    _rows.of.clear()


def drawn(arguments: Sequence[float]) -> list[float]:
    """A number in (0, 1] by seed, the place of the call and the time: at each new instant and
    place the next one of the row that the seed begins."""
    seed, place, time = arguments
    row = _rows.of.get(int(seed))
    if row is None:
        row = _rows.of[int(seed)] = _Row(int(seed))
    return [row.number(place, time)]


def automatic_seed(_arguments: Sequence[float]) -> list[float]:
    """An integer that differs from run to run: by the time and by the process."""
    milliseconds = time.time_ns() // 1_000_000
    return [_signed(milliseconds + 6007 * os.getpid())]


def _words(state: Sequence[float], count: int) -> list[int]:
    if len(state) < 2 * count:
        raise ValueError("the state of the random generator is too short")
    halves = [int(s) & _HALF for s in state[: 2 * count]]
    return [low | high << 32 for low, high in zip(halves[::2], halves[1::2], strict=True)]


def _halves(word: int) -> tuple[int, int]:
    return _signed(word), _signed(word >> 32)


def _signed(bits: int) -> int:
    """The lowest 32 bits as a signed integer."""
    return ((bits & _HALF) ^ 0x80000000) - 0x80000000


def _unit(word: int) -> float:
    """A word as a signed fraction of 2^64, moved up by a half."""
    return ((word ^ 1 << 63) - (1 << 63)) * 2.0**-64 + 0.5
