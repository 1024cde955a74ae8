"""A point of a model: a loaded kernel at consistent values, with states chosen.

In:   Model, RunOptions (parameters and start values), inputs
Out:  Point    the kernel, the states, and the right-hand side as a function of them
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import PlanarcError, error

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.core.options import RunOptions
    from planarc.ir.program import CandidateSlot, Kernel, Program
    from planarc.model import Model
    from planarc.signals import Signal
    from planarc.solve.simulate import Run

    Vector = NDArray[np.float64]


class Point:
    """Values at time `t`; `y` are those of the chosen states."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self.program: Program = run.program
        self.kernel: Kernel = run.kernel
        self.t = run.request.start
        self.accept(run._state_values(), self.t)

    @property
    def selection(self) -> list[int]:
        return self._run.selection

    @property
    def states(self) -> list[CandidateSlot]:
        return [self.program.candidates[i] for i in self.selection]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(c.display for c in self.states)

    def accept(self, y: Sequence[float] | Vector, t: float | None = None) -> None:
        """Make these states the point from which nonlinear blocks start."""
        import numpy as np

        self.t = self.t if t is None else t
        self.y = np.array(y, dtype=float)
        flag = self.kernel.outputs(self.t, self.y.tolist())
        if flag != 0:
            raise error("R470", f"the equations have no solution at t = {self.t:.6g} s")
        self.kernel.accept(self.t)

    def rhs(self, y: Vector) -> Vector:
        """Derivatives of the states at `t`. Raises PlanarcError where there are none."""
        import numpy as np

        ydot = [0.0] * len(self.y)
        if self.kernel.rhs(self.t, y.tolist(), ydot) != 0 or not np.all(np.isfinite(ydot)):
            raise error("R470", f"the equations have no solution near t = {self.t:.6g} s")
        return np.array(ydot)

    def reselect(self) -> None:
        """Choose the states anew for the present values."""
        run = self._run
        run.selection = run.selector.choose(())
        self.kernel.select(run.selection)
        self.accept(run._state_values())

    def values(self) -> dict[str, float]:
        """All variables and parameters, by name."""
        w = self.kernel.w
        return {c.name: c.sign * float(w[c.slot]) for c in self.program.columns}

    def starts(self) -> dict[str, float]:
        """Start values that lead to this point."""
        w = self.kernel.w
        names = {c.name for c in self.program.columns}
        return {
            c.display if c.display in names else c.name: float(w[c.slot])
            for c in self.program.candidates
        }


def open_point(
    model: Model, options: RunOptions, inputs: Mapping[str, Signal] | None = None
) -> Point:
    """The point at the start of a run. Raises PlanarcError where there is none."""
    return Point(open_run(model, options, inputs))


def open_run(model: Model, options: RunOptions, inputs: Mapping[str, Signal] | None = None) -> Run:
    """A run that stands at its start; the caller closes it."""
    from planarc.solve.request import resolve
    from planarc.solve.simulate import Run, set_workspace

    compiled = model.compiled(options.backend)
    kernel = model.forced(compiled.load(), options, inputs)
    request = resolve(compiled.program, options)
    set_workspace(compiled.program, kernel, request)
    run = Run(compiled.program, kernel, request, str(options.backend))
    try:
        run.begin()
        if run.ended is not None:
            raise PlanarcError(run.ended)
    except BaseException:
        run.close()
        raise
    run.close()
    return run
