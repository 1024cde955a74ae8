"""On which side a loop closes: the assembly nearest to the start values that were given.

In:   System, guess, rows and candidates of one level, the candidates held
Out:  Root    of all solutions found the one nearest to what was written

Newton's method from the guesses finds some assembly, and where all start values are near
an assembly it is that one. Where a written value has been left far behind, or a loop had
nothing but defaults to start from, other guesses are tried, always the same ones: the
written values of dependent coordinates pull, and the others go round. Of the assemblies
found counts the nearest: by written values first, then by those of the joints
(StateSelect.prefer), then by all. An angle that is a turn away is as far as can be: a wheel
that rolls along turns often, and decides nothing. Nor is a body turned over where another assembly
leaves it upright: a chassis between its wheels. Equally near ones are told apart by the
sign of the first coordinate in which they differ.

Example: a four-bar with a held crank and a rough value of the rocker's angle, which
follows from the others; it closes on the rocker's side, whichever angles are guessed.

Speeds that follow from positions and held speeds have one root, and no other is looked for.

Promises:  an angle is not a whole turn away from its start value where it need not be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from planarc.core.data import Data
from planarc.ir.begin import JOINT, NEAR, OTHER, WRITTEN
from planarc.ir.once import once
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.solve.measure import sizes_of_slots
from planarc.solve.start import newton
from planarc.solve.start.stage import Part, solve_stage
from planarc.solve.start.system import System, declared, weight_of

if TYPE_CHECKING:
    import numpy as np

    from planarc.core.arrays import Vector

    Flags: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

#: Newton's iterations from written values that agree: there is no way to go for them.
AGREEING = 12
#: Other guesses for loops of at most so many coordinates, and for larger ones.
SMALL_LOOP, MANY, FEW = 12, 16, 4
#: Tries after which the search ends where all miss by as much, and their relative difference: parts
#: that do not reach each other miss so from everywhere.
ENOUGH, SAME = 5, 1e-3
#: Difference of two points that are one root.
ALIKE = 1e-9
#: The pull of a guess, against the conditions; and Newton's iterations for it, a guess only.
PULL, PULLED = 0.1, 12
TURN = 6.283185307179586
#: A body is turned over that is turned by more than this, in rad.
OVER = TURN / 4
#: Choices of candidates and given values of which the guides are remembered.
MOST_PLANS = 64


class Guide(Data):
    """A coordinate that should stay near its start value, both in a measure of `size`; `column` is
    -1 of no candidate."""

    slot: int
    size: float
    start: float
    weight: float
    column: int
    place: int  # in the order of declaration
    angle: bool


def nearest_root(
    system: System,
    u: Vector,
    rows: Sequence[int],
    columns: Sequence[int],
    held: Flags,
    beside: bool = False,
) -> newton.Root:
    """The root's point is of all candidates; `converged` is false where none was found. `beside`:
    that of the guess alone, however far other start values are."""
    level = _Level(system, rows, [c for c in columns if not held[c]])
    if not level.free or not rows or not level.guides or beside:
        return level.solve(u)
    if system.follow and (root := level.following(u)) is not None:
        return root
    first = level.agreeing(u) or level.solve(u)
    if first.converged:
        if level.has_one_root():
            return first
        first = level.without_turns(first)
        if level.is_as_meant(first.point, columns):
            return first
    found = [first] if first.converged else []
    misses = [] if found else [_miss(first)]
    seen: list[Vector] = []
    for guess in level.guesses(u):
        root = level.solve(guess)
        if root.converged and any(bool((abs(p - root.point) <= ALIKE).all()) for p in seen):
            continue
        if root.converged:
            seen.append(root.point)
            found.append(level.without_turns(root))
        else:
            misses.append(_miss(root))
        if not found and len(misses) >= ENOUGH and max(misses) - min(misses) < SAME * max(misses):
            break
    return level.nearest(found) if found else first


def _miss(root: newton.Root) -> float:
    """How far a place is from an assembly."""
    return math.hypot(*root.residuals.tolist())


def agreed_place(system: System, u: Vector) -> Vector | None:
    """An assembled position with all values that were written, where they agree."""
    for rows, columns in system.stages:
        own = [row for row in rows if row < system.initial_rows.start]
        root = _Level(system, own, columns).agreeing(u)
        if root is None:
            return None
        u = root.point
    return u


class _Level:
    """Some rows to be met by some candidates, which the guides lead."""

    def __init__(self, system: System, rows: Sequence[int], free: Sequence[int]) -> None:
        self.system, self.rows, self.free = system, rows, list(free)
        self.guides = _guides(system, free)
        self._strong = [g for g in self.guides if g.weight == WRITTEN]
        self._seen: tuple[bytes, Vector] | None = None  # the last point looked at, its values

    def has_one_root(self) -> bool:
        """Whether all rows are of linear blocks with as many free candidates: speeds, mostly."""
        rows, free, known = set(self.rows), set(self.free), 0
        for i, block in self.system.blocks:
            own = self.system.block_rows[i]
            if own and own.start in rows:
                tears = range(block.first, block.first + len(block.tears))
                if not block.linear or len(free.intersection(tears)) != len(own):
                    return False
                known += len(own)
        return known == len(rows)

    def solve(self, guess: Vector) -> newton.Root:
        return solve_stage(self.system, guess, self.rows, self.free)

    def following(self, u: Vector) -> newton.Root | None:
        """The root beside an assembly that was good before; None where it lies elsewhere."""
        root = self.solve(u)
        moved = abs(root.point - u)[self.free]
        return root if root.converged and bool((moved <= NEAR).all()) else None

    def agreeing(self, u: Vector) -> newton.Root | None:
        """The root that moves no written value, where all of these agree with each other."""
        kept = {g.column for g in self._strong}
        movable = [c for c in self.free if c not in kept]
        if not movable or not self._strong:
            return None
        dependent = {g.slot: g.start for g in self._strong if g.column < 0}
        part = Part(self.system, u, self.rows, movable, dependent)
        root = newton.solve_near(part, u[movable], AGREEING)
        if not root.converged:
            return None
        return newton.Root(part.point(root.point), root.residuals[: len(self.rows)], True)

    def _values(self, point: Vector) -> Vector:
        import numpy as np

        place = point.tobytes()
        if self._seen is None or self._seen[0] != place:
            self.system.again(point)
            found = np.array([self.system.kernel.w[g.slot] / g.size for g in self.guides])
            self._seen = place, found
        return self._seen[1]

    def _distance(self, values: Vector) -> float:
        """How far values are from their guides."""
        pairs = zip(self.guides, values.tolist(), strict=True)
        return float(sum([g.weight * (v - g.start) ** 2 for g, v in pairs]))

    def _within_a_turn(self, values: Vector) -> float:
        """The same, angles being a turn away at most; a body that is turned over counts as the
        coordinate of a joint does."""
        ways = abs(values - [g.start for g in self.guides]).tolist()
        pairs = zip(self.guides, ways, strict=True)
        return float(sum([_weight(g, w) * (min(w, TURN) if g.angle else w) ** 2 for g, w in pairs]))

    def is_as_meant(self, point: Vector, columns: Sequence[int]) -> bool:
        """Whether written values, or defaults in loops without written ones, have stayed near."""
        values = self._values(point).tolist()
        far = [g for v, g in zip(values, self.guides, strict=True) if not abs(v - g.start) <= NEAR]
        if any(g.weight == WRITTEN for g in far):
            return False
        if any(g.column < 0 for g in self._strong):
            return True
        candidates = self.system.program.candidates
        told = {candidates[g.column].block for g in self._strong}
        return all(
            g.column >= 0 and candidates[g.column].block in told for g in far if g.weight != OTHER
        )

    def guesses(self, u: Vector) -> list[Vector]:
        """The pulled guess, then guesses all around, by a sequence that fills space evenly."""
        import numpy as np

        found = [self._pulled(u)]
        n = np.arange(1, len(self.free) + 1)
        for k in range(1, (MANY if len(self.free) <= SMALL_LOOP else FEW) + 1):
            around = u.copy()
            around[self.free] += TURN * ((k * np.sqrt(1.7 + n)) % 1.0 - 0.5)
            found.append(around)
        return found

    def _pulled(self, u: Vector) -> Vector:
        """The guess at which conditions and written values are met as well as can be."""
        strong = {g.slot: g.start for g in self._strong}
        part = Part(self.system, u, self.rows, self.free, strong, PULL)
        return part.point(newton.solve(part, u[self.free], PULLED).point)

    def without_turns(self, root: newton.Root) -> newton.Root:
        """Angles may differ by whole turns from their start values: they are turned back."""
        import numpy as np

        point, best = root.point, self._distance(self._values(root.point))
        if best < min([g.weight for g in self.guides]) * (TURN / 2) ** 2:
            return root
        limit = 1e-9 + 10 * float(np.max(np.abs(root.residuals), initial=0.0))
        better = True
        while better:
            better = False
            for c in self.free:
                for turn in (TURN, -TURN):
                    trial = point.copy()
                    trial[c] += turn
                    r = self.system(trial)
                    if r is None or np.max(np.abs(r[list(self.rows)]), initial=0.0) > limit:
                        continue
                    distance = self._distance(self._values(trial))
                    if distance < best * (1 - 1e-6):
                        point, best, better = trial, distance, True
        return newton.Root(point, root.residuals, True)

    def nearest(self, found: Sequence[newton.Root]) -> newton.Root:
        """Equally near ones are ordered by their first coordinates, so that rounding decides
        nothing."""
        values = [self._values(r.point) for r in found]
        near = list(range(len(found)))
        for measure in (self._within_a_turn, self._distance):
            distances = [measure(values[i]) for i in near]
            enough = min(distances) * (1 + 1e-6) + 1e-12
            near = [i for i, d in zip(near, distances, strict=True) if d <= enough]
        return found[max(near, key=lambda i: tuple(round(v, 6) for v in values[i].tolist()))]


def _weight(guide: Guide, way: float) -> float:
    return max(guide.weight, JOINT) if guide.angle and way > OVER else guide.weight


def _guides(system: System, free: Sequence[int]) -> list[Guide]:
    known, key = _plans(system.program), (tuple(free), system.given, system.conditions)
    plan = known.get(key)
    if plan is None:
        if len(known) > MOST_PLANS:
            known.clear()
        plan = known[key] = _plan(system, free)
    w = system.kernel.w
    sizes = sizes_of_slots(system.program, system.length, (slot for slot, *_ in plan))
    return [
        Guide(slot, size, float(w[start]) / size, weight, column, place, angle)
        for (slot, start, weight, column, place, angle), size in zip(plan, sizes, strict=True)
    ]


#: The guides of some candidates, for what is given and held: slots of values and of start values,
#: and what else a `Guide` tells.
_Plan: TypeAlias = tuple[tuple[int, int, float, int, int, bool], ...]


@once
def _plans(program: Program) -> dict[tuple[object, ...], _Plan]:
    """The guides that were asked for."""
    return {}


def _plan(system: System, free: Sequence[int]) -> _Plan:
    program = system.program
    places = declared(program)
    last = len(places)
    heights = {program.blocks[program.candidates[c].block].height for c in free}
    others = (f for f in program.fixed if f.height in heights and f not in system.conditions)
    angles = {c.slot for c in program.columns if c.unit == "rad"}
    items: list[tuple[CandidateSlot | FixedSlot, int]] = [(program.candidates[i], i) for i in free]
    items += ((f, -1) for f in others)
    found = []
    for item, column in items:
        weight = weight_of(item, system.written(item))
        place = places.get(item.display, last)
        found.append((item.slot, item.start, weight, column, place, item.slot in angles))
    return tuple(sorted(found, key=lambda guide: guide[4]))
