"""A state of rest: where the mechanism would stay.

In:   Model, parameters, start values, inputs (time stands still at the start)
Out:  Equilibrium

Velocities are held at zero. Positions q follow the accelerations that they then have,

    dq/ds = a(q),

which, as M*a = -dV/dq, leads downhill and ends only in a stable equilibrium; first-order
states x follow their own derivatives. Steps are implicit (one Newton step each), their
size grows as the accelerations fall, until they are Newton's own.

Example: a pendulum of length 1 m hangs at phi = -pi/2, from whichever side it starts.

What touches at the start is held, what is open stays open: where the way leads through a stop, or
something that only presses would have to pull, there is no answer.

Promises:  a start that is an equilibrium already is kept, even an unstable one (`stable`).
Reference: C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35(2), 1998, 508-523
           (pseudo-transient continuation).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from planarc.api.analysis.point import Point, derivative, open_point
from planarc.api.analysis.rubbing import told_at_rest
from planarc.api.htmltable import html_table
from planarc.api.signals import Signal
from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, error
from planarc.core.options import RunOptions
from planarc.core.unknown import refuse_unknown

if TYPE_CHECKING:
    from planarc.api.model import Model

STEPS = 500
#: Longest change of a coordinate in one step (radians, metres).
LONGEST = 0.3
#: Accelerations below this part of the largest of the start (or of 1) count as zero.
SMALL = 1e-9
#: Overlaps beyond this, in m or rad, and forces beyond that part of the largest are not rounding.
DEEP, ROUNDING = 1e-7, 1e-6
#: Slopes of the pull below this, in 1/s2 or 1/s, are those of a plane.
FLAT = 1e-7


class Equilibrium(Data):
    """A state of rest. `start` are start values for `simulate`; `values` all variables there, by
    name, in SI units.

    `stable`: the mechanism comes back after any small push; `neutral`: after some push it stays
    where it was pushed to, as a ball on a table does. It is unstable where it is neither.
    `warnings` tell of joints that dry friction holds (R475).
    """

    start: Mapping[str, float]
    values: Mapping[str, float]
    stable: bool
    steps: int
    neutral: bool = False
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def kind(self) -> str:
        """`stable`, `neutral` or `unstable`."""
        return "stable" if self.stable else "neutral" if self.neutral else "unstable"

    def __repr__(self) -> str:
        listed = ", ".join(f"{n} = {v + 0.0:.6g}" for n, v in self.start.items())
        return f"<Equilibrium, {self.kind}: {listed}>"

    def _repr_html_(self) -> str:
        note = f"Equilibrium, {self.kind}"
        return html_table(("start value", ""), self.start.items(), note)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.values)

    def __getitem__(self, name: str) -> float:
        """The value of a variable there, in its SI unit. Raises UnknownName."""
        refuse_unknown("variable", (name,), self.values)
        return self.values[name]


def find_equilibrium(
    model: Model, options: RunOptions, inputs: Mapping[str, Signal] | None
) -> Equilibrium:
    """The equilibrium. Raises PlanarcError R471 where none is found."""
    return settle_down(open_point(model, options, inputs))


def settle_down(point: Point) -> Equilibrium:
    """Go from a point to the equilibrium below it."""
    way = _Way(point)
    way.rest()
    size = first = way.size()
    begin = 0.2 / first if first else 1.0
    pseudo = begin
    for step in range(STEPS):
        jacobian = derivative(way.pull, way.position())
        growth = max(
            (float(v.real) for v in np.linalg.eigvals(way.moving(jacobian))), default=-np.inf
        )
        zero = SMALL * max(1.0, min(first, 100.0))
        if size <= zero and not (pseudo < 1e6 and step < 3 and size > 0):
            refuse_beyond(point)
            stable, neutral = growth < -FLAT, abs(growth) <= FLAT
            told = told_at_rest(point)
            return Equilibrium(point.starts(), point.values(), stable, step, neutral, told)
        if growth > 0 and size > zero:  # above a hill: no larger step than leads down from it
            pseudo = min(pseudo, 0.5 / growth)
        pseudo, size = way.step(jacobian, pseudo, size)
    refuse_beyond(point, at_rest=False)
    raise error(
        "R471",
        f"no equilibrium was found: after {STEPS} steps there is still an acceleration of "
        f"{size:.3g}",
        hint="is there anything that holds the mechanism? start values nearer to rest may help",
    )


def refuse_beyond(point: Point, at_rest: bool = True) -> None:
    """Refuse a state of rest that the model's touches do not allow, or a way that leads through
    them and on. Raises PlanarcError R471."""
    from planarc.solve.contact import messages
    from planarc.solve.contact.touches import Touches

    touches = Touches(point.program, point.kernel)
    if not len(touches.all) or not touches.evaluate(point.t, point.y.tolist()):
        return
    gap, pressing, held = (touches.get(n) for n in ("gap", "f_n", "held"))
    least = ROUNDING * max(1.0, float(np.abs(pressing).max()))
    through = ~touches.bound & (held == 0) & (gap < -DEEP)
    pulled = at_rest & ~touches.bound & (held != 0) & (pressing < -least)
    for wrong, pulls in ((through, False), (pulled, True)):
        for i in np.flatnonzero(wrong):
            raise PlanarcError(messages.passed_through(touches, int(i), pulls))


class _Way:
    """The place of the search: the states that are no velocities, and what pulls at them."""

    def __init__(self, point: Point) -> None:
        self.point = point
        self.plan()

    def plan(self) -> None:
        """What is free, and the slots of its rates: of a coordinate that is the acceleration, also
        where its velocity follows from that of another one, which is the state."""
        states, candidates = self.point.states, self.point.program.candidates
        rates = {c.slot: c.derivative for c in candidates}
        speeds = {*rates.values()}
        self.velocities = [i for i, c in enumerate(states) if c.slot in speeds]
        self.free = [i for i in range(len(states)) if i not in self.velocities]
        first = [states[i].derivative for i in self.free]
        self.coordinates = np.array([slot in rates for slot in first], dtype=bool)
        self.rates = [rates.get(slot, slot) for slot in first]

    def moving(self, jacobian: Vector) -> Vector:
        """Without states that are constant, as the phase of teeth is: they are no way to go."""
        moves = np.flatnonzero(jacobian.any(axis=1) | self.coordinates)
        return jacobian[np.ix_(moves, moves)]

    def rest(self) -> None:
        y = self.point.y.copy()
        y[self.velocities] = 0.0
        self.point.accept(y)
        self.point.settle()

    def position(self) -> Vector:
        return self.point.y[self.free]

    def pull(self, z: Vector) -> Vector:
        y = self.point.y.copy()
        y[self.free] = z
        found: Vector = self.point.outputs(y)[self.rates]
        return found

    def size(self) -> float:
        return float(np.linalg.norm(self.pull(self.position())))

    def step(self, jacobian: Vector, pseudo: float, size: float) -> tuple[float, float]:
        """One step in pseudo-time; gives the next step size and the pull left."""
        z = self.position()
        for _ in range(30):
            matrix = np.eye(len(z)) / pseudo - jacobian
            change = np.linalg.lstsq(matrix, self.pull(z), rcond=None)[0]
            longest = float(np.max(np.abs(change), initial=0.0))
            if longest <= LONGEST and (reached := self._go(z + change)) is not None:
                grown = pseudo * min(10.0, max(0.1, size / reached)) if reached else 1e12
                return min(1e12, grown), reached
            pseudo /= 4
        raise _dead_end()

    def _go(self, z: Vector) -> float | None:
        old, y = self.point.y.copy(), self.point.y.copy()
        y[self.free] = z
        try:
            self.point.accept(y)
            if self.point.run.states.selector.open:
                self.point.reselect()
                self.plan()
            self.point.settle()
            return self.size()
        except PlanarcError:
            try:
                self.point.accept(old)
            except PlanarcError:  # where bars lie flat, hardly anything leads back, either
                raise _dead_end() from None
            return None


def _dead_end() -> PlanarcError:
    return error(
        "R471",
        "no equilibrium was found: the way down ends where the equations have no solution",
        hint="choose other start values",
    )
