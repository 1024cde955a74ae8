"""The steps of a run, counted: how many at a time, and when they would never bring it to its end.

Everything here goes by counts. A run ends alike on every machine, however fast that is and
whatever else it does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum

from planarc.ir.once import once
from planarc.ir.program import Program

#: Steps of the first march, and of the first after a restart, where relations may switch at once.
FIRST = 2
#: Statements that machine code and that Python evaluate in about 0.1 s: Ctrl-C is heard as often.
WORK_NATIVE, WORK_PYTHON = 1_000_000, 50_000
#: Most steps of a march, in general and where relations are to be looked at after it.
MOST, MOST_WITH_RELATIONS = 1 << 16, 64
#: Steps after which the way that they went is judged.
STRETCH = 10_000
#: Parts of the run that such a way is at most where a run would take 10,000 million steps, which is
#: refused, and 10 million and half a million, of which one warns where there is a reason. A short
#: stiff transient takes some hundred.
CREEP_PART, ABSURD_PART, LONG_PART = 1e-6, 1e-3, 2e-2


class Pace(Enum):
    """What is to be thought of a stretch."""

    ORDINARY = "ordinary"
    LONG = "long, if nothing but a jump is the reason"
    ABSURD = "absurd, whatever the reason"
    CREEPING = "without end"


class Effort:
    """The steps of one run from `start`, of `span` seconds."""

    def __init__(self, program: Program, native: bool, start: float, span: float) -> None:
        self._most = most_steps(program, native)
        self._first = min(FIRST, self._most) if program.relations else self._most
        self._span = span
        self._steps, self._room, self._place = self._first, STRETCH, start

    @property
    def steps(self) -> int:
        """The steps that the next march may take: it never passes where a stretch ends."""
        return min(self._steps, self._room)

    def restart(self) -> None:
        """Begin as at the start again."""
        self._steps = self._first

    def take(self, t: float, steps: int) -> float | None:
        """The way of the stretch that ends here, after so many steps more; None within one."""
        self._steps = self._most
        self._room -= steps
        if self._room > 0:
            return None
        way, self._place, self._room = t - self._place, t, STRETCH
        return way

    def pace(self, way: float) -> Pace:
        """What is to be thought of a stretch, by the part of the run that it was."""
        part = way / (self._span or math.inf)
        limits = ((CREEP_PART, Pace.CREEPING), (ABSURD_PART, Pace.ABSURD), (LONG_PART, Pace.LONG))
        return next((pace for limit, pace in limits if part <= limit), Pace.ORDINARY)


#: A speed, in m/s or rad/s, that no mechanism has.
_NO_SPEED = 1e6


def runs_away(program: Program, selection: Sequence[int], y: Sequence[float]) -> bool:
    """Whether a speed among the states is beyond all bounds: where its steps are absurdly short,
    too, what comes of it is not worth them."""
    speeds = _speeds(program)
    return any(abs(v) > _NO_SPEED and i in speeds for i, v in zip(selection, y, strict=False))


@once
def _speeds(program: Program) -> frozenset[int]:
    """The candidates for states that are speeds."""
    units = {c.slot: c.unit for c in program.columns}
    named = enumerate(program.candidates)
    return frozenset(i for i, c in named if units.get(c.slot) in ("m/s", "rad/s"))


def most_steps(program: Program, native: bool) -> int:
    """The most steps of a march: a matter of the program's size and of the back end."""
    work = WORK_NATIVE if native else WORK_PYTHON
    return max(
        1, min(work // max(1, _size(program)), MOST_WITH_RELATIONS if program.relations else MOST)
    )


@once
def _size(program: Program) -> int:
    """The number of statements."""
    return sum(map(len, program.levels)) + sum(len(block.body) for block in program.blocks)
