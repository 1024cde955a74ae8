"""Creeping: steps so short that the run would never come to its end."""

from __future__ import annotations

#: Steps, and the part of the run that they must bring it forward: at a slower pace it would take
#: ten thousand million. A short stiff transient takes some hundred.
CREEP_STEPS, CREEP_TIME = 10_000, 1e-6


class Creep:
    """A count of steps between places that lie far enough apart."""

    def __init__(self, start: float, span: float) -> None:
        self._least = CREEP_TIME * span
        self._place, self._steps = start, 0

    def found(self, t: float, steps: int) -> bool:
        """Whether the run creeps, `steps` steps after the last call, now at `t`."""
        if t - self._place > self._least:
            self._place, self._steps = t, 0
        else:
            self._steps += steps
        return self._steps >= CREEP_STEPS
