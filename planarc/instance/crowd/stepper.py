"""The memory of the steps of a run in Python with crowds, and the call (`instance.crowd.stepping`).

The memory has the words of an instance (`instance.plan`); what the kernel has of them is the
kernel's own.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.instance.crowd.layout import Count, Kept, kept_words, sizes
from planarc.instance.crowd.steps import HALF, STRUCK
from planarc.instance.crowd.table import crowds_of
from planarc.instance.plan import LETTERS, STAGES, Own
from planarc.instance.steps import BEGIN, END
from planarc.ir.frame import Frame, address
from planarc.ir.kernel import Pressed, Stepped
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Values of a message, behind its text.
_VALUES = 3


class Stepper:
    """The memory of one kernel, whose frame is `frame`; `call` is the function."""

    def __init__(self, program: Program, frame: Vector, call: Callable[[Any, int], int]) -> None:
        n, listed = program.state_count, crowds_of(program).table()
        lengths: dict[int, int] = {
            Own.Y: n,
            Own.STAGES: STAGES * n,
            Own.TOUCHES: kept_words(listed),
            Own.TEXT: LETTERS // 8 + _VALUES,
        }
        area = sizes(listed, program)
        starts = [*accumulate(lengths.values(), initial=int(Own.FIRST))]
        homes = dict(zip(lengths, starts, strict=False)) | {int(Own.CONTACT): starts[-1]}
        begins = [*accumulate(area.values(), initial=starts[-1] + len(area))]
        homes |= {starts[-1] + k: at for k, at in zip(area, begins, strict=False)}
        self._frame, self._call = frame, call
        self._memory = np.zeros(begins[-1])
        self._words = self._memory.view(np.int64)
        start = address(self._memory)
        for word, at in homes.items():
            self._words[word] = start + 8 * at
        self._address = ctypes.c_void_p(start)
        self._y = self._memory[homes[Own.Y] :][:n]
        self._vectors = self._memory[homes[Own.STAGES] :][: STAGES * n].reshape(STAGES, n)
        kept, first = homes[Own.TOUCHES], homes[Own.TOUCHES] + int(Kept.FIRST)
        self._count, self._room = kept + int(Kept.COUNT), listed[Count.ROOM]
        self._keys = self._words[first:][: self._room]
        self._impulses = self._memory[first + self._room :][: 2 * self._room].reshape(2, -1)

    def are_apart(self, y: Sequence[float]) -> bool:
        self._y[:] = y
        return self._answers(apart=True)

    def step(self, t: float, h: float, y: Sequence[float], depth: float) -> Stepped | None:
        self._vectors[BEGIN] = y
        self._memory[Own.REACH], self._memory[Own.SPAN] = t, h
        self._memory[Own.TOLERANCE] = depth
        if not self._answers(apart=False):
            return None
        end, half, struck = self._vectors[[END, HALF, STRUCK]]
        return Stepped(end, half, struck == 1.0)

    @property
    def pressed(self) -> Pressed:
        count = int(self._words[self._count])
        return self._keys[:count].copy(), self._impulses[:, :count].T.copy()

    @pressed.setter
    def pressed(self, known: Pressed) -> None:
        keys, values = known
        some = np.flatnonzero((values != 0).any(axis=1))[: self._room]
        self._words[self._count] = count = len(some)
        self._keys[:count], self._impulses[:, :count] = keys[some], values[some].T

    def _answers(self, apart: bool) -> bool:
        self._memory[: len(Frame)] = self._frame.view(float)
        return self._call(self._address, int(apart)) == 0
