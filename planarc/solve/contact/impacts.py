"""The operator `impact`: what touches do next, at an event at which one of them changes.

In:   the states at an instant
Out:  the states after impacts; in the workspace the modes of all touches

    strike    velocities jump, so that nothing approaches (`strike`); what approaches by less
              than the errors of a run rests without an impact
    modes     accelerations tell which touches hold, stick, slide and open (`problem`)
    rest      what bounces ever lower is held: its bounces take a geometric series of times

Example: a ball that falls on a floor. `gap < low` makes an event; v = -2 becomes 1 m/s with
e = 0.5, and the touch stays open; after many bounces it is held, and `rest` is the instant of the
last one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from planarc.core.diagnostic import Diagnostic
from planarc.ir.impact import KEPT
from planarc.ir.kernel import Kernel, TouchMemory
from planarc.ir.program import Program
from planarc.solve.contact import messages
from planarc.solve.contact.pinched import find_pinched
from planarc.solve.contact.pressed import solve_pressed
from planarc.solve.contact.problem import IDLE, STICKS, Solution, Spot, solve_case, solve_contacts
from planarc.solve.contact.strike import STILL, strike
from planarc.solve.contact.touches import TOLD, Response, Touches

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: Gaps below this, in m, are none; overlaps beyond that are mistakes of a start. Later what counts
#: is the tolerance, in m, where it is more; or that many times the depth of errors before.
NEAR, DEEP, MORE = 1e-10, 1e-7, 10.0
#: What opens meets again only this much deeper, in m: by then it has a speed. At an instant without
#: impacts that is the tolerance, in m: what opens is so slow that errors are larger.
CLEAR = 1e-12
#: A slip below this part of the fastest seen may be none; where it sticks or turns, below that; and
#: one below this in m/s is rounding.
SLOW, DRIFT, CREEP = 1e-8, 1e-6, 1e-12
#: A bounce begins a rest below the cube root of the tolerance, as a part of the greatest speed of
#: impact: the errors of lower arcs, and those of a geometric series of higher ones, are larger. It
#: also does where all later ones take less than this part of the run.
SHORT = 1e-11
#: Where what bounces falls as before, but for this part, the series is exact: there it begins below
#: this part of the greatest speed.
STEADY, EXACT = 1e-9, 3e-3
#: The least tolerance with which a low bounce is followed.
SHARPEST = 1e-15
#: A held touch with a speed above this part of the fastest seen, and so many times the tolerance in
#: m/s, or that, is held no more: a speed has jumped, or what is nearest to its point is now another
#: edge. Errors of a run are smaller, of bodies that move with what they touch, too.
MOVED, ERRS, MOVES = 1e-3, 100.0, 1e-7
#: Accelerations below this part of the largest seen are rounding.
NOISE = 1e-12
#: Friction within this part of its limit is at it.
LIMIT = 1e-9
#: What presses so changes accelerations by no more than this part where the motion is given: what
#: forces seem to do there is rounding.
NEGLIGIBLE = 1e-8
#: What is looked at before anything changes.
READ = ("gap", "v", "a", "slip", "a_slip", "e", "mu", *KEPT)
#: What a touch is that is open and has not just been.
OPEN = {"held": 0.0, "way": float(IDLE), "impulse": 0.0, "low": 0.0}


class Impacts:
    """What is remembered of a run's touches."""

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        span: float,
        tolerance: float,
        fixed_step: float | None = None,
    ) -> None:
        self._fixed_step = fixed_step
        self._least, self._tolerance = min(SHARPEST / tolerance, 1.0), tolerance
        self.sharpness = 1.0  # part of the tolerance that suits the bounces under way
        self._short, self._low = SHORT * span, math.cbrt(tolerance)
        self.touches = Touches(program, kernel)
        self._first = np.zeros(len(self.touches.all))  # greatest speeds of impacts
        self._falls = np.zeros(len(self.touches.all))  # accelerations after the last ones
        self._fastest = self._strongest = 0.0  # speed and acceleration of touches seen
        self._begins = True
        self._most = 0.0  # acceleration by 1 N that was seen
        self.components = self.touches.components
        self._begun = False

    def known(self, t: float) -> TouchMemory | None:
        """What machine code needs to know of the touches; None where the run cannot begin."""
        if not self._begun:
            if messages.begun_wrong(self.touches, t) is not None:
                return None
            self._begun = True
        touches = np.concatenate([self._first, self._falls, self.touches.force])
        sizes = self._fastest, self._strongest, self._most
        return TouchMemory(touches, sizes, self._begins, self.sharpness)

    def take(self, known: TouchMemory, struck: Sequence[Vector]) -> list[str]:
        """What machine code knows now; tells what happened at each strike."""
        n = len(self.touches.all)
        self._first, self._falls, self.touches.force = np.split(known.touches, [n, 2 * n])
        self._fastest, self._strongest, self._most = known.sizes
        self._begins, self.sharpness = known.begins, max(self._least, known.sharpness)
        found = []
        for rows in struck:
            before, after = (dict(zip(TOLD, half, strict=True)) for half in (rows[::2], rows[1::2]))
            found += messages.told(self.touches, before, after)
        return found

    def resolve(
        self, t: float, y: list[float], states: Mapping[int, int]
    ) -> tuple[list[str], Diagnostic | None]:
        """Change the states in place and set the modes. Gives what happened, and why the run cannot
        go on, if so."""
        if not self.touches.evaluate(t, y):
            return [], messages.unsolved(self.touches, t)
        if not self._begun:
            self._begun = True
            if (wrong := messages.begun_wrong(self.touches, t)) is not None:
                return [], wrong
        before = {name: self.touches.get(name) for name in READ}
        gap, speed = before["gap"] - before["low"], np.abs(before["v"])
        least = DEEP if self._begins else max(DEEP, self._tolerance)
        deepest = MORE * np.minimum(before["low"], 0.0) - least
        begins, self._begins = self._begins, False
        deep = np.flatnonzero((before["held"] == 0) & (gap < deepest))
        if len(deep):
            if self._fixed_step is not None and not begins:
                return [], messages.stepped_over(self.touches, int(deep[0]), gap, t)
            return [], messages.overlapping(self.touches, int(deep[0]), gap, t)
        moves = max(self._fastest, float(np.abs([before["v"], before["slip"]]).max()))
        was = before["held"].copy()
        errors = max(MOVES, ERRS * self._tolerance)
        before["held"][speed > errors + MOVED * moves] = 0.0
        held = before["held"] != 0
        some = np.flatnonzero(held | (before["gap"] <= NEAR))
        self.sharpness = 1.0
        if not len(some):
            for name, value in OPEN.items():
                self.touches.put(name, [value] * len(held))
            return [], None
        speeds = np.abs([before["v"][some], before["slip"][some]])
        self._fastest = max(self._fastest, float(speeds.max()))
        # What is said to slide, and stays where it is, is at its limit: others hold it.
        loose = held & (before["way"] != IDLE)
        loose &= np.abs(self.touches.get("f_t")) >= (1 - LIMIT) * before["mu"] * (
            self.touches.get("f_n")
        )
        pressing = float(np.abs(self.touches.get("f_n")).max()) or 1.0
        response = self.touches.respond(t, y, states, some.tolist())
        if response is None:
            return [], messages.unsolved(self.touches, t)
        self._most = max(self._most, float(np.abs(response[0].own).max()))
        size = max(1.0, float(np.abs(response[1]).max()))
        most = self._most if self._most * pressing > NEGLIGIBLE * size else size / pressing
        instant = _Instant(
            self.touches, before, some, response[0], loose, self._fastest, most,
            self._tolerance * self._first,  # errors of a run make such speeds
        )  # fmt: skip
        if (fixed := instant.fixed()) is not None:
            return [], messages.one_body(self.touches, fixed, t)
        x = instant.strike(self._first)
        if x is None and (pinched := instant.pinched(instant.u)):
            return [], messages.pinched(self.touches, pinched, t)
        if x is None or not instant.move(y, x):
            return [], messages.no_impact(self.touches, some.tolist(), before["mu"], t)
        free = response[1]
        if x.any():
            if not self.touches.evaluate(t, y):
                return [], messages.unsolved(self.touches, t)
            instant.refine(y, x, self.touches.speeds())
            free = self.touches.motion()
        else:  # what is held does not rest, but makes good its errors
            sticks = held & (before["way"] == STICKS)
            free = free - np.concatenate([held * before["a"], sticks * before["a_slip"]])
        self._strongest = max(self._strongest, float(np.abs(response[1]).max()))
        instant.noise = NOISE * self._strongest
        instant.press = partial(self.touches.pressed, t, y)
        low = self._first * self._low
        rest = instant.modes(free[instant.rows], low, self._first, self._falls, self._short)
        if rest is None and (pinched := instant.pinched(free[instant.rows])):
            return [], messages.pinched(self.touches, pinched, t)
        if rest is None:
            return [], messages.no_forces(self.touches, some.tolist(), before["mu"], t)
        instant.stop(y)
        self.sharpness = max(self._least, instant.height(self._first))
        after = self._set(t, instant, before, x, rest)
        return messages.told(self.touches, before | {"held": was}, after, begins), None

    def _set(
        self,
        t: float,
        instant: _Instant,
        before: Mapping[str, Vector],
        x: Vector,
        rest: Mapping[int, float],
    ) -> dict[str, Vector]:
        """Write the modes; gives what is kept now."""
        n, some = len(self.touches.all), instant.some
        after = {name: np.zeros(n) for name in KEPT}
        after["rest"][:] = before["rest"]
        after["way"][:] = IDLE
        after["impulse"][some] = instant.felt(x, max(CREEP, self._tolerance))
        rests = instant.u[: len(some)] <= instant.still
        clear = CLEAR * rests if x.any() else max(CLEAR, self._tolerance)
        after["low"][some] = np.minimum(before["gap"][some], 0.0) - clear
        for j, i in enumerate(some):
            closed, way = instant.cases[j]
            after["held"][i], after["way"][i] = closed, way if closed else IDLE
            if closed and not before["held"][i]:
                after["rest"][i] = t + rest.get(j, 0.0)
            if closed:
                now = before["low"] if before["held"][i] else before["gap"]
                after["low"][i] = now[i]
        for name, values in after.items():
            self.touches.put(name, values.tolist())
        return after


class _Instant:
    """The touches that are closed at an instant; `some` are their numbers."""

    def __init__(
        self,
        touches: Touches,
        before: Mapping[str, Vector],
        some: Array,
        response: Response,
        loose: Array,
        fastest: float,
        most: float,
        least: Vector,
    ) -> None:
        n, k = len(touches.all), len(some)
        self.some, self.rows = some, np.concatenate([some, n + some])
        self._k, self._a, self._states = k, response.own[self.rows], response.states
        self._joints = touches.bound[some]
        self._most = most
        bound = np.flatnonzero(self._joints)
        self._a[bound, bound] = most  # as if a force of its own met a limit
        self.press: Callable[[Array, Vector], Vector | None] = lambda _, x: x
        v, held = before["v"][some], before["held"][some] != 0
        self._drift = np.concatenate([held * v, np.zeros(k)])  # what is held does not approach
        self.u = np.concatenate([v, before["slip"][some]]) - self._drift
        self._e, self._mu = before["e"][some], before["mu"][some]
        self._way, self._loose, self._fastest = before["way"][some], loose[some], fastest
        self.noise = 0.0  # an acceleration that is none
        self.cases: tuple[tuple[bool, int], ...] = ()
        largest = float(np.abs([before["v"], before["slip"]]).max(initial=0.0))
        self.still = np.maximum(STILL * largest, least[some])  # speeds up to this are none

    def fixed(self) -> int | None:
        """A touch at which a force moves nothing."""
        found = np.flatnonzero(~self._a[:, : self._k].any(axis=0))
        return int(self.some[found[0]]) if len(found) else None

    def pinched(self, motion: Vector) -> list[int]:
        """The touches that given motions press together, without room to yield."""
        own = np.flatnonzero(~self._joints)
        weights = find_pinched(self._a[:, own], motion[own])
        return [] if weights is None else self.some[own[weights > 0]].tolist()

    def strike(self, first: Vector) -> Vector | None:
        """The impulses of an impact; `first` keeps the greatest speeds of approach."""
        x = np.zeros(2 * self._k)
        own = np.flatnonzero(~self._joints)  # joints do not rub in an impact
        rows = np.concatenate([own, self._k + own])
        if not len(own):
            return x
        blow = strike(
            self._a[np.ix_(rows, rows)], self.u[rows], self._e[own], self._mu[own], self.still[own]
        )
        if blow is None:
            return None
        x[rows] = blow.x
        struck = self.some[own]
        first[struck] = np.maximum(first[struck], blow.fastest)
        self.u = self.u + self._a[:, rows] @ blow.x
        return x

    def felt(self, x: Vector, errors: float) -> Vector:
        """The normal impulses, without those that make good errors of speeds."""
        own = x[: self._k]
        found: Vector = np.where(self._a.diagonal()[: self._k] * own > errors, own, 0.0)
        return found

    def move(self, y: list[float], x: Vector) -> bool:
        for i, change in enumerate((self._states @ x).tolist()):
            y[i] += change
        return bool(np.isfinite(x).all())

    def refine(self, y: list[float], x: Vector, speeds: Vector) -> None:
        """Correct the impulses by the speeds that came of them: of a touch that hardly moves what
        it strikes, what they do is known to few digits."""
        k, acts = self._k, x != 0
        cases = [(bool(n), STICKS if s else IDLE) for n, s in zip(acts[:k], acts[k:], strict=True)]
        spots = [Spot(0.0, way) for _, way in cases]
        off = speeds[self.rows] - self._drift - self.u
        found = solve_case(self._a, off, spots, cases)
        if found is not None:
            self.move(y, found.x)

    def modes(
        self, free: Vector, low: Vector, first: Vector, before: Vector, short: float
    ) -> dict[int, float] | None:
        """Find the cases. Gives for how long each touch that begins to rest still bounces.

        `before` remembers how the touches fell after their last impact.
        """
        v, resting = self.u[: self._k], self.u[: self._k] <= self.still
        time: dict[int, float] = {}
        while True:  # what begins to rest may be what the next one falls onto
            found = self._solved(free, resting)
            if found is None:
                return None
            begun = len(time)
            for j in np.flatnonzero(~resting & (self._e < 1) & (found < 0)):
                falls, i = -float(found[j]), self.some[j]
                lasts = 2 * v[j] / (falls * (1 - self._e[j]))
                least = EXACT * first[i] if abs(falls - before[i]) <= STEADY * falls else low[i]
                lowest = max(self._e[j] * max(least, low[i]), math.sqrt(2 * falls * CLEAR))
                before[i] = falls
                if v[j] < lowest or lasts < short:
                    time[int(j)] = float(lasts)
            if len(time) == begun:
                return time
            resting[list(time)] = True

    def height(self, first: Vector) -> float:
        """The height of the lowest bounce that begins here, as a part of its first one."""
        v, first = self.u[: self._k], first[self.some]
        bounces = (v > self.still) & (first > 0) & (self._e < 1)
        return float(np.min((v[bounces] / first[bounces]) ** 2, initial=1.0))

    def _solved(self, free: Vector, resting: Array) -> Vector | None:
        """The cases of the touches that may be held, all others open; the normal accelerations."""
        k, may = self._k, np.flatnonzero(resting)
        rows = np.concatenate([may, k + may])
        spots = [self._spot(int(j)) for j in may]
        rubs = np.flatnonzero(self._joints[may])
        found = solve_pressed(
            self._a[np.ix_(rows, rows)], free[rows], spots, self.noise, rubs, self._most,
            partial(self.press, self.some[may]),
        )  # fmt: skip
        if found is None:
            return None
        cases = [(False, IDLE)] * k
        for j, case in zip(may, found.cases, strict=True):
            cases[j] = (bool(self._joints[j]) or case[0], case[1])
        self.cases = tuple(cases)
        u: Vector = self._a[:, rows] @ found.x + free
        return u[:k]

    def _spot(self, j: int) -> Spot:
        slip, way = float(self.u[self._k + j]), self._way[j]
        turns = abs(way) == 1 and way * slip <= 0
        if self._mu[j] == 0:
            return Spot(0.0, IDLE)
        slow = DRIFT if turns or way == STICKS else SLOW
        if abs(slip) <= max(slow * self._fastest, CREEP):
            return Spot(float(self._mu[j]), None, loose=bool(self._loose[j]))
        return Spot(float(self._mu[j]), 1 if slip > 0 else -1)

    def stop(self, y: list[float]) -> None:
        """Take off what errors and last bounces leave of the speeds that are held at zero."""
        spots = [
            Spot(float(m), w if w in (STICKS, IDLE) else IDLE)
            for m, (_, w) in zip(self._mu, self.cases, strict=True)
        ]
        cases = [(closed, s.way or 0) for s, (closed, _) in zip(spots, self.cases, strict=True)]
        found: Solution | None = solve_case(self._a, self.u, spots, cases)
        if found is not None:
            self.move(y, found.x)
            self.u = found.u
        v = self.u[: self._k]  # what rests and is not held must not go on approaching
        rests = np.flatnonzero((v <= self.still) & ~self._joints)
        if not (v[rests] < -STILL * self.still[rests]).any():
            return
        rows = np.concatenate([rests, self._k + rests])
        found = solve_contacts(
            self._a[np.ix_(rows, rows)], self.u[rows], [Spot(0.0, IDLE)] * len(rests)
        )
        if found is not None:
            x = np.zeros(len(self.u))
            x[rows] = found.x
            self.move(y, x)
