"""A place of the run to go back to.

In:   Kernel at an accepted point, Recorder
Out:  the same point again, and no rows after it

Used where a look at the choice of states came too late (`states`): near a dead centre of
a state what follows from it is lost in the integrator's errors, and so is every row since.
A march in machine code keeps the points itself, in the arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.solve.recorder import Recorder

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Returns to one place for a better choice of states.
MOST_VISITS = 6


class Refuge:
    """The last point where the choice was good: `state`, the time and the states there;
    `guess`, the time and all candidates of the evaluation nearest to it; `rows`, how many
    rows were taken, and the next one of the grid."""

    def __init__(self, kernel: Kernel, program: Program, recorder: Recorder) -> None:
        import numpy as np

        self._kernel, self._recorder = kernel, recorder
        self.slots, self._take, states, self._residuals = _places(program)
        self.guess = np.zeros(len(self.slots))
        self.state = np.zeros(1 + states)
        self.rows = np.zeros(2, dtype=np.int64)
        self._visits, self._late = 0, -math.inf

    @property
    def t(self) -> float:
        return float(self.state[0])

    @property
    def y(self) -> list[float]:
        return self.state[1:].tolist()  # type: ignore[no-any-return]

    def keep(self, t: float, y: Sequence[float]) -> None:
        w, recorder = self._kernel.w, self._recorder
        self.guess[:] = self._take(w)
        self.state[0] = t
        self.state[1:] = y
        self.rows[:] = recorder.count, recorder.next

    def enter(self, late: float) -> bool:
        """Go back from the time `late`, where the run has come too far. Leaves the kernel near this
        point, accepted; false where coming here again would not help."""
        self._visits = self._visits + 1 if self.t <= self._late else 1
        self._late = max(self._late, late)
        if self._visits > MOST_VISITS:
            return False
        t, *values = self.guess.tolist()
        self._kernel.residuals(t, values, [0.0] * max(1, self._residuals))
        self._kernel.accept(t)
        self._recorder.back(*self.rows.tolist())
        return True


@once
def _places(program: Program) -> tuple[NDArray[np.int64], Taker, int, int]:
    """The slots of the time and of all candidates, what takes these, and how many states and
    residuals there are."""
    import numpy as np

    slots = [0, *(c.slot for c in program.candidates)]
    residuals = sum(len(b.residuals) for b in program.blocks) + len(program.initial_residuals)
    return np.array(slots, dtype=np.int64), taker(slots), program.state_count, residuals
