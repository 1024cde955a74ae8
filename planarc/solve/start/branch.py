"""On which side a loop closes: the assembly nearest to the start values that were given.

In:   System, guess, rows and candidates of one level, the candidates held
Out:  Root    of all solutions found the one nearest to what was written

Newton's method from the guesses finds some assembly, and where all start values are near
an assembly it is that one. Where a written value has been left far behind, or a loop had
nothing but defaults to start from, other guesses are tried, always the same ones: the
written values of dependent coordinates pull, and the others go round. Of the assemblies
found counts the nearest: by written values first, then by those of the joints
(StateSelect.prefer), then by all. Equally near ones are told apart by the sign of the
first coordinate in which they differ.

Example: a four-bar with a held crank and a rough value of the rocker's angle, which
follows from the others; it closes on the rocker's side, whichever angles are guessed.

Promises:  an angle is not a whole turn away from its start value where it need not be.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from planarc.core.data import Data
from planarc.ir.flat import StateSelect
from planarc.solve.start import newton
from planarc.solve.start.stage import Part, solve_stage
from planarc.solve.start.system import System, declared

if TYPE_CHECKING:
    import numpy as np

    from planarc.solve.start.newton import Vector

    Flags: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

#: Distance (radians, metres) up to which an assembly is the one that was meant.
NEAR = 0.5
#: Newton's iterations from written values that agree: there is no way to go for them.
AGREEING = 12
#: Other guesses for loops of at most so many coordinates, and for larger ones.
SMALL_LOOP, MANY, FEW = 12, 16, 4
#: Weights of start values: written, of a joint, of others.
WRITTEN, JOINT, OTHER = 1.0, 1e-3, 1e-6
#: The pull of a guess, against the conditions.
PULL = 0.1
TURN = 6.283185307179586


class Guide(Data):
    """A coordinate that should stay near its start value; `column` is -1 of no candidate."""

    slot: int
    start: float
    weight: float
    column: int
    place: int  # in the order of declaration


def nearest_root(
    system: System, u: Vector, rows: Sequence[int], columns: Sequence[int], held: Flags
) -> newton.Root:
    """The root's point is of all candidates; `converged` is false where none was found."""
    free = [c for c in columns if not held[c]]
    guides = _guides(system, free)
    if not free or not rows or not guides:
        return solve_stage(system, u, rows, free)
    first = _agreeing(system, u, rows, free, guides) or solve_stage(system, u, rows, free)
    if first.converged:
        first = _without_turns(system, first, rows, free, guides)
        if _as_meant(system, first.point, columns, guides):
            return first
    found = [first] if first.converged else []
    for guess in _guesses(system, u, rows, free, guides):
        root = solve_stage(system, guess, rows, free)
        if root.converged:
            found.append(_without_turns(system, root, rows, free, guides))
    return _nearest(system, found, guides) if found else first


def agreed_place(system: System, u: Vector) -> Vector | None:
    """An assembled position with all values that were written, where they agree."""
    for rows, columns in system.stages():
        own = [row for row in rows if row < system.initial_rows.start]
        root = _agreeing(system, u, own, columns, _guides(system, columns))
        if root is None:
            return None
        u = root.point
    return u


def _agreeing(
    system: System,
    u: Vector,
    rows: Sequence[int],
    free: Sequence[int],
    guides: Sequence[Guide],
) -> newton.Root | None:
    """The root that moves no written value, where all of these agree with each other."""

    strong = [g for g in guides if g.weight == WRITTEN]
    kept = {g.column for g in strong}
    movable = [c for c in free if c not in kept]
    if not movable or not strong:
        return None
    dependent = {g.slot: g.start for g in strong if g.column < 0}
    part = Part(system, u, rows, movable, dependent)
    root = newton.solve_near(part, u[movable], AGREEING)
    if not root.converged:
        return None
    return newton.Root(part.point(root.point), root.residuals[: len(rows)], True)


def _guides(system: System, free: Sequence[int]) -> list[Guide]:
    program, w = system.program, system.kernel.w
    places = declared(program)
    last = len(places)
    heights = {program.blocks[program.candidates[c].block].height for c in free}
    found = []
    for i in free:
        c = program.candidates[i]
        weight = _weight(system.written(c), c.select)
        found.append(Guide(c.slot, float(w[c.start]), weight, i, places.get(c.display, last)))
    for f in program.fixed:
        if f.height in heights and f not in system.conditions:
            weight = _weight(system.written(f), f.select)
            found.append(Guide(f.slot, float(w[f.start]), weight, -1, places.get(f.display, last)))
    return sorted(found, key=lambda g: g.place)


def _weight(written: bool, select: StateSelect) -> float:
    return WRITTEN if written else JOINT if select >= StateSelect.PREFER else OTHER


def _values(system: System, point: Vector, guides: Sequence[Guide]) -> Vector:
    import numpy as np

    system(point)
    return np.array([system.kernel.w[g.slot] for g in guides])


def _distance(values: Vector, guides: Sequence[Guide]) -> float:
    pairs = zip(guides, values.tolist(), strict=True)
    return float(sum(g.weight * (v - g.start) ** 2 for g, v in pairs))


def _as_meant(
    system: System, point: Vector, columns: Sequence[int], guides: Sequence[Guide]
) -> bool:
    """Whether written values, or defaults in loops without written ones, have stayed near."""
    moved = abs(_values(system, point, guides) - [g.start for g in guides])
    written = [m for m, g in zip(moved, guides, strict=True) if g.weight == WRITTEN]
    if any(m > NEAR for m in written):
        return False
    if any(g.weight == WRITTEN and g.column < 0 for g in guides):
        return True
    program = system.program
    told = {
        program.candidates[g.column].block for g in guides if g.weight == WRITTEN and g.column >= 0
    }
    return all(
        m <= NEAR or (g.column >= 0 and program.candidates[g.column].block in told)
        for m, g in zip(moved, guides, strict=True)
        if g.weight != OTHER
    )


def _guesses(
    system: System,
    u: Vector,
    rows: Sequence[int],
    free: Sequence[int],
    guides: Sequence[Guide],
) -> list[Vector]:
    """The pulled guess, then guesses all around, by a sequence that fills space evenly."""
    import numpy as np

    pulled = [_pulled(system, u, rows, free, guides)]
    n = np.arange(1, len(free) + 1)
    for k in range(1, (MANY if len(free) <= SMALL_LOOP else FEW) + 1):
        around = u.copy()
        around[list(free)] += TURN * ((k * np.sqrt(1.7 + n)) % 1.0 - 0.5)
        pulled.append(around)
    return pulled


def _pulled(
    system: System,
    u: Vector,
    rows: Sequence[int],
    free: Sequence[int],
    guides: Sequence[Guide],
) -> Vector:
    """The guess at which conditions and written values are met as well as can be."""

    strong = {g.slot: g.start for g in guides if g.weight == WRITTEN}
    part = Part(system, u, rows, free, strong, PULL)
    return part.point(newton.solve(part, u[list(free)]).point)


def _without_turns(
    system: System,
    root: newton.Root,
    rows: Sequence[int],
    free: Sequence[int],
    guides: Sequence[Guide],
) -> newton.Root:
    """Angles may differ by whole turns from their start values: they are turned back."""
    import numpy as np

    point, best = root.point, _distance(_values(system, root.point, guides), guides)
    if best < min(g.weight for g in guides) * (TURN / 2) ** 2:
        return root
    limit = 1e-9 + 10 * float(np.max(np.abs(root.residuals), initial=0.0))
    better = True
    while better:
        better = False
        for c in free:
            for turn in (TURN, -TURN):
                trial = point.copy()
                trial[c] += turn
                r = system(trial)
                if r is None or np.max(np.abs(r[list(rows)]), initial=0.0) > limit:
                    continue
                distance = _distance(_values(system, trial, guides), guides)
                if distance < best * (1 - 1e-6):
                    point, best, better = trial, distance, True
    return newton.Root(point, root.residuals, True)


def _nearest(system: System, found: Sequence[newton.Root], guides: Sequence[Guide]) -> newton.Root:
    """Equally near ones are ordered by their first coordinates, so that rounding decides
    nothing."""
    values = [_values(system, r.point, guides) for r in found]
    distances = [_distance(v, guides) for v in values]
    enough = min(distances) * (1 + 1e-6) + 1e-12
    near = [i for i, d in enumerate(distances) if d <= enough]
    return found[max(near, key=lambda i: tuple(round(v, 6) for v in values[i].tolist()))]
