"""A point of a model: a loaded kernel at consistent values, with states chosen.

In:   Model, RunOptions (parameters and start values), inputs; a time
Out:  Point    the kernel, the states, and the right-hand side as a function of them

Time and inputs stand still at a point; relations keep their truth until `settle`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from msgspec.structs import replace

from planarc.api.signals import ForcedKernel, Signal
from planarc.core.arrays import Vector
from planarc.core.diagnostic import PlanarcError, error
from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.kernel import Kernel
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.runtime.differences import central
from planarc.solve.run import Run
from planarc.solve.settings import resolve
from planarc.solve.start.sharing import misses

if TYPE_CHECKING:
    from planarc.api.model import Model

    _Kept: TypeAlias = "tuple[Model, Backend, list[int], Vector, float, Vector]"

#: Steps of differences, relative to max(1, |x|). Those of order four err by about 1e-13.
STEP = 1e-3


class Point:
    """Values at time `t`; `y` are those of the states. Raises PlanarcError (R470) where
    the equations have no solution. A copy in another process has no `run`."""

    y: Vector

    def __init__(
        self, model: Model, backend: Backend, run: Run, t: float, y: Sequence[float]
    ) -> None:
        self.model, self.backend = model, backend
        self.run = run
        self._selection: list[int] | None = None  # of a copy
        self.program: Program = run.program
        self.kernel: Kernel = run.kernel
        if isinstance(run.kernel, ForcedKernel):
            self.kernel = run.kernel.inner
            run.kernel.force(t)
        self.t = t
        self.accept(y)

    def __getstate__(self) -> _Kept:
        w = np.array(self.kernel.w, dtype=float)
        return self.model, self.backend, self.selection, w, self.t, self.y

    def __setstate__(self, kept: _Kept) -> None:
        self.model, self.backend, selection, w, self.t, self.y = kept
        compiled = self.model.compiled(self.backend)
        self.program, self.kernel = compiled.program, compiled.load()
        self.kernel.w[:] = w.tolist()
        self.kernel.select(selection)
        self.kernel.accept(self.t)
        self._selection = selection

    @property
    def selection(self) -> list[int]:
        known = self._selection
        return self.run.states.selection if known is None else known

    @property
    def states(self) -> list[CandidateSlot]:
        return [self.program.candidates[i] for i in self.selection]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(c.display for c in self.states)

    def accept(self, y: Sequence[float] | Vector, t: float | None = None) -> None:
        """Make these states the point from which nonlinear blocks start."""
        self.t = self.t if t is None else t
        self.y = np.array(y, dtype=float)
        self.outputs(self.y)
        if misses(self.program, self.kernel):
            raise self._unsolved()
        self.kernel.accept(self.t)

    def rhs(self, y: Vector) -> Vector:
        """Derivatives of the states."""
        ydot = [0.0] * len(self.y)
        if self.kernel.rhs(self.t, y.tolist(), ydot) != 0 or not np.all(np.isfinite(ydot)):
            raise self._unsolved()
        return np.array(ydot)

    def outputs(self, y: Vector) -> Vector:
        """The whole workspace."""
        if self.kernel.outputs(self.t, y.tolist()) != 0:
            raise self._unsolved()
        return np.array(self.kernel.w, dtype=float)

    def _unsolved(self) -> PlanarcError:
        return error(
            "R470",
            f"the equations have no solution near t = {self.t:.6g} s",
            hint="the mechanism may be at the end of its reach there",
        )

    def settle(self) -> bool:
        """Give relations the truth that they have here; whether one changed."""
        g = [0.0] * len(self.program.relations)
        if not g or self.kernel.roots(self.t, self.y.tolist(), g) != 0:
            return False
        changed = False
        for relation, value in zip(self.program.relations, g, strict=True):
            truth = float(value < 0 or (value == 0 and not relation.strict))
            changed |= truth != self.kernel.w[relation.slot]
            self.kernel.w[relation.slot] = truth
        if changed:
            self.kernel.discrete()
            self.accept(self.y)
        return changed

    def reselect(self) -> None:
        """Choose the states anew for the present values."""
        self.outputs(self.y)
        self.run.states.choose(self.t, ())
        self.accept([float(v) for v in self.run.states.values()])

    def values(self) -> dict[str, float]:
        """All variables and parameters, by name."""
        w = self.outputs(self.y)
        return {c.name: c.sign * float(w[c.slot]) for c in self.program.columns}

    def starts(self) -> dict[str, float]:
        """Start values that lead to this point."""
        return starts_at(self.program, self.outputs(self.y))


def starts_at(program: Program, w: Sequence[float] | Vector) -> dict[str, float]:
    """The values in a workspace as start values: of candidates for states, and of other
    variables that have one."""
    columns = {c.name: c for c in program.columns}
    found = {}
    items: tuple[CandidateSlot | FixedSlot, ...] = (*program.candidates, *program.fixed)
    for item in items:
        column = columns.get(item.display)
        if column is not None and column.slot == item.slot:
            found[item.display] = column.sign * float(w[item.slot])
        elif isinstance(item, CandidateSlot):
            found[item.name] = float(w[item.slot])
    return found


def derivative(f: Callable[[Vector], Vector], x: Vector, step: float = STEP) -> Vector:
    """The Jacobian of a smooth function, by central differences of order four; `step` is
    relative to max(1, |x|)."""
    return central(f, x, [step * max(1.0, abs(v)) for v in x], 4)


def open_point(
    model: Model,
    options: RunOptions,
    inputs: Mapping[str, Signal] | None = None,
    at: float | None = None,
) -> Point:
    """The point at the start of a run, or at a time that the run reaches."""
    compiled = model.compiled(options.backend)
    program = compiled.program
    if program.delays:
        raise error(
            "R474",
            f"`{program.name}` uses `delay`, so that its past belongs to its state: it has no"
            " linear model and no state of rest here",
            program.delays[0].span,
        )
    begin = program.experiment.start if options.start is None else options.start
    options = replace(options, stop=max(begin, program.experiment.stop) if at is None else at)
    if not options.solver.home:  # a whole run is no way to a point
        options = replace(options, solver=Solver.AUTO)
    options, signals = model.sorted_inputs(options, inputs)
    kernel = model.forced(compiled.load(), options, signals)
    request = resolve(program, options)
    run = Run(program, kernel, request, str(options.backend))
    try:
        run.begin()
        if at is not None and at > begin:
            run.go(None)
        if run.ended is not None:
            raise PlanarcError(run.ended)
        y = [float(v) for v in run.integrator.y]
        return Point(model, options.backend, run, request.start if at is None else at, y)
    finally:
        run.close()
