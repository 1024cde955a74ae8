"""Steps of one length with contacts: Moreau's midpoint rule.

In:   the states at the begin of a step
Out:  the states at its end, and what pressed in between

    1  half a step with the old velocities: there, forces, gaps and matrices are evaluated
    2  velocities without contacts, by the forces there; by those of the mean velocities once
       these are known
    3  impulses, so that at the end of the step no gap is negative, and that what meets with v
       leaves with e*v (Newton) if it is faster than what a step of free motion gives; friction
       (`impulses`)
    4  half a step with the new velocities

Free bodies in a uniform field keep their energy exactly, and the work of an impulse is
P*(u_before + u_after)/2 <= 0: gaps are kept by not being closed further than to zero, never by
pushing bodies apart.

Example: a ball of 1 kg at rest on the floor, h = 1 ms: P = 9.81e-3 N.s in every step, no motion.

Reference: J. J. Moreau, Comput. Methods Appl. Mech. Eng. 177, 1999, 329-349.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from planarc.core.arrays import taken
from planarc.core.diagnostic import PlanarcError
from planarc.ir.kernel import Kernel, Pressed
from planarc.ir.program import Program
from planarc.solve.contact import messages
from planarc.solve.contact.impacts import DEEP
from planarc.solve.solvers.fixed import REST, FixedStep
from planarc.solve.solvers.integrator import Cause, March, Outcome, Settings
from planarc.solve.solvers.poles import Poles
from planarc.solve.solvers.stepping import Unsolved
from planarc.solve.stepping.crowd import Crowd
from planarc.solve.stepping.ports import Ports
from planarc.solve.stepping.refusal import (
    body,
    overlap,
    refuse_what_events_need,
    without_room,
)
from planarc.solve.stepping.struck import Contacts, Struck

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: Forces of which the mean velocities change less, as parts of what they add, are as before.
SAME = 1e-9
#: What is farther apart than this part of a radius, and does not approach, is far.
FAR = 0.02
#: Contacts without room are looked for again where some are so many times deeper.
DEEPER = 2.0
#: Evaluations of a step in machine code: at its middle, without contacts, and with the mean speeds.
CALLS = 3


class _NoPoles(Poles):
    """Velocities that jump say nothing of poles."""

    def note(self) -> bool:
        return False


class Moreau(FixedStep):
    """Steps of `length` in seconds."""

    ends_evaluated = True

    def __init__(self, program: Program, kernel: Kernel, states: int, settings: Settings) -> None:
        length = settings.fixed_step or 1.0
        super().__init__(kernel, states, settings, "euler", length)
        self.name = f"stepping (steps of {length:g} s)"
        self.slack = REST * self._length
        self.poles = _NoPoles(kernel, states, False)
        self._ports = Ports(program, kernel)
        self._machine = kernel.capabilities.reacting().steps
        members = self._ports.crowds()
        self._crowds = [Crowd(self._ports, m) for m in members.values()]
        counts = (len(self._ports.touches.all), *(2 * len(m) ** 2 for m in members.values()))
        self._first_keys = np.cumsum(counts).tolist()  # of each crowd, behind those of touches
        refuse_what_events_need(self._ports)
        self._looked = False  # whether the start was
        self._candidates = program.candidates
        self._ports.touches.ignore()
        self._known: Pressed = (np.zeros(0, dtype=np.int64), np.zeros((0, 2)))
        if self._machine is not None:
            self._machine.pressed = self._known  # its memory is that of an earlier run, maybe
        self._middle: tuple[float, Vector] = (0.0, np.zeros(states))
        self._struck = np.zeros(states, dtype=bool)  # what contacts changed in the last step
        self._deepest = 0.0  # where contacts without room were looked for in vain

    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        self._origin, self._index = self._t, 0
        chosen = [self._candidates[i] for i in self._kernel.selection]
        index = {c.slot: i for i, c in enumerate(chosen)}
        velocities = {c.slot for c in self._candidates}
        self._rates = np.array([c.derivative for c in chosen], dtype=np.int64)
        self._places = np.array([c.derivative in velocities for c in chosen], dtype=bool)
        #: The state that is the derivative of a place; -1 where it follows from others.
        self._speeds = np.array(
            [index.get(c.derivative, -1) for c in chosen if c.derivative in velocities],
            dtype=np.int64,
        )
        self._middle = (self._t, np.array(self._y))
        self._before = (self._t, self._y, self._slope)
        if not self._looked:
            if self._machine is None or not self._machine.are_apart(self._y):
                self._refuse_overlaps()
            self._looked = True

    def _refuse_overlaps(self) -> None:
        """Raises R480 where bodies start in each other; the workspace holds the start."""
        touches = self._ports.touches
        gap = touches.get("gap")
        if len(gap) and gap.min() < -DEEP:
            raise PlanarcError(messages.overlapping(touches, int(gap.argmin()), gap, self._t))
        for crowd in self._crowds:
            crowd.begin()
            found = crowd.find(0.0)
            if len(found.gap) and found.gap.min() < -DEEP:
                i = int(found.gap.argmin())
                pair = [crowd.members[int(m[i])] for m in (found.first, found.second)]
                a, b = (m.read["x"] for m in pair)
                depth, name = f"{-float(found.gap[i]):.3g}", pair[0].crowd
                names = body(a), body(b)
                raise PlanarcError(overlap(self._ports.program, name, self._t, names, depth))

    def step(self, limit: float) -> March:
        begin, t = self._t, self._next(limit)
        try:
            y = self._moved_on(begin, t - begin)
            if not np.isfinite(y).all():
                return March(Outcome.FAILED, cause=Cause.NOT_FINITE)
            self._before = (begin, self._y, self._slope)
            self._evaluate(t, y)
        except Unsolved as problem:
            return problem.march()
        self._steps += 1
        return self._rooted(t, y.tolist(), limit)

    def _moved_on(self, begin: float, h: float) -> Vector:
        """As `_moved_by`, in machine code where that has no doubt."""
        machine = self._machine
        if machine is None:
            return self._moved_by(begin, h)
        found = machine.step(begin, h, self._y, DEEPER * self._deepest)
        if found is None:
            self._known = machine.pressed
            end = self._moved_by(begin, h)
            machine.pressed = self._known
            return end
        self._calls += CALLS
        self._middle, self._struck = (begin + h / 2, found.middle), found.struck
        return found.end

    def _moved_by(self, begin: float, h: float) -> Vector:
        """The states after a step; forces at the ports are set to what pressed in it."""
        ports, w, moving = self._ports, self._kernel.w, ~self._places
        ports.push(np.zeros(ports.count))
        y, t = np.array(self._y), begin + h / 2
        half = y.copy()
        half[self._places] += h / 2 * self._speed(begin, y)
        self._evaluate(t, half)
        before, rates = ports.velocity(w), taken(w, self._rates)
        free = half.copy()
        free[moving] += h * rates[moving]
        self._evaluate(t, free)
        after = ports.velocity(w)
        contacts = self._find(h, before, after)
        struck = Struck(contacts, ports, t, free) if len(contacts.key) else None
        new = free if struck is None else struck.solve(h, before, after, free, self._known)
        mean = half.copy()
        mean[moving] = (y[moving] + new[moving]) / 2
        self._evaluate(t, mean)
        other = taken(w, self._rates)
        change = np.abs(other - rates)[moving]
        if (change > SAME * float(np.abs(rates[moving]).max(initial=0.0))).any():
            free[moving] = y[moving] + h * other[moving]
            self._evaluate(t, free)
            after, new = ports.velocity(w), free
            if struck is not None:
                new = struck.solve(h, before, after, free, struck.known)
        self._middle = (t, half)
        end, way = new.copy(), new
        self._struck = new != free
        if struck is not None:
            depth = float(struck.depths(h, before, struck.speeds).max())
            self._refuse_pinched(depth, begin, h, half, (before, after))
            ports.push(struck.impulse / h)
            self._known = struck.known
            way = struck.cleared(h, new)
        end[self._places] = half[self._places] + h / 2 * self._speed(t, way)
        return end

    def _refuse_pinched(
        self, depth: float, t: float, h: float, half: Vector, speeds: tuple[Vector, Vector]
    ) -> None:
        """Ends the run (R481) where contacts are deeper than they come in a step, and the reason is
        that motions that are given leave no room between them and those nearby."""
        if depth <= DEEPER * self._deepest:
            return
        self._deepest = depth
        self._evaluate(t + h / 2, half)
        near = Struck(self._find(h, *speeds, 2 * depth), self._ports, t + h / 2, half)
        if len(found := near.pinched(h, *speeds)):
            self.trouble = without_room(self._ports, self._crowds, self._first_keys, found, t)
            raise Unsolved(1)

    def _evaluate(self, t: float, y: Vector) -> None:
        self._calls += 1
        self._ports.read.t = t
        if (flag := self._kernel.outputs(t, cast("Sequence[float]", y))) != 0:
            raise Unsolved(flag)

    def _speed(self, t: float, y: Vector) -> Vector:
        """The derivatives of the places."""
        if (self._speeds >= 0).all():
            return y[self._speeds]
        self._evaluate(t, y)
        found: Vector = taken(self._kernel.w, self._rates)[self._places]
        return found

    def _find(self, h: float, before: Vector, after: Vector, wider: float = 0.0) -> Contacts:
        """All contacts that are closed, or may close within the step, at the place evaluated, and
        those that are less than `wider` farther apart."""
        from scipy.sparse import csr_array

        found = [self._touching(h, before, after, wider)]
        for number, crowd in enumerate(self._crowds):
            found.append(self._meeting(h, before, after, wider, self._first_keys[number], crowd))
        key, ports, along, across, gap, e, mu = (
            np.concatenate(parts) for parts in zip(*found, strict=True)
        )
        places = np.repeat(ports, 2, axis=0).astype(np.int32)
        values = np.stack([along, across], axis=1)
        starts = np.arange(0, 12 * len(key) + 1, 6, dtype=np.int32)
        jacobian = csr_array(
            (values.ravel(), places.ravel(), starts), shape=(2 * len(key), self._ports.count)
        )
        return Contacts(key, jacobian, gap, e, mu)

    def _touching(self, h: float, before: Vector, after: Vector, wider: float) -> tuple[Array, ...]:
        touches = self._ports.touches
        gap = touches.get("gap")
        n = len(gap)
        speeds = np.minimum(np.minimum(before, after)[: 2 * n : 2], 0.0)
        most = float(np.abs([before[: 2 * n], after[: 2 * n]]).max(initial=0.0))
        near = np.flatnonzero(gap + h * speeds < FAR * h * most + wider)
        k = len(near)
        ports, along, across = np.zeros((k, 6), dtype=np.int64), np.zeros((k, 6)), np.zeros((k, 6))
        ports[:] = 2 * near[:, None]
        ports[:, 1] += 1
        along[:, 0] = across[:, 1] = 1.0
        e, mu = touches.get("e"), touches.get("mu")
        return near, ports, along, across, gap[near], e[near], mu[near]

    def _meeting(
        self, h: float, before: Vector, after: Vector, wider: float, first_key: int, crowd: Crowd
    ) -> tuple[Array, ...]:
        speed = np.abs([before, after])[:, crowd.port[:, None] + np.arange(3)].max(axis=(0, 1))
        crowd.begin()
        far = FAR * float(crowd.radius[crowd.radius > 0].min()) + wider
        fastest = math.sqrt(speed[0] * speed[0] + speed[1] * speed[1])
        reach = far + 2 * h * float(fastest + speed[2] * crowd.bound.max())
        m = crowd.find(reach)
        x, y = m.normal[:, 0], m.normal[:, 1]
        ports = np.empty((len(x), 6), dtype=np.int64)
        along, across = np.empty((len(x), 6)), np.empty((len(x), 6))
        for side, (member, sign) in enumerate(((m.first, 1.0), (m.second, -1.0))):
            arm, at = m.at - crowd.origin[member], slice(3 * side, 3 * side + 3)
            ports[:, at] = crowd.port[member, None] + np.arange(3)
            turning = arm[:, 0] * y - arm[:, 1] * x, -arm[:, 0] * x - arm[:, 1] * y
            along[:, at] = sign * np.stack([x, y, turning[0]], axis=1)
            across[:, at] = sign * np.stack([y, -x, turning[1]], axis=1)
        speeds = np.minimum(*(_sums(along * v[ports]) for v in (before, after)))
        near = np.flatnonzero(m.gap + h * np.minimum(speeds, 0.0) < far)
        n = len(crowd.port)
        key = first_key + (m.first * n + m.second) * 2 + m.end
        first = m.first[near]
        return (
            key[near], ports[near], along[near], across[near], m.gap[near],
            crowd.e[first], crowd.mu[first],
        )  # fmt: skip

    def interpolate(self, t: float) -> Sequence[float]:
        """Straight ways with the old velocities, then with the new ones: what contacts change is
        changed between them."""
        begin, y0, _ = self._before
        if t >= self._t or self._t <= begin:
            return list(self._y)
        middle, half = self._middle
        first, last = np.array(y0), np.array(self._y)
        part = (t - begin) / (self._t - begin)
        found = np.where(self._struck, first if t < middle else last, first + part * (last - first))
        way = (
            first + 2 * part * (half - first)
            if t < middle
            else half + (2 * part - 1) * (last - half)
        )
        found[self._places] = way[self._places]
        numbers: list[float] = found.tolist()
        return numbers


def _sums(rows: Vector) -> Vector:
    """The sum of each row, from its begin on."""
    found: Vector = np.cumsum(rows, axis=1)[:, -1]
    return found
