"""A point of a mechanism that is dragged: the mechanism follows along its freedom.

In:   Model, options, Result (what is shown), the time, component and place that are taken hold of
Out:  for each place of the pointer the position that brings the point nearest to it

A position q of the candidates holds the conditions g(q) = 0 of the loops. Each step goes towards
the pointer where the conditions let it, and back onto them (Gauss, Newton): with the Jacobians G
of g and P of the point p,

    dq = -pinv(G)*g + Z*y,   Z spans the null space of G,
    y = argmin |p + P*dq - target|^2 + c*|y|^2

Example: the tip of a pendulum follows the pointer around its hinge; that of a four-bar's coupler
keeps to its curve.

Promises:  the loops are closed at every place that is told; the start values of that place lead a
           run to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from planarc.api.analysis.assemble import position_names, position_stage
from planarc.api.analysis.point import starts_at
from planarc.core.arrays import Vector, spread
from planarc.ir.mechanism import GROUND
from planarc.live.follow import Pose, Tie, follow, tie
from planarc.solve.opened import open_program
from planarc.solve.start.system import System
from planarc.view.scene import make_scene

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.core.options import RunOptions
    from planarc.ir.program import Column
    from planarc.ir.result import Result

#: Steps for one place of the pointer, the longest of them (rad, m), and what is closed.
_STEPS, _LONGEST, _CLOSED = 30, 0.3, 1e-9
#: The cost of moving against that of being away from the pointer.
_COST = 1e-8
#: Rows of the run by which sizes in the picture are measured.
_ROWS = 30
#: How far away (rad, m) the freedoms are seen.
_NEAR = 0.02


class Grip:
    """A hold on a mechanism. `take` it, then `move` it."""

    def __init__(self, model: Model, options: RunOptions, result: Result, time: float) -> None:
        program, kernel = model.program, model.compiled().load()
        request = open_program(program, kernel, options)
        self._program, self._kernel, self._result = program, kernel, result
        self._system = System(program, kernel, request.start, frozenset(request.starts))
        self._rows, self._columns = position_stage(self._system)
        self._u = np.array(
            [np.interp(time, result.time, result[c.name]) for c in program.candidates]
        )
        mechanism = program.mechanism
        links = enumerate(mechanism.links) if mechanism else ()
        frames = {n: [f for f in k.frames if f"{f}.phi" in result] for n, k in links if n != GROUND}
        self._moving = [f for own in frames.values() for f in own]
        self._axes = {n: self._pose_of(own[0]) for n, own in frames.items() if own}
        self._ties = self._tie()
        self._slots: tuple[int, ...] = ()
        self._signs = np.ones(3)
        self._place = np.zeros(2)

    def take(self, components: Sequence[str], x: float, y: float) -> bool:
        """Take hold of a point of a link that moves; False where there is none."""
        frame = self._frame(components)
        if frame is None or not self._columns:
            return False
        columns = self._pose_of(frame)
        self._slots = tuple(c.slot for c in columns)
        self._signs = np.array([c.sign for c in columns], dtype=float)
        values = self._values(self._u)
        if values is None:
            return False
        a, b, phi = self._signs * values[self._system.rows :]
        c, s = np.cos(phi), np.sin(phi)
        self._place = np.array([c * (x - a) + s * (y - b), c * (y - b) - s * (x - a)])
        return True

    def move(self, x: float, y: float) -> bool:
        """Bring the point as near to a place as the mechanism lets it; False where the loops
        would open: then nothing has moved."""
        u, target = self._u.copy(), np.array([x, y])
        for _ in range(_STEPS):
            step = self._step(u, target)
            if step is None or np.max(np.abs(step), initial=0.0) < 1e-8:
                break
            u = self._nearer(u, step, target)
        return self._close(u)

    def _nearer(self, u: Vector, step: Vector, target: Vector) -> Vector:
        """A step, or so much of it that the point does not go away from the pointer: far from
        it the curve on which the point moves bends more than the distance shrinks."""
        away = self._distance(u, target)
        for part in (1.0, 0.5, 0.25, 0.1):
            new = u.copy()
            new[self._columns] += part * step
            if self._distance(new, target) < away:
                break
        return new

    def _distance(self, u: Vector, target: Vector) -> float:
        values = self._values(u)
        if values is None:
            return np.inf
        point, _ = self._point(values)
        return float(np.hypot(*(target - point)))

    def _point(self, values: Vector) -> tuple[Vector, Vector]:
        """The point that is held, and its derivative by the angle of its link."""
        a, b, phi = self._signs * values[self._system.rows :]
        (p, q), (c, s) = self._place, (np.cos(phi), np.sin(phi))
        return np.array([a + c * p - s * q, b + s * p + c * q]), np.array(
            [-s * p - c * q, c * p - s * q]
        )

    def start(self) -> Mapping[str, float]:
        """Start values of the position."""
        self._system(self._u)
        names = position_names(self._system, self._columns)
        return {n: v for n, v in starts_at(self._program, self._kernel.w).items() if n in names}

    def poses(self) -> list[tuple[float, ...]]:
        """Place, angle, length and width of each item of the scene, in its order; of what cannot
        follow they are no numbers."""
        return follow(self._ties, self._links(self._u))

    def _tie(self) -> tuple[Tie, ...]:
        """How the items of the scene hang on the links: seen at positions nearby, beside rows of
        the run, by which sizes in the picture are measured."""
        result = self._result
        keep = spread(len(result.time), _ROWS)
        slots = sorted(result.stored, key=lambda slot: result.stored[slot])
        near, poses = [], []
        for u in self._nearby():
            self._fill(u)
            near.append([float(self._kernel.w[slot]) for slot in slots])
            poses.append(self._links(u))
        time = np.concatenate([result.time[keep], result.time[-1] + 1.0 + np.arange(len(near))])
        seen = replace(result, time=time, data=np.vstack([result.data[keep], near]))
        scene = make_scene(seen)
        links = {n: np.array([p[n] for p in poses]).T for n in poses[0]}
        box = scene.box or (0.0, 0.0, 1.0, 1.0)
        return tie(scene.items, links, max(box[2] - box[0], box[3] - box[1]))

    def _fill(self, u: Vector) -> None:
        """Fill the workspace at a position: also with what no position depends on, such as the
        length of a spring, where that leaves the position as it is."""
        kernel, t = self._kernel, self._system.t
        self._system(u)
        kernel.accept(t)
        flag = kernel.outputs(t, [float(u[i]) for i in kernel.selection])
        here = [float(kernel.w[self._program.candidates[c].slot]) for c in self._columns]
        if flag != 0 or not np.allclose(here, u[self._columns], atol=1e-6):
            self._system(u)

    def _nearby(self) -> list[Vector]:
        """The position, and one beside it along each freedom."""
        found, kept = [self._u.copy()], self._u
        slopes = self._system.slopes(self._u, None)
        if slopes is not None:
            free = _null_space(slopes[self._rows][:, self._columns])
            for way in (*free.T, free.sum(axis=1)):
                u = kept.copy()
                u[self._columns] += _NEAR * way
                if self._close(u):
                    found.append(self._u)
        self._u = kept
        return found[::-1]

    def _links(self, u: Vector) -> dict[int, Pose]:
        """The poses of the links at a position; the ground stands still."""
        self._system(u)
        w, found = self._kernel.w, {GROUND: (0.0, 0.0, 0.0)}
        for number, columns in self._axes.items():
            x, y, phi = (c.sign * float(w[c.slot]) for c in columns)
            found[number] = (x, y, phi)
        return found

    def _frame(self, components: Sequence[str]) -> str | None:
        """A frame, of a link that moves, of the first component that has one."""
        for name in components:
            while name:
                inside = (f for f in self._moving if f.startswith(f"{name}."))
                if (frame := next(inside, None)) is not None:
                    return frame
                name = name.rpartition(".")[0]
        return None

    def _pose_of(self, frame: str) -> list[Column]:
        return [self._result.columns[f"{frame}.{v}"] for v in ("r[1]", "r[2]", "phi")]

    def _values(self, u: Vector) -> Vector | None:
        return self._system.values(u, self._slots)

    def _step(self, u: Vector, target: Vector) -> Vector | None:
        """A step of the positions; None where something has no value."""
        values, slopes = self._values(u), self._system.slopes(u, None, self._slots)
        if values is None or slopes is None:
            return None
        first = self._system.rows
        conditions, by = values[self._rows], slopes[self._rows][:, self._columns]
        frame = self._signs[:, None] * slopes[first:][:, self._columns]
        point, turned = self._point(values)
        moved = frame[:2] + np.outer(turned, frame[2])
        back = -np.linalg.pinv(by) @ conditions if len(self._rows) else np.zeros(by.shape[1])
        free = _null_space(by)
        ahead = moved @ free
        away = target - point - moved @ back
        cost = _COST * max(1e-300, float(np.sum(moved * moved))) * np.eye(free.shape[1])
        step: Vector = back + free @ np.linalg.solve(ahead.T @ ahead + cost, ahead.T @ away)
        longest = float(np.max(np.abs(step), initial=0.0))
        return step * min(1.0, _LONGEST / longest) if longest > 0 else step

    def _close(self, u: Vector) -> bool:
        """Newton's steps onto the conditions; the position is kept if they end there."""
        for _ in range(_STEPS):
            values = self._system(u)
            if values is None:
                return False
            conditions = values[self._rows]
            if np.max(np.abs(conditions), initial=0.0) < _CLOSED:
                self._u = u
                return True
            slopes = self._system.slopes(u, None)
            if slopes is None:
                return False
            by = slopes[self._rows][:, self._columns]
            u[self._columns] -= np.linalg.pinv(by) @ conditions
        return False


def _null_space(matrix: Vector) -> Vector:
    """An orthonormal basis of what a matrix takes to zero, one column each."""
    if not len(matrix):
        return np.eye(matrix.shape[1])
    _, sizes, right = np.linalg.svd(matrix)
    rank = int(np.sum(sizes > 1e-9 * max(float(sizes[0]), 1e-300)))
    basis: Vector = right[rank:].T
    return basis
