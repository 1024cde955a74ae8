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

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.ir.program import CandidateSlot, FixedSlot, Kernel, Program
from planarc.ir.result import Held
from planarc.solve import newton, start_failure
from planarc.solve.start_branch import nearest_root
from planarc.solve.start_redundancy import refuse_redundancy

if TYPE_CHECKING:
    import numpy as np

    from planarc.solve.newton import Vector

#: A candidate that moves less than this part of a free motion is not held against it.
INDEPENDENT = 1e-3


class Start(Data):
    values: tuple[float, ...]  # of the candidates
    held: tuple[Held, ...]  # of the candidates, then of other variables with a written start


def solve_start(
    program: Program, kernel: Kernel, t: float, given: frozenset[int] = frozenset()
) -> Start:
    """Leaves the workspace at the start values found. `given` are the slots of start values
    that the user sets for this run: they count as written."""
    import numpy as np

    guess = [float(kernel.w[c.start]) for c in program.candidates]
    system = System(program, kernel, t, given)
    if not system.rows and not any(system.written(f) for f in program.fixed):
        held = [True] * len(guess)
        return _finish(system, np.array(guess), held)
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
    return _finish(system, values, choice.held)


def _finish(system: System, values: Vector, held: Sequence[bool]) -> Start:
    program = system.program
    flag = system.evaluate_flag(values)
    refuse_redundancy(system, values)
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
                if system.written(f)
            ),
        ),
    )


class System:
    """The conditions at the start as one function of all candidates.

    Its rows are the residuals of the blocks below the top, the initial equations, and
    the variables held that are no candidates: `conditions`, the fixed ones and `others`.
    """

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        t: float,
        given: frozenset[int] = frozenset(),
        others: Sequence[FixedSlot] = (),
    ) -> None:
        self.program, self.kernel, self.t, self.given = program, kernel, t, given
        self.conditions = (*(f for f in program.fixed if f.fixed), *others)
        self.blocks = [(i, b) for i, b in enumerate(program.blocks) if b.height > 0]
        self.block_rows: dict[int, range] = {}
        count = 0
        for i, block in self.blocks:
            self.block_rows[i] = range(count, count + len(block.residuals))
            count += len(block.residuals)
        self.initial_rows = range(count, count + len(program.initial_residuals))
        count = self.initial_rows.stop
        self.fixed_rows = range(count, count + len(self.conditions))
        self.rows = self.fixed_rows.stop
        self._r = [0.0] * max(1, self.initial_rows.stop)

    def holding(self, others: Sequence[FixedSlot]) -> System:
        """The same with some more variables held."""
        return System(self.program, self.kernel, self.t, self.given, others)

    def written(self, start: CandidateSlot | FixedSlot) -> bool:
        """Whether the user has said where it starts, in the model or for this run."""
        said = start.written if isinstance(start, FixedSlot) else start.start_written
        return said or start.fixed or start.start in self.given

    def evaluate_flag(self, u: Vector) -> int:
        return self.kernel.residuals(self.t, u.tolist(), self._r)

    def finite(self, u: Vector) -> bool:
        import math

        return all(map(math.isfinite, u)) and all(
            math.isfinite(self.kernel.w[c.derivative]) for c in self.program.candidates
        )

    def __call__(self, u: Vector) -> Vector | None:
        """All rows; None where one is not finite. The blocks' own rows are known even where
        the accelerations cannot be solved for, as in a singular position."""
        import numpy as np

        self._r[:] = [float("nan")] * len(self._r)
        flag = self.evaluate_flag(u)
        if flag != 0 and (self.initial_rows or self.fixed_rows):
            return None
        w = self.kernel.w
        values = np.empty(self.rows)
        values[: self.initial_rows.stop] = self._r[: self.initial_rows.stop]
        for row, f in zip(self.fixed_rows, self.conditions, strict=True):
            values[row] = w[f.slot] - w[f.start]
        return values if np.all(np.isfinite(values)) else None

    def stages(self) -> Iterator[tuple[list[int], list[int]]]:
        """Rows and candidates of each level, positions first, then of everything."""
        heights = sorted({b.height for _, b in self.blocks}, reverse=True)
        for height in heights:
            rows: list[int] = []
            columns: list[int] = []
            for i, block in self.blocks:
                if block.height == height:
                    rows.extend(self.block_rows[i])
                    columns.extend(range(block.first, block.first + len(block.tears)))
            conditions = zip(self.fixed_rows, self.conditions, strict=True)
            rows.extend(row for row, f in conditions if f.height == height)
            yield rows, columns
        if self.initial_rows or self.fixed_rows or len(heights) > 2:
            yield list(range(self.rows)), list(range(len(self.program.candidates)))


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
    candidates, order = system.program.candidates, _by_rank(system)
    motions = free_motions(system, place)
    if motions is None:
        return None
    others = [f for f in order if isinstance(f, FixedSlot)]
    span = _Span(_all_rows(motions, gradients(system, place, others)))
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

    if not others:
        return np.zeros((0, len(point)))

    def values(u: Vector) -> Vector | None:
        if system.evaluate_flag(u) != 0:
            return None
        found = np.array([system.kernel.w[f.slot] for f in others])
        return found if np.all(np.isfinite(found)) else None

    here = values(point)
    found = None if here is None else newton.derivative(values, point, here)
    return np.zeros((len(others), len(point))) if found is None else found


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
        self._basis = np.zeros((0, motions.shape[1]))
        self._held: list[int] = []

    def add(self, i: int) -> bool:
        """Holds a candidate if it is independent of those held before."""
        import numpy as np

        row = self._motions[i]
        rest = row - self._basis.T @ (self._basis @ row)
        length = float(np.linalg.norm(rest))
        if length <= INDEPENDENT:
            return False
        self._basis = np.vstack([self._basis, rest / length])
        self._held.append(i)
        return True

    def partners(self, i: int) -> tuple[int, ...]:
        """The held candidates that a dependent one follows from."""
        import numpy as np

        if not self._held or np.linalg.norm(self._motions[i]) < INDEPENDENT:
            return ()
        parts = np.linalg.lstsq(self._motions[self._held].T, self._motions[i], rcond=1e-6)[0]
        return tuple(h for h, x in zip(self._held, parts, strict=True) if abs(x) > 1e-6)


def _by_rank(system: System) -> list[int | FixedSlot]:
    """What asks to be held: fixed candidates (by number), then all that was written, by
    StateSelect and declaration."""
    program = system.program
    declared = {c.name: i for i, c in reversed(list(enumerate(program.columns)))}
    last = len(declared)
    asking: list[tuple[tuple[bool, int, int, int], int | FixedSlot]] = []
    for i, c in enumerate(program.candidates):
        if system.written(c):
            asking.append(((not c.fixed, -c.select, declared.get(c.display, last), i), i))
    for i, f in enumerate(program.fixed, len(program.candidates)):
        if system.written(f) and not f.fixed:
            asking.append(((True, -f.select, declared.get(f.display, last), i), f))
    return [item for _, item in sorted(asking, key=lambda pair: pair[0])]


def free_motions(system: System, point: Vector) -> Vector | None:
    """An orthonormal basis, in columns, of the changes that keep all rows (to first order)."""
    import numpy as np

    r = system(point)
    jacobian = None if r is None else newton.derivative(system, point, r)
    if jacobian is None:
        return None
    _, sizes, directions = np.linalg.svd(newton.level_rows(jacobian)[0])
    rank = int(np.sum(sizes > 1e-5 * max(1e-300, sizes[0]))) if len(sizes) else 0
    return directions[rank:].T


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
    r = system(u)
    jacobian = None if r is None else newton.derivative(system, u, r)
    if jacobian is None:
        return free
    kept = np.delete(jacobian, system.initial_rows, axis=0)[:, free]
    _, sizes, directions = np.linalg.svd(newton.level_rows(kept)[0])
    rank = int(np.sum(sizes > 1e-8 * np.max(sizes, initial=1.0)))
    moves = np.abs(directions[rank:]).max(axis=0, initial=0.0)
    return [i for i, move in zip(free, moves, strict=True) if move > 1e-6]


def solve_stage(
    system: System, u: Vector, rows: Sequence[int], columns: Sequence[int]
) -> newton.Root:
    """Some rows as a function of some candidates; the root's point is of all candidates."""
    full = u.copy()

    def part(z: Vector) -> Vector | None:
        full[columns] = z
        r = system(full)
        return None if r is None else r[rows]

    root = newton.solve(part, u[columns])
    point = u.copy()
    point[columns] = root.point
    return newton.Root(point, root.residuals, root.converged)


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
