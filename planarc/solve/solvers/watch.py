"""When a march ends, so that the choice of states is looked at again (`states`).

A march in machine code measures the sensitivities at every accepted step: that costs less
than an evaluation of the right-hand side. It ends where one passes `bound`, and keeps the
point before as a refuge. In Python a look costs as much as ten steps, and is put off by
what can be compared quickly: the ways and velocities that `outlook` gives. What these are
reckoned from may change: so one looks soon after a restart, and then ever later.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from planarc.ir.newton import GROWN, WORST
from planarc.solve.refuge import Refuge

#: A velocity that small says nothing about ratios.
AT_REST = 1e-9
#: Steps from one look in Python to the next, at first after a restart, and at most.
FIRST_STEPS, MOST_STEPS = 2, 64


class Watch:
    """Looked at are `blocks`; `scales` are the largest columns seen of their Jacobians, one
    block after another.

    In Python a march ends when a watched slot has moved by more than `limit`, or when what
    is determined moves more than `pace` times as fast as what determines it. `speeds` are
    slots of velocities with their `weights`, group by group: first those of the states,
    with negative weights, then those of what follows from them.
    """

    def __init__(
        self, slots: Sequence[int], speeds: int = 0, blocks: Sequence[int] = (), tears: int = 0
    ) -> None:
        import numpy as np

        self.blocks = tuple(blocks)
        self.scales = np.zeros(tears)
        self.bound = WORST
        #: The least bound there may be: more where a look has kept a choice at its bound, so that
        #: it is not looked at again each time that it comes back there.
        self.least = WORST
        self.refuge: Refuge | None = None
        self.slots = list(slots)
        self.reference = [0.0] * len(slots)
        self.limit = 0.0
        self.speeds = [0] * speeds
        self.weights = [1.0] * speeds
        self.pace = 0.0
        self.restart()

    def bind(self, worst: float, changed: bool) -> None:
        """Bound the sensitivity after a look that found and accepted `worst`, where the choice
        `changed` or did not."""
        if changed:
            self.least = WORST
        elif worst > WORST:
            self.least = GROWN * WORST
        self.bound = max(self.least, GROWN * worst if worst > WORST else 0.0)

    def restart(self) -> None:
        """Look soon: a new integrator's steps are small and tell little of where it goes."""
        self._steps, self._patience = 0, FIRST_STEPS

    def begin(self, values: Sequence[float], limit: float) -> None:
        self.reference[:] = values
        self.limit = limit

    def moved(self, w: Sequence[float]) -> bool:
        """Whether to look again; asked after every step."""
        if not len(self.slots):
            return False
        self._steps += 1
        if self._steps < self._patience and not self._went(w):
            return False
        self._steps, self._patience = 0, min(2 * self._patience, MOST_STEPS)
        return True

    def _went(self, w: Sequence[float]) -> bool:
        limit = self.limit
        for slot, value in zip(self.slots, self.reference, strict=True):
            if abs(w[slot] - value) > limit:
                return True
        return self.ratio(w) > self.pace

    def ratio(self, w: Sequence[float]) -> float:
        """The greatest ratio of velocities; 0 where nothing moves."""
        greatest, slowest, solved = 0.0, 0.0, True
        for slot, weight in zip(self.speeds, self.weights, strict=True):
            speed = abs(w[slot] * weight)
            if weight < 0:
                slowest = speed if solved or speed > slowest else slowest
            elif speed > AT_REST:
                ratio = speed / slowest if slowest else math.inf
                greatest = ratio if ratio > greatest else greatest
            solved = weight > 0
        return greatest
