"""Consistent initial values: positions and velocities that satisfy every constraint.

In:   Program, Kernel (parameters set), the time
Out:  Start    a value for every candidate, and how each start value was used

The unknowns are all candidates for states. Held exactly are, as far as they are
independent of each other under the constraints: those with `fixed = true`; then the
start values that were written, in the order of StateSelect and of declaration, be they
of candidates or of variables that follow from these. All others are guesses, and the
solution nearest to them is taken (`start_branch`). So the result depends on what the
user wrote alone, never on which states the run chooses.

Example: a four-bar of which three angles have written start values. It has one
degree of freedom, so the first angle is held, and the other two only say on which
side the loop closes.

Positions are solved first, then velocities, then everything once more together with
initial equations, which may tie any of them to accelerations. Where Newton fails
from the guesses, the loop is first closed with nothing held, and the held values
are then moved from there to where they were wanted.

Promises: does not depend on tolerances.
Raises:   PlanarcError R411 (fixed values contradict), R412 (does not assemble),
          R413 (cannot be evaluated), R415 (redundant joints).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.ir.dae import MISFIT
from planarc.ir.kernel import Kernel
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.ir.result import Held
from planarc.solve.start import failure as start_failure
from planarc.solve.start import newton, sharing
from planarc.solve.start.branch import agreed_place, nearest_root
from planarc.solve.start.redundancy import refuse_redundancy
from planarc.solve.start.system import Part, System

if TYPE_CHECKING:
    import numpy as np

    from planarc.solve.start.newton import Vector

#: A candidate that moves less than this part of a free motion is not held against it.
INDEPENDENT = 1e-3


class Start(Data):
    values: tuple[float, ...]  # of the candidates
    held: tuple[Held, ...]  # of the candidates, then of other variables with a written start


def solve_start(
    program: Program,
    kernel: Kernel,
    t: float,
    given: frozenset[int] = frozenset(),
    judge: Callable[[System, Vector], None] = refuse_redundancy,
) -> Start:
    """Leaves the workspace at the start values found. `given` are the slots of start values
    that the user sets for this run: they count as written. `judge` is shown the assembled
    mechanism, before it is known whether it can move."""
    import numpy as np

    guess = [float(kernel.w[c.start]) for c in program.candidates]
    system = System(program, kernel, t, given)
    if not system.rows and not any(system.written(f) for f in program.fixed):
        held = [True] * len(guess)
        return _finish(system, np.array(guess), held, judge)
    u0 = np.array(guess)
    choice = choose_held(system, u0)
    values = _assemble(system.holding(choice.others), u0, choice)
    if values is None or not _confirmed(system, values, choice):
        again = _choose_closed(system, u0)
        if again is not None and again.choice != choice:
            choice = again.choice
            values = _assemble(system.holding(choice.others), u0, choice)
    system = system.holding(choice.others)
    if values is None:
        raise start_failure.explain(system, u0, choice)
    if sharing.missed(system, values):
        return solve_start(sharing.strict(program), kernel, t, given, judge)
    return _finish(system, values, choice.held, judge)


def _finish(
    system: System,
    values: Vector,
    held: Sequence[bool],
    judge: Callable[[System, Vector], None],
) -> Start:
    program = system.program
    flag = system.evaluate_flag(values)
    judge(system, values)
    if flag != 0 or not system.finite(values):
        raise start_failure.not_evaluated(system, flag)
    w = system.kernel.w
    return Start(
        tuple(float(v) for v in values),
        (
            *(
                Held(c.display, float(w[c.start]), float(v), bool(h))
                for c, v, h in zip(program.candidates, values, held, strict=True)
            ),
            *(
                Held(f.display, float(w[f.start]), float(w[f.slot]), f in system.conditions)
                for f in program.fixed
                if system.written(f) and not f.display.startswith(MISFIT)
            ),
        ),
    )


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
        outcome = _choose_closed(system, u) or outcome
    if outcome is None:
        return Choice(tuple(c.fixed for c in system.program.candidates))
    return outcome.choice


def _choose_closed(system: System, u: Vector) -> _Outcome | None:
    """The best outcome in positions with closed loops."""
    closed = [p for p in map(partial(_closed, system), places(u)) if p is not None]
    if not closed and (agreed := agreed_place(system, u)) is not None:
        closed.append(agreed)
    found = [o for p in closed if (o := _held_at(system, p)) is not None]
    return max(found, key=lambda o: o.taken, default=None)


def _confirmed(system: System, values: Vector, choice: Choice) -> bool:
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
    candidates, order = system.program.candidates, system.asking
    others = [f for f in order if isinstance(f, FixedSlot)]
    slopes = gradients(system, place, others)
    motions = free_motions(system, place)
    if motions is None:
        return None
    span = _Span(_all_rows(motions, slopes))
    row = {f: len(candidates) + k for k, f in enumerate(others)}
    taken = [span.add(f if isinstance(f, int) else row[f]) for f in order]
    held = [c.fixed for c in candidates]
    extra = []
    for item, independent in zip(order, taken, strict=True):
        if isinstance(item, FixedSlot):
            extra += [item] if independent else []
        else:
            held[item] |= independent
    redundant = tuple(
        (i, tuple(p for p in span.partners(i) if p < len(candidates)))
        for i, independent in zip(order, taken, strict=True)
        if not isinstance(i, FixedSlot) and candidates[i].fixed and not independent
    )
    plain = sum(taken) == motions.shape[1] and taken == sorted(taken, reverse=True)
    return _Outcome(taken, plain, Choice(tuple(held), redundant, tuple(extra)))


def _closed(system: System, u: Vector) -> Vector | None:
    """An assembled position near a guess, nothing held."""
    for rows, columns in system.stages():
        own = [row for row in rows if row < system.initial_rows.start]
        root = solve_stage(system, u, own, columns)
        if not root.converged:
            return None
        u = root.point
    return u


def _all_rows(motions: Vector, gradients: Vector) -> Vector:
    """How each candidate, then each other variable, changes with each free motion."""
    import numpy as np

    return np.vstack([motions, gradients @ motions])


def gradients(system: System, point: Vector, others: Sequence[FixedSlot]) -> Vector:
    """The derivatives of other variables by the candidates; zeros where they have none."""
    import numpy as np

    found = system.slopes(point, None, tuple(f.slot for f in others)) if others else None
    return np.zeros((len(others), len(point))) if found is None else found[system.rows :]


def places(u: Vector) -> list[Vector]:
    """A guess and two points beside it, the same ones every time."""
    import numpy as np

    n = np.arange(len(u))
    return [u, u + 0.1 * np.cos(1.0 + 2.0 * n), u + 0.2 * np.sin(2.0 + 1.7 * n)]


class _Span:
    """The directions already held, among the free motions at one place."""

    def __init__(self, motions: Vector) -> None:
        import numpy as np

        self._motions = motions
        self._basis = np.empty((motions.shape[1], motions.shape[1]))
        self._held: list[int] = []

    def add(self, i: int) -> bool:
        """Holds a candidate if it is independent of those held before."""
        row, count = self._motions[i], len(self._held)
        if count == len(row):
            return False
        basis = self._basis[:count]
        rest = row - (basis @ row) @ basis
        length = math.sqrt(rest @ rest)
        if length <= INDEPENDENT:
            return False
        self._basis[count] = rest / length
        self._held.append(i)
        return True

    def partners(self, i: int) -> tuple[int, ...]:
        """The held candidates that a dependent one follows from."""
        import numpy as np

        if not self._held or np.linalg.norm(self._motions[i]) < INDEPENDENT:
            return ()
        parts = np.linalg.lstsq(self._motions[self._held].T, self._motions[i], rcond=1e-6)[0]
        return tuple(h for h, x in zip(self._held, parts, strict=True) if abs(x) > 1e-6)


def free_motions(system: System, point: Vector) -> Vector | None:
    """An orthonormal basis, in columns, of the changes that keep all rows (to first order)."""
    jacobian = system.slopes(point)
    return None if jacobian is None else newton.kernel_of(jacobian, 1e-5)


def _assemble(system: System, u0: Vector, choice: Choice) -> Vector | None:
    """All candidates' values, or None."""
    import numpy as np

    held = np.array(choice.held)
    values = _solve_stages(system, u0, held)
    if values is not None:
        return values
    found = [
        v
        for p in places(u0)[1:]
        if (v := _solve_stages(system, np.where(held, u0, p), held)) is not None
    ]
    if found:
        return min(found, key=lambda v: float(np.linalg.norm(v - u0)))
    free = _solve_stages(system, u0, np.zeros(len(u0), dtype=bool))
    return None if free is None else _move(system, free, u0, held)


def _solve_stages(
    system: System, u0: Vector, held: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> Vector | None:
    u = u0.copy()
    for rows, columns in system.stages():
        root = None
        if system.initial_rows.stop - 1 in rows:
            here = system(u)
            if here is not None and not here[rows].any():
                continue
            root = solve_stage(system, u, rows, _movable(system, u, held))
        if root is None or not root.converged:
            root = nearest_root(system, u, rows, columns, held)
        if not root.converged:
            return None
        u = root.point
    return u


def _movable(
    system: System, u: Vector, held: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> list[int]:
    """The candidates that closed loops and held values leave free: initial equations are for
    these, and need not shake what is settled."""
    import numpy as np

    free = [i for i, h in enumerate(held) if not h]
    jacobian = system.slopes(u)
    if jacobian is None:
        return free
    kept = np.delete(jacobian, system.initial_rows, axis=0)[:, free]
    moves = np.abs(newton.kernel_of(kept, 1e-8)).max(axis=1, initial=0.0)
    return [i for i, move in zip(free, moves, strict=True) if move > 1e-6]


def solve_stage(
    system: System, u: Vector, rows: Sequence[int], columns: Sequence[int]
) -> newton.Root:
    """Some rows as a function of some candidates; the root's point is of all candidates."""
    part = Part(system, u, rows, columns)
    root = newton.solve(part, u[list(columns)])
    return newton.Root(part.point(root.point), root.residuals, root.converged)


def _move(
    system: System,
    u: Vector,
    wanted: Vector,
    held: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
) -> Vector | None:
    """Continuation: held values go from an assembled position to where they are wanted."""
    begin, way, step = u[held].copy(), 0.0, 0.25
    while way < 1.0:
        part = min(1.0, way + step)
        trial = u.copy()
        trial[held] = (1 - part) * begin + part * wanted[held]
        following = _solve_stages(system, trial, held)
        if following is None:
            step /= 2
            if step < 1e-3:
                return None
        else:
            u, way, step = following, part, min(0.25, 2 * step)
    return u


def candidates_of(program: Program, block: int) -> Sequence[CandidateSlot]:
    b = program.blocks[block]
    return program.candidates[b.first : b.first + len(b.tears)]
