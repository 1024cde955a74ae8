"""The memory of the event iteration of a run in Python, and the call (`instance.reaction`).

The memory has the words of an instance (`instance.plan`); what the kernel has of them is the
kernel's own. What the run knows of relations and touches is put in before each call, and taken out
after it, so that the run may decide an instant itself at any time.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from planarc.instance.contact.area import LOGGED, STRIKES, Area, Kept, Seen, kept_words, sizes
from planarc.instance.plan import Own, Relation, Sample, event_sizes
from planarc.ir.frame import Frame, address
from planarc.ir.kernel import Reacted, TouchMemory
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.solve.contact.touches import Points
from planarc.solve.events.crossings import AHEAD
from planarc.solve.events.settling import PATIENCE

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Arrays of the steps that `rises` tries: states, derivatives, states later.
_STAGES: Final = 3


@once
def _homes(program: Program) -> tuple[int, dict[int, int], int, int]:
    """Words of the memory; where arrays begin, by the words that point to them; the number of
    touches, and where the discrete variables stand."""
    n, touches = program.state_count, len(Points(program).all)
    lengths: dict[int, int] = {
        Own.Y: n,
        Own.RATES: n,
        Own.STAGES: _STAGES * n,
        **event_sizes(program, PATIENCE + 1),
        Own.TOUCHES: kept_words(touches),
        Own.DISCRETES: 3 * len(program.discretes),
    }
    starts = [*accumulate(lengths.values(), initial=int(Own.FIRST))]
    homes = {int(word): at for word, at in zip(lengths, starts, strict=False)}
    area, end = sizes(touches, n, asks=True), starts[-1]
    if area:
        homes[int(Own.CONTACT)] = end
        starts = [*accumulate(area.values(), initial=end + len(area))]
        homes |= {end + int(k): at for k, at in zip(area, starts, strict=False)}
        end = starts[-1]
    return end, homes, touches, homes[int(Own.DISCRETES)]


class Reactor:
    """The memory of one kernel, whose frame is `frame`; `call` is the function."""

    def __init__(self, program: Program, frame: Vector, call: Callable[[Any, int], int]) -> None:
        from planarc.instance.clauses import ordered_discretes

        words, homes, touches, discretes = _homes(program)
        self._frame, self._call = frame, call
        self._memory = np.zeros(words)
        self._words = self._memory.view(np.int64)
        start = address(self._memory)
        for word, at in homes.items():
            self._words[word] = start + 8 * at
        told = [n for d in ordered_discretes(program)[0] for n in (d.slot, d.pre, d.start)]
        self._words[discretes : discretes + len(told)] = told
        self._address = ctypes.c_void_p(start)

        def part(word: Own, count: int) -> Vector:
            at = homes[int(word)]
            return self._memory[at : at + count]

        states, count, samplers = program.state_count, len(program.relations), len(program.samplers)
        self._y, self._reset = part(Own.Y, states), part(Own.RATES, states)
        relations = part(Own.RELATIONS, len(Relation) * count).reshape(len(Relation), count)
        self._now, self._largest = relations[Relation.NOW], relations[Relation.LARGEST]
        self._crossing = relations[Relation.CROSSING].view(np.int64)
        self._leaping = relations[Relation.INSTANT]
        self._beyond = relations[Relation.BEYOND].view(np.int64)
        samples = part(Own.SAMPLES, len(Sample) * samplers).reshape(len(Sample), samplers)
        self._fired = samples[Sample.FIRED].view(np.int64)
        if touches:
            kept = part(Own.TOUCHES, kept_words(touches))
            self._kept, behind = kept[: int(Kept.NUMBERS) * touches], kept[-len(Seen) :]
            self._seen, self._counts = behind, behind.view(np.int64)
            log = homes[homes[int(Own.CONTACT)] + Area.LOG]
            shape = STRIKES, 2 * len(LOGGED), touches
            self._log = self._memory[log : log + STRIKES * 2 * len(LOGGED) * touches].reshape(shape)

    def prepare(self, span: float, tolerance: float) -> None:
        """A run begins."""
        self._memory[Own.AHEAD], self._memory[Own.TOLERANCE] = AHEAD * (span or 1.0), tolerance

    def react(
        self,
        y: Sequence[float],
        crossing: Mapping[int, bool],
        fired: Sequence[int],
        largest: Sequence[float],
        leaping: Collection[int],
        ahead: bool,
        known: TouchMemory | None,
    ) -> Reacted | None:
        """The iteration at the time and the states of the workspace; None where Python must decide
        or tell: the workspace is no use then."""
        words = self._words
        self._memory[: len(Frame)] = self._frame.view(float)
        self._y[:] = y
        self._reset[:] = 0.0
        self._largest[:] = largest
        self._crossing[:] = 0
        for i in crossing:
            self._crossing[i] = 1
        self._leaping[:] = 0.0
        for i in leaping:
            self._leaping[i] = 1.0
        self._fired[:] = 0
        for i in fired:
            self._fired[i] = 1
        words[Own.DOUBT] = words[Own.ENDED] = words[Own.OVER] = words[Own.RESET] = 0
        if known is not None:
            self._put(known)
        if self._call(self._address, int(ahead)) or words[Own.DOUBT]:
            return None
        struck: list[Vector] = []
        if known is not None:
            strikes = int(self._counts[Seen.STRIKES])
            if strikes > STRIKES:
                return None
            struck = [*self._log[:strikes].copy()]
            known = self._taken() if strikes else known
        reset = np.flatnonzero(self._reset).tolist() if words[Own.RESET] else []
        beyond = np.flatnonzero(self._beyond).tolist()
        return Reacted(
            self._y.tolist(), self._now.tolist(), self._largest.tolist(), reset, beyond, struck,
            known,
        )  # fmt: skip

    def _put(self, known: TouchMemory) -> None:
        self._kept[:] = known.touches
        self._seen[Seen.FASTEST], self._seen[Seen.STRONGEST], self._seen[Seen.MOST] = known.sizes
        self._counts[Seen.BEGINS], self._counts[Seen.STRIKES] = known.begins, 0
        self._seen[Seen.SHARP] = known.sharpness

    def _taken(self) -> TouchMemory:
        seen = self._seen[: Seen.BEGINS].tolist()
        return TouchMemory(
            self._kept.copy(), seen, bool(self._counts[Seen.BEGINS]), float(self._seen[Seen.SHARP])
        )
