"""Bounds that a `reinit` holds something back at, and that it passes all the same.

In:   what each event set anew, and which relations became true at it
Out:  a warning R444 for the first bound that is left far behind when the run is over

A `when` acts once, at the instant at which its condition becomes true. Where its `reinit` stops
what moves on a bound, it goes on behind the bound: the condition stays true, and nothing acts
again.

Example: `when h <= 0 then reinit(v, -e*pre(v)); end when;` with e = 0. The ball stops for an
instant, and falls through the floor. Without the minus it goes on with a part of its speed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from planarc.core.diagnostic import Diagnostic
from planarc.solve.events.crossings import Crossings

#: The part of its largest size that a zero function is beyond its bound where it has passed it, and
#: by which it may move on there, within a short time, and still be held back; what it is slowed
#: down by less is left as it was.
_BEYOND, _HELD, _SLOWED = 1e-2, 1e-12, 1e-9


class Passed:
    """The relations whose last switch was held back: when, and the truth that they took."""

    def __init__(self, crossings: Crossings) -> None:
        self._crossings = crossings
        #: when, the truth that it took, the states that were set, and whether it was slowed only
        self._held: dict[int, tuple[float, bool, Sequence[str], bool]] = {}

    def note(
        self,
        t: float,
        y: Sequence[float],
        crossing: Mapping[int, bool],
        reset: Sequence[str],
        before: Sequence[float],
    ) -> None:
        """Relations that switched at an event, to which the run came with the states `before`, and
        from which it goes on with `y`, of which it `reset` some. The workspace is left elsewhere.
        """
        for i in crossing:
            self._held.pop(i, None)
        rises = self._crossings.rises(t, y) if reset else None
        if rises is None:
            return
        came = None
        for i, truth in crossing.items():
            into = -rises[i] if truth else rises[i]  # below zero it is true
            held = into <= _HELD * self._crossings.largest[i]
            if not held and came is None:
                came = self._crossings.rises(t, before) or rises
            # A `reinit` that forgets the sign lets it go on the same way, at a part of its speed.
            slowed = came is not None and 0 < into < (1 - _SLOWED) * abs(came[i])
            if held or slowed:
                self._held[i] = (t, truth, reset, slowed and not held)

    def judge(self, t: float, y: Sequence[float]) -> tuple[Diagnostic, ...]:
        """The warning at the end of a run."""
        crossings = self._crossings
        if not self._held or crossings.evaluate(t, y) != 0 or crossings.kernel.outputs(t, y) != 0:
            return ()
        from planarc.solve.messages.event import passed

        now, largest = crossings.now, crossings.largest
        for i, (since, truth, reset, slowed) in self._held.items():
            beyond = -now[i] if truth else now[i]  # below zero it is true
            if beyond > _BEYOND * largest[i]:
                return (passed(crossings.program, crossings.kernel, i, since, reset, slowed),)
        return ()
