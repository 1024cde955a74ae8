"""A place of the run to go back to.

In:   Kernel at an accepted point, Recorder
Out:  the same point again, and no rows after it

Used where a look at the choice of states came too late (`states`): near a dead centre of
a state what follows from it is lost in the integrator's errors, and so is every row since.
"""

from __future__ import annotations

from planarc.ir.program import Kernel, Program
from planarc.solve.recorder import Recorder


class Refuge:
    """The workspace's present point, at the time that it was evaluated for."""

    def __init__(self, kernel: Kernel, program: Program, recorder: Recorder) -> None:
        w = kernel.w
        self.t = float(w[0])
        self.visits = 0
        self._values = [float(w[c.slot]) for c in program.candidates]
        self._residuals = sum(len(b.residuals) for b in program.blocks) + len(
            program.initial_residuals
        )
        self._count, self._next = recorder.count, recorder.next

    def enter(self, kernel: Kernel, recorder: Recorder) -> None:
        """Leaves the kernel at this point, accepted."""
        kernel.residuals(self.t, self._values, [0.0] * max(1, self._residuals))
        kernel.accept(self.t)
        recorder.back(self._count, self._next)
