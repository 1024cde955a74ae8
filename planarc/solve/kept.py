"""What one run of a model leaves to the next one: its kernel, and CVODE's memory.

    shelf = Shelf()
    kept = shelf.take(compiled.load)         a kernel as it was loaded, of an earlier run or new
    simulate(program, kept, options)         its integrator goes on with this run
    shelf.give(kept)                         after a run without failure alone

To load a kernel and to create and free CVODE's memory takes 6 % of a short run. Nothing of what
a run computes stays: arrays are filled with zeros, CVODE begins anew, so that results are to the
last bit those of a new kernel. A run that fails, or is interrupted, leaves nothing.

Whoever takes has it alone, so that runs in threads do not meet.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING
from weakref import finalize

if TYPE_CHECKING:
    from planarc.ir.kernel import Kernel
    from planarc.solve.solvers.integrator import Integrator

#: Kernels that are kept: more at a time run in as many threads.
MOST = 8


class Kept:
    """A kernel, and the integrator of its last run."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.integrator: Integrator | None = None

    def keep(self, integrator: Integrator) -> None:
        """Take the integrator of a run that is over, where it can go on with another one."""
        if integrator is not self.integrator:
            self.close()
        if integrator.keeps:
            integrator.rest()
            self.integrator = integrator
        else:
            integrator.close()
            self.integrator = None

    def close(self) -> None:
        if self.integrator is not None:
            self.integrator.close()
            self.integrator = None


class Shelf:
    """Kernels at rest, all of one program with one code."""

    def __init__(self) -> None:
        self._idle: list[Kept] = []
        finalize(self, _close, self._idle).atexit = False

    def take(self, load: Callable[[], Kernel]) -> Kept:
        """A kernel as `load` gives it."""
        try:
            kept = self._idle.pop()
        except IndexError:
            return Kept(load())
        machine = kept.kernel.capabilities.machine
        assert machine is not None
        machine.renew()
        return kept

    def give(self, kept: Kept) -> None:
        """Put a kernel back, where it can be renewed."""
        if kept.kernel.capabilities.machine is not None and len(self._idle) < MOST:
            self._idle.append(kept)
        else:
            kept.close()


def _close(idle: list[Kept]) -> None:
    for kept in idle:
        kept.close()
