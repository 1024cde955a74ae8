"""The contacts of one step, and what they do to velocities.

In:   Contacts    their gaps in the middle of the step, and how they move with the ports
Out:  states      those after the impulses
      `speeds`    of each normal and slip, at the end of the step
      `impulse`   at the ports

Where motions that are given leave no room between contacts, no impulses do, however large: such are
told by their keys (`Struck.pinched`).

Example: a ball of 2 kg that comes with 3 m/s to a wall, e = 0.5: an impulse of 9 N.s, 1.5 m/s.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planarc.core.data import Data
from planarc.solve.contact.impacts import DEEP
from planarc.solve.contact.pinched import find_pinched
from planarc.solve.solvers.stepping import Unsolved
from planarc.solve.stepping.impulses import solve_impulses
from planarc.solve.stepping.ports import Ports

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from planarc.core.arrays import Array, Vector

#: Errors of velocities that the impulses may leave, as parts of what free motion adds in a step.
LEFT = 1e-3
#: Errors of sums, as parts of what is summed.
ROUNDING = 1e-9
#: Restitution is lowered to the first of these parts with which no energy is gained: Newton's law
#: gives some where friction turns the slip round (T. R. Kane, 1984).
PARTS = (1.0, 0.75, 0.5, 0.25, 0.0)
#: Bounces of a speed below so many times what free motion gives in a step are none.
SLOW = 2.0
#: Of contacts that may have no room so many are looked at, the deepest ones.
MOST_PINCHED = 200


class Contacts(Data):
    """Contacts by their keys, which rise, and by which they are known in the next step. Along its
    normal and then along its slip, each moves with a row of `jacobian` times the velocities of
    ports."""

    key: Array
    jacobian: csr_array
    gap: Vector
    e: Vector
    mu: Vector


class Struck:
    """The contacts of one step, with their matrices, and what they do to velocities."""

    def __init__(self, contacts: Contacts, ports: Ports, t: float, y: Vector) -> None:
        self._contacts = contacts
        active = np.zeros(ports.count, dtype=bool)
        active[contacts.jacobian.indices] = True
        found = ports.respond(t, y, active & (ports.groups >= 0))
        if found is None:
            raise Unsolved(1)
        self._states = found.states
        self._to_ports = contacts.jacobian.T.tocsr()
        self._a = contacts.jacobian @ (found.velocity @ self._to_ports)
        self._a.sort_indices()  # the order of sums, which sweeps of exported models have too
        self.impulse = np.zeros(ports.count)
        self.known: tuple[Array, Vector] = (contacts.key, np.zeros((0, 2)))
        machine = ports.kernel.capabilities.machine
        self._sweep = None if machine is None else machine.sweep

    def solve(
        self, h: float, before: Vector, after: Vector, free: Vector, known: tuple[Array, Vector]
    ) -> Vector:
        """The states after the impulses; `known` are those of the step before."""
        c = self._contacts
        u, moved = c.jacobian @ before, c.jacobian @ after
        gained = float(np.abs(moved - u).max())
        v = u[::2]
        least = np.minimum(-2 / h * c.gap, 0.0)
        bounces = (v < -SLOW * gained) & (c.gap + h / 2 * moved[::2] < 0)
        self._error = LEFT * gained + 1e-12 * float(np.abs(moved).max())
        x = np.zeros(len(moved))
        keys, values = known
        if len(keys):
            at = np.minimum(np.searchsorted(keys, c.key), len(keys) - 1)
            x = (values[at] * (keys[at] == c.key)[:, None]).ravel()
        diagonal = self._a.diagonal()[::2]
        resting = float((1 / diagonal[diagonal > 0]).sum())
        for part in PARTS:
            rest = moved.copy()
            rest[::2] -= np.where(bounces, np.maximum(least, -part * c.e * v), least)
            x = solve_impulses(self._a, rest, c.mu, x, self._error, self._sweep)
            self.speeds = self._a @ x + moved
            lost = float(np.abs(x * (u + self.speeds)).sum()) * ROUNDING + gained**2 * resting
            if x @ (u + self.speeds) <= lost:
                break  # the work of the impulses is none, but for what a step gains and loses
        self.known = c.key, x.reshape(-1, 2)
        self.impulse = self._to_ports @ x
        found: Vector = free + self._states @ self.impulse
        return found

    def depths(self, h: float, before: Vector, after: Vector) -> Vector:
        """How deep contacts with these speeds, of each normal and slip, are at the end of the step,
        beyond what they may move in it."""
        gap = self._contacts.gap + h / 2 * after[::2]
        speeds = np.abs([self._contacts.jacobian @ before, after]).max(axis=0)
        found: Vector = -gap - h * speeds.reshape(-1, 2).max(axis=1) - DEEP
        return found

    def pinched(self, h: float, before: Vector, after: Vector) -> list[int]:
        """The keys of the contacts that find no room, if there are some, however they are pressed:
        that changes neither how fast nor how far they close together."""
        moved = self._contacts.jacobian @ after
        depths = self.depths(h, before, moved)
        some = np.sort(np.argsort(-depths, kind="stable")[:MOST_PINCHED])
        weights = find_pinched(self._a[:, 2 * some].toarray(), moved[2 * some])
        if weights is None or not weights @ depths[some] > 0:
            return []
        keys: list[int] = self._contacts.key[some[weights > 0]].tolist()
        return keys

    def cleared(self, h: float, new: Vector) -> Vector:
        """The velocities with which no gap is negative at the end of the step: what came too far
        in its first half goes back by as much, as if it moved, but gets no speed of it."""
        c = self._contacts
        rest = self.speeds.copy()
        rest[::2] += 2 / h * c.gap
        if rest[::2].min() >= -2 * self._error:
            return new
        x = np.zeros(len(rest))
        x = solve_impulses(self._a, rest, np.zeros(len(c.gap)), x, self._error, self._sweep)
        found: Vector = new + self._states @ (self._to_ports @ x)
        return found
