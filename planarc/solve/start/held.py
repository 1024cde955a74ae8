"""Which start values are held: first come first served, as long as they are independent.

In:   System, guess
Out:  Choice    the candidates held, and other variables held besides

Held are those with `fixed = true`, then those that were written, in the order of StateSelect
and of declaration. Each must move some free motion of the mechanism that those before it do
not: the free motions are the null space of the conditions where the loops are closed.

Example: of a four-bar with three written angles the first is held; it has one free motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from operator import mul
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.ir.begin import CLOSED, INDEPENDENT
from planarc.ir.once import once
from planarc.ir.program import FixedSlot, Program
from planarc.solve.start import newton
from planarc.solve.start.branch import agreed_place
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System, gradients

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Free motions up to which Python is faster than NumPy.
FEW = 6


class Choice(Data):
    """Which candidates are held, and which other variables besides the fixed ones.
    `redundant`: fixed candidates that are determined without being held, each with those
    among the held that determine it."""

    held: tuple[bool, ...]
    redundant: tuple[tuple[int, tuple[int, ...]], ...] = ()
    others: tuple[FixedSlot, ...] = ()


def choose_held(system: System, u: Vector) -> Choice:
    """Start values held, first come first served, as long as they are independent.

    The guess may be a singular position by accident. So where not all comes out plainly
    the same is done with the loops closed, at the guess and at two places beside it, and
    the outcome that holds the first ones counts. They are closed since the freedoms of a
    mechanism are those of its assembled positions alone.
    """
    outcome = _held_at(system, u)
    if outcome is None or not outcome.plain:
        outcome = choose_closed(system, u) or outcome
    if outcome is None:
        return choose_fixed(system.program)
    return outcome.choice


def choose_fixed(program: Program) -> Choice:
    """What is fixed, and nothing else."""
    return Choice(_fixed(program))


def choose_closed(system: System, u: Vector) -> _Outcome | None:
    """The best outcome in positions with closed loops."""
    closed = [p for p in map(partial(_closed, system), places(u)) if p is not None]
    if not closed and (agreed := agreed_place(system, u)) is not None:
        closed.append(agreed)
    found = [o for p in closed if (o := _held_at(system, p)) is not None]
    return max(found, key=lambda o: o.taken, default=None)


def is_confirmed(system: System, values: Vector, choice: Choice) -> bool:
    """Whether the same start values are independent where the loops are closed."""
    seen = _held_at(system, values)
    return seen is not None and seen.choice == choice


class _Outcome(Data):
    """Which of those that ask to be held were taken, in their order; `plain` where no other
    outcome could hold earlier ones."""

    taken: list[bool]
    plain: bool
    choice: Choice


def _held_at(system: System, place: Vector) -> _Outcome | None:
    candidates, order, others = system.program.candidates, system.asking, system.asking_besides
    motions = free_motions(system, place, tuple(f.slot for f in others))
    if motions is None:
        return None
    beside: list[Vector] = []  # how each other variable changes with each free motion

    def row(item: int | FixedSlot) -> Vector:
        if isinstance(item, int):
            found: Vector = motions[item]
            return found
        if not beside:  # often nobody asks
            beside.extend(gradients(system, place, others) @ motions)
        return beside[others.index(item)]

    count: int = motions.shape[1]
    span, held, extra = Directions(count, row), [*_fixed(system.program)], list[FixedSlot]()
    taken, dependent = list[bool](), list[int]()
    for item in order:
        independent = len(span.held) < count and span.add(item)
        taken.append(independent)
        if isinstance(item, FixedSlot):
            extra += [item] if independent else []
        elif independent:
            held[item] = True
        elif candidates[item].fixed:
            dependent.append(item)
    redundant = [(i, tuple(p for p in span.partners(i) if isinstance(p, int))) for i in dependent]
    plain = len(span.held) == count and taken == sorted(taken, reverse=True)
    return _Outcome(taken, plain, Choice(tuple(held), tuple(redundant), tuple(extra)))


@once
def _fixed(program: Program) -> tuple[bool, ...]:
    return tuple(c.fixed for c in program.candidates)


def _closed(system: System, u: Vector) -> Vector | None:
    """An assembled position near a guess, nothing held."""
    for rows, columns in system.stages:
        own = [row for row in rows if row < system.initial_rows.start]
        root = solve_stage(system, u, own, columns)
        if not root.converged:
            return None
        u = root.point
    return u


def places(u: Vector) -> list[Vector]:
    """A guess and two points beside it, the same ones every time."""
    import numpy as np

    n = np.arange(len(u))
    return [u, u + 0.1 * np.cos(1.0 + 2.0 * n), u + 0.2 * np.sin(2.0 + 1.7 * n)]


class Directions:
    """Those already held among so many free motions at one place; `row` tells how
    something changes with each of these."""

    def __init__(self, count: int, row: Callable[[int | FixedSlot], Vector]) -> None:
        self.row, self.held = row, list[int | FixedSlot]()
        self._units: list[list[float]] = []  # of a few
        self._basis: Vector | None = None  # of more
        if count > FEW:
            import numpy as np

            self._basis = np.empty((count, count))
        self._count = count

    def add(self, item: int | FixedSlot) -> bool:
        """Hold what is independent of those held before."""
        count = len(self.held)
        if count == self._count:
            return False
        if self._basis is None:
            return self._add(item)
        row, basis = self.row(item), self._basis[:count]
        rest = row - (basis @ row) @ basis
        length = math.sqrt(rest @ rest)
        if length <= INDEPENDENT:
            return False
        self._basis[count] = rest / length
        self.held.append(item)
        return True

    def _add(self, item: int | FixedSlot) -> bool:
        row: list[float] = self.row(item).tolist()
        rest = row
        for unit in self._units:
            along = sum(map(mul, row, unit))
            rest = [x - along * u for x, u in zip(rest, unit, strict=True)]
        length = math.hypot(*rest)
        if length <= INDEPENDENT:
            return False
        self._units.append([x / length for x in rest])
        self.held.append(item)
        return True

    def partners(self, item: int | FixedSlot) -> tuple[int | FixedSlot, ...]:
        """Those held that a dependent candidate follows from."""
        import numpy as np

        row = self.row(item)
        if not self.held or np.linalg.norm(row) < INDEPENDENT:
            return ()
        held = np.array([self.row(h) for h in self.held])
        parts = np.linalg.lstsq(held.T, row, rcond=1e-6)[0]
        return tuple(h for h, x in zip(self.held, parts, strict=True) if abs(x) > 1e-6)


def free_motions(system: System, point: Vector, slots: tuple[int, ...] = ()) -> Vector | None:
    """An orthonormal basis, in columns, of the changes that keep all rows (to first order). Where
    it takes their derivatives, those of other variables are found on the way."""
    found = system.motions(point, CLOSED)
    if found is None and (slopes := system.slopes(point, None, slots)) is not None:
        found = newton.kernel_of(slopes[: system.rows], CLOSED)
    return found


class Weakness(Data):
    """The free motion that the held values see least: its share, and the motion itself where
    they change by what is wanted of them."""

    share: float
    motion: Vector


def weakness(
    system: System, place: Vector, level: tuple[Sequence[int], Sequence[int]], held: Sequence[int]
) -> Weakness | None:
    """How little the held candidates of a level, which move by their values in `place`, see of
    a free motion; None where they do not depend on one."""
    import numpy as np

    rows, columns = level
    jacobian = system.slopes(place)
    if jacobian is None or not held:
        return None
    motions = newton.kernel_of(jacobian[np.ix_(rows, columns)], CLOSED)
    own = [list(columns).index(c) for c in held]
    if not motions.shape[1]:
        return None
    left, sizes, right = np.linalg.svd(motions[own], full_matrices=False)
    share = max(float(sizes[-1]), 1e-300)
    return Weakness(share, motions @ right[-1] * float(left[:, -1] @ place[list(held)]) / share)
