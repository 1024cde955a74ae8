"""Chattering: events that follow each other without end.

Three kinds end a run, instead of letting it creep on: many events within next to no time, one
relation that switches again and again by less than the integrator resolves (a ball that bounces to
its rest), and one whose zero the integrator finds again and again though it does not switch.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic
from planarc.ir.program import Program
from planarc.solve.events.crossings import Crossings
from planarc.solve.settings import Request

#: Events, and the part of the run within which so many are called chattering.
CHATTER_COUNT, CHATTER_TIME = 100, 1e-6
#: An arc between two switches that is not so many times higher than the tolerance may be no
#: longer than one step; it is begun with this part of the last one.
LOW, FIRST = 1e3, 0.02
#: Switches in a row, each smaller than the tolerance resolves, that are chattering too.
TINY_COUNT = 8
#: One that is found only after its root counts so often, and so does one that is smaller than the
#: tolerance by this factor: the next may be none but rounding, which no integrator sees.
LATE, SMALL = 4, 1e-3
#: Where that took a part of the run as long as this, what follows is not near.
BRIEF = 1e-3


class Chatter:
    """A memory of past events, to tell chattering from a busy run."""

    def __init__(
        self,
        program: Program,
        crossings: Crossings,
        request: Request,
        touches: frozenset[int] = frozenset(),
    ) -> None:
        """`touches`: relations of touches, of which bounces are known to come to rest."""
        self._touches = touches
        self._program, self._crossings = program, crossings
        self._tolerance, self._span, self._start = request.tolerance, request.span, request.start
        self.forget()

    def forget(self) -> None:
        """The run goes on from another instant: what happened before says nothing of it."""
        #: The step to begin with after the present event, where the integrator might step
        #: over the whole of what is between two switches.
        self.step: float | None = None
        self._recent: list[tuple[float, tuple[int | str, ...]]] = []
        self._last_switch: dict[int, float] = {}  # of each relation
        self._truth: dict[int, bool] = {}  # that it took then
        self._tiny: dict[int, int] = {}  # switches in a row too small to be resolved
        self._vain: list[float] = []  # roots in a row at which nothing switched

    def note(self, t: float, crossing: Mapping[int, bool], rises: Sequence[float]) -> None:
        """Relations that cross zero at a root that the integrator found."""
        if crossing:
            self.step = None
        for i, truth in crossing.items():
            since = t - self._last_switch.get(i, self._start)
            part = self._crossings.amplitude(i, rises[i], since) if rises[i] else math.inf
            tiny = part < self._tolerance and i in self._last_switch
            tiny = tiny and i not in self._crossings.beyond
            weight = LATE if part < SMALL * self._tolerance and since < BRIEF * self._span else 1
            self._tiny[i] = self._tiny.get(i, 0) + weight if tiny else 0
            self._last_switch[i] = t
            again, self._truth[i] = self._truth.get(i, truth) == truth, truth
            height = part * min(self._crossings.largest[i], 1.0)
            if again and since > 0 and height < LOW * self._tolerance:
                self.step = min(since * FIRST, self.step or math.inf)

    def found_late(self, t: float, crossing: Mapping[int, bool]) -> None:
        """Relations that were seen to have switched without a root: too small to be found."""
        for i, truth in crossing.items():
            self._tiny[i] = self._tiny.get(i, 0) + LATE
            since = t - self._last_switch.get(i, t)
            if since > 0 and self._truth[i] == truth:
                self.step = min(since * FIRST, self.step or math.inf)

    def vain(self, t: float, directions: Sequence[int]) -> Diagnostic | None:
        """The reason to end the run at a root at which nothing switched, or None."""
        self._vain.append(t)
        if len(self._vain) <= CHATTER_COUNT:
            return None
        if t - self._vain.pop(0) >= CHATTER_TIME * self._span:
            return None
        found = [i for i, d in enumerate(directions) if d and i not in self._touches]
        return self._told(t, found) if found else None

    def judge(
        self, t: float, crossing: Collection[int], causes: tuple[str, ...]
    ) -> Diagnostic | None:
        """The reason to end the run with this event, or None. Instants known beforehand have no
        `causes`: however many they are, they do not chatter."""
        if causes:
            switched = tuple(i for i in crossing if i not in self._touches)
            self._recent.append((t, switched or causes))
        if causes and len(self._recent) > CHATTER_COUNT:
            del self._recent[0]
            if t - self._recent[0][0] < CHATTER_TIME * self._span:
                often = Counter(c for _, found in self._recent for c in found)
                return self._told(t, [c for c, _ in often.most_common(3)])
        piled = [
            i for i in crossing if self._tiny.get(i, 0) >= TINY_COUNT and i not in self._touches
        ]
        return self._told(t, piled) if piled else None

    def _told(self, t: float, often: Sequence[int | str]) -> Diagnostic:
        from planarc.solve.messages.event import chattering

        return chattering(self._program, self._crossings.kernel, t, often)
