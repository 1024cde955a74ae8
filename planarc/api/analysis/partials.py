"""Partial derivatives of a model's equations at points of a motion.

In:   a Point, parameters; time and states
Out:  d(values)/d(states) and d(values)/d(parameters), and d(start)/d(parameters)

`Formulas` takes them from the kernel, which has them from the expressions by the implicit
function theorem (`codegen.slopes`). Where a function has no derivative, or none at some
point, `Differences` takes central differences of the equations, which are solved to
rounding, of order four by states and of order two by parameters; every changed parameter
has a kernel of its own, so that closed loops stay on their branch.

The start moves with parameters, too: the candidates h that the start holds keep to their
start values, so that of all values z(y, p)

    dh/dy * dy/dp + dh/dp = d(start of h)/dp

gives the motion of the states. With initial equations it is differenced.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from msgspec.structs import replace

from planarc.api.analysis.point import Point, derivative, open_point
from planarc.core.arrays import Vector
from planarc.core.options import RunOptions
from planarc.ir.program import CandidateSlot, FixedSlot
from planarc.solve.settings import resolve

if TYPE_CHECKING:
    from planarc.api.model import Model

#: Steps of central differences, relative: of order two by parameters, four by states.
STEP, STATE_STEP = 1e-5, 3e-6
#: Held values whose motions are this near to dependent do not tell how the states move.
DEPENDENT = 1e-9


class NoFormulaError(Exception):
    """There is a function without derivative, or none at this point."""


class Partials(Protocol):
    name: str

    def start(self) -> Vector:
        """d(states)/d(parameters) at the start."""

    def at(self, t: float, y: Vector, slots: Sequence[int]) -> tuple[Vector, Vector, Vector]:
        """Values, and their derivatives by states and by parameters; `slots` tells which.
        PlanarcError where the equations have no solution."""

    def follow(self) -> None:
        """Take the choice of states, the time and the states of the point."""


class Formulas:
    name = "formulas"

    def __init__(self, point: Point, parameters: Mapping[str, float], options: RunOptions) -> None:
        self._point = point
        program = point.program
        known = {p.name: p.slot for p in program.parameter_slots}
        self._leaves = [known[name] for name in parameters]
        self._given = frozenset(resolve(program, options).starts)
        self._formulas = point.kernel.capabilities.formulas

    def start(self) -> Vector:
        program, point = self._point.program, self._point
        if program.initial_residuals:
            raise NoFormulaError
        written = {h.name for h in point.run.held[len(program.candidates) :]}
        others = (f for f in program.fixed if f.display in written)
        items: list[CandidateSlot | FixedSlot] = [*program.candidates, *others]
        held = [i for i, h in zip(items, point.run.held, strict=True) if h.held]
        n = len(point.y)
        _, by_states, by_parameter = self.at(point.t, point.y, [i.slot for i in held])
        _, _, moved = self.at(point.t, point.y, [i.start for i in held])
        moved[[i.start in self._given for i in held]] = 0.0
        found, _, rank, _ = np.linalg.lstsq(by_states, moved - by_parameter, rcond=DEPENDENT)
        if rank < n:
            raise NoFormulaError
        return np.asarray(found, dtype=float)

    def at(self, t: float, y: Vector, slots: Sequence[int]) -> tuple[Vector, Vector, Vector]:
        formulas = self._formulas
        at = t, y.tolist(), self._leaves, slots
        found = None if formulas is None else formulas.derivatives(*at)
        if found is None:
            self._point.t = t
            self._point.outputs(y)  # an error, where there is no solution
            raise NoFormulaError
        n = len(y)
        return np.array(self._point.kernel.w)[slots], found[:, :n], found[:, n:]

    def follow(self) -> None:
        pass


class Differences:
    name = "differences"

    def __init__(
        self, point: Point, model: Model, parameters: Mapping[str, float], options: RunOptions
    ) -> None:
        self._point = point
        self._steps = [STEP * (abs(v) or 1.0) for v in parameters.values()]
        self._sides = [
            tuple(
                open_point(
                    model, replace(options, values={**options.values, name: value + sign * h})
                )
                for sign in (1.0, -1.0)
            )
            for (name, value), h in zip(parameters.items(), self._steps, strict=True)
        ]

    def start(self) -> Vector:
        slots = [c.slot for c in self._point.states]
        starts = [[p.outputs(p.y)[slots] for p in pair] for pair in self._sides]
        columns = [(a - b) / (2 * h) for (a, b), h in zip(starts, self._steps, strict=True)]
        return np.array(columns).T.reshape(len(slots), len(self._steps))

    def at(self, t: float, y: Vector, slots: Sequence[int]) -> tuple[Vector, Vector, Vector]:
        for point in (self._point, *self._points()):
            point.t = t
        values = self._point.outputs(y)[slots]
        # Steps so short are exact enough near dead centres, too.
        by_state = derivative(lambda at: self._point.outputs(at)[slots], y, STATE_STEP)
        columns = [
            (a.outputs(y)[slots] - b.outputs(y)[slots]) / (2 * h)
            for (a, b), h in zip(self._sides, self._steps, strict=True)
        ]
        return values, by_state, np.array(columns).T.reshape(len(slots), len(self._steps))

    def follow(self) -> None:
        base = self._point
        for point in self._points():
            point.run.states.take(base.selection)
            point.accept(base.y, base.t)

    def _points(self) -> list[Point]:
        return [p for pair in self._sides for p in pair]
