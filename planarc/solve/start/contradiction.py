"""Fixed start values that contradict each other: which are too many, and what they follow as.

In:   System, a guess, rows and candidates of one level
Out:  Contradiction, or None where no more is fixed than can move

Fixed values of which some depend on others, where the loops are closed, are met one after another
in the order of declaration. What cannot be met beside those before it contradicts them.

Example: of a four-bar crank and rocker are fixed; it has one free motion. The crank's angle is
met, and the rocker's follows from it as 1.586 instead of 1.2.

Promises:  as many values at most as depend on others are left out: more of them would be out of
           reach by themselves.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.prose import listed
from planarc.core.source import NOWHERE, Span
from planarc.ir.begin import CLOSED, INDEPENDENT
from planarc.ir.dae import MISFIT
from planarc.ir.places import declaration, is_own, own_names, own_part, owner
from planarc.ir.program import CandidateSlot, EquationInfo, FixedSlot, Program
from planarc.solve.messages import trouble
from planarc.solve.messages.drive import drive_behind
from planarc.solve.messages.loops import is_closed, loop_names
from planarc.solve.messages.sides import other_side
from planarc.solve.messages.slides import one_way
from planarc.solve.start import newton
from planarc.solve.start.held import Directions, free_motions
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System, are_velocities, declared

if TYPE_CHECKING:
    from planarc.core.arrays import Vector


#: Ways by which the mechanism is moved (radians, metres) to see what moves with what: the first by
#: which it closes.
_MOVES = (0.4, 0.05)
#: Length (m) or angle (rad) below which Newton's method means zero.
_SMALL = 1e-6
_MOST = 3
_FIXED = re.compile(r"\bfixed\b")


class Contradiction(Data):
    """Values that are too many, with what they follow as, and those that they follow from."""

    beyond: tuple[CandidateSlot | FixedSlot, ...]
    follows: tuple[float, ...]
    others: tuple[CandidateSlot | FixedSlot, ...]
    point: Vector  # an assembly without the values that are too many


def contradiction(
    system: System, u0: Vector, rows: Sequence[int], columns: Sequence[int]
) -> Contradiction | None:
    """What is fixed too much among some candidates and the conditions among some rows."""
    level = Level(system, u0, rows, columns)
    root = level.meet((), u0)
    span = level.span(level.moved(root.point), level.items) if root.converged else None
    if span is None:
        return None
    doubtful = [item for item in level.items if item not in span.held]
    involved = {*doubtful, *(p for item in doubtful for p in span.partners(item))}
    met, beyond = [item for item in level.items if item not in involved], []
    for item in filter(involved.__contains__, level.items):
        trial = level.meet((*met, item), root.point)
        if trial.converged:
            root = trial
            met.append(item)
        else:
            beyond.append(item)
    span = level.span(level.moved(root.point), met)
    values = system(root.point)
    if span is None or values is None or not 0 < len(beyond) <= len(doubtful):
        return None
    partners = {p for item in beyond for p in span.partners(item)}
    return Contradiction(
        tuple(map(level.start, beyond)),
        tuple(level.value(item, root.point, values) for item in beyond),
        tuple(level.start(item) for item in met if item in partners),
        root.point,
    )


class Level:
    """Rows of a level, its candidates, and what is fixed of them in the order of declaration."""

    def __init__(
        self, system: System, u0: Vector, rows: Sequence[int], columns: Sequence[int]
    ) -> None:
        self.system, self.u0, self.columns = system, u0, list(columns)
        self._rows = fixed_starts(system, rows)
        wishes = {
            r for r, f in zip(system.fixed_rows, system.conditions, strict=True) if not f.fixed
        }
        self._own = [row for row in rows if row not in wishes.union(self._rows.values())]
        places = declared(system.program)
        fixed = [c for c in columns if system.program.candidates[c].fixed]
        self.items: list[int | FixedSlot] = sorted(
            [*fixed, *self._rows],
            key=lambda item: places.get(self.start(item).display, len(places)),
        )

    def start(self, item: int | FixedSlot) -> CandidateSlot | FixedSlot:
        return self.system.program.candidates[item] if isinstance(item, int) else item

    def value(self, item: int | FixedSlot, point: Vector, values: Vector) -> float:
        """A variable at a point in its unit, from the rows there."""
        if isinstance(item, int):
            return float(point[item] * self.system.units[item])
        row = self._rows[item]
        return float(values[row] * self.system.parts[row] + self.system.kernel.w[item.start])

    def meet(self, items: Sequence[int | FixedSlot], beside: Vector) -> newton.Root:
        """An assembly with some of what is fixed, from the guess or from beside another one."""
        import numpy as np

        rows = [*self._own, *(self._rows[i] for i in items if not isinstance(i, int))]
        free = [c for c in self.columns if c not in items]
        held = [i for i in items if isinstance(i, int)]
        root = solve_stage(self.system, self.u0, rows, free)
        if not root.converged:
            guess = np.array(beside)
            guess[held] = self.u0[held]
            root = solve_stage(self.system, guess, rows, free)
        return root

    def _motions(self, point: Vector) -> Vector | None:
        import numpy as np

        slopes = self.system.slopes(point)
        if slopes is None:
            return None
        return newton.kernel_of(slopes[np.ix_(self._own, self.columns)], CLOSED)

    def moved(self, point: Vector) -> Vector:
        """An assembly beside one, which may be at a dead centre."""
        motions = self._motions(point)
        if motions is None:
            return point
        for way in _MOVES:
            beside = point.copy()
            beside[self.columns] += way * motions.sum(axis=1)
            root = solve_stage(self.system, beside, self._own, self.columns)
            if root.converged:
                return root.point
        return point

    def span(self, point: Vector, items: Sequence[int | FixedSlot]) -> Directions | None:
        """What is independent of some items, as they move with the free motions of a place."""
        slopes, motions = self.system.slopes(point), self._motions(point)
        if slopes is None or motions is None:
            return None

        def row(item: int | FixedSlot) -> Vector:
            if isinstance(item, int):
                found: Vector = motions[self.columns.index(item)]
                return found
            moved: Vector = slopes[self._rows[item], self.columns] @ motions
            return moved

        span = Directions(motions.shape[1], row)
        for item in items:
            span.add(item)
        return span


def fixed_starts(system: System, rows: Sequence[int]) -> dict[FixedSlot, int]:
    """The fixed start values among some rows, of variables that are no candidates."""
    return {
        f: row
        for row, f in zip(system.fixed_rows, system.conditions, strict=True)
        if row in rows and f.fixed and not f.display.startswith(MISFIT)
    }


def initial_against_fixed(
    system: System, u0: Vector, rows: Sequence[int], columns: Sequence[int]
) -> Diagnostic | None:
    """The message where all fixed start values can be met without one initial equation of the
    user's among some rows, and that is the only one."""
    program, first = system.program, system.initial_rows.start
    infos = program.initial_equations
    initial = [row for row in rows if row in system.initial_rows and row - first < len(infos)]
    own = [row for row in initial if is_own(program, infos[row - first].span)]
    levels = [Level(system, u0, [r for r in rows if r != row], columns) for row in own]
    met = [level.items and level.meet(level.items, u0).converged for level in levels]
    if met.count(True) != 1:
        return None
    info, level = infos[own[met.index(True)] - first], levels[met.index(True)]
    every = Level(system, u0, rows, columns)  # with that equation
    culprits = [
        item
        for item in every.items
        if every.meet([other for other in every.items if other is not item], u0).converged
    ]
    starts = [level.start(item) for item in culprits or level.items]
    names = trouble.names([s.start_name for s in starts])
    spans = dict.fromkeys(declaration(program, s.start_name, s.span) for s in starts)
    values = "values" if len(starts) > 1 else "value"
    one = "one of " if len(starts) > 1 else ""
    return Diagnostic(
        "R411",
        f"the initial equation `{info.text}` contradicts the fixed start {values} of {names}",
        info.span,
        hint=f"remove it, or `fixed = true` from {one}{names}",
        related=tuple(Related("a start is fixed here", span) for span in spans),
    )


def contradicting(
    system: System,
    found: Contradiction,
    columns: Sequence[int],
    worst: Sequence[EquationInfo] = (),
) -> Diagnostic:
    """The message; `worst` are the equations that are farthest from being met with all of it."""
    program, others = system.program, found.others
    first, *more = found.beyond
    places = declared(program)
    told = sorted((*others, *found.beyond), key=lambda s: places.get(s.display, len(places)))
    names = trouble.names([s.start_name for s in told])
    which = trouble.names([s.start_name for s in found.beyond])
    follows = listed(f"{value:.6g}" for value in found.follows)
    verb = "follow" if more else "follows"
    hint = f"remove `fixed = true` from {which}, which {verb} as {follows} from the others"
    if not more and not are_velocities(program, columns):
        around, given = [owner(s.start_name) for s in told], float(system.kernel.w[first.start])
        hint += other_side(program, system.kernel, around, given, found.follows[0])
    if len(others) == 1 and not more:
        hint += f"; or from `{others[0].start_name}`, if that is not to be kept"
    place = declaration(program, first.start_name, first.span)
    drive = "" if more else _hidden_drive(program, first)
    if drive:
        part, _, name = drive.rpartition(".")
        hint = f"`{drive}` is held there at the start: write `{part}({name}(start={follows}))`"
    if isinstance(first, CandidateSlot) and not (more or others or drive):
        held = program.candidates.index(first)
        locked = _locked(system, found.point, held, columns, place)
        if locked is not None:
            return locked
    against = [i for i in worst if is_own(program, i.span)][:1]
    what = f"`{against[0].text}`" if against else "the equations"
    if not (against or others or more) and (beside := _beside(program, first)):
        what += f" of {trouble.names(beside)}"
        behind = drive_behind(program, first.slot)
        if behind and behind not in beside:
            what += f", which `{behind}` moves"
    notes = [
        (f"`{s.start_name}` is fixed here", declaration(program, s.start_name, s.span))
        for s in (*others, *more)
    ]
    notes += [] if others else [(f"`{i.text}` stands here", i.span) for i in against]
    return Diagnostic(
        "R411",
        f"the fixed start values of {names} contradict each other"
        if others
        else f"the fixed start value of {names} contradicts {what}",
        place,
        hint=hint,
        related=tuple(Related(message, span) for message, span in notes[:_MOST]),
    )


def _locked(
    system: System,
    point: Vector,
    held: int,
    columns: Sequence[int],
    place: Span,
) -> Diagnostic | None:
    """The message where a loop holds the joint whose start is fixed, so that no start fits."""
    program, first = system.program, system.program.candidates[held]
    motions = free_motions(system, point)
    if (
        program.mechanism is None
        or motions is None
        or not is_closed(program, [owner(first.display)])
    ):
        return None
    moving = [i for i in columns if abs(motions[i]).max(initial=0.0) > INDEPENDENT]
    if held in moving:
        return None
    joints = {j.name for j in program.mechanism.joints}
    shown = [program.candidates[i].display for i in moving]
    names = own_names(program, (owner(n) for n in shown if owner(n) in joints))
    free = trouble.names(names)
    loop = loop_names(program, [owner(first.display)])
    there = point[held] * system.units[held]
    name, value = first.start_name, f"{there:.4g}" if abs(point[held]) > _SMALL else "0"
    only = f"only {free} can move" if free else "nothing in it can move"
    return Diagnostic(
        "R411",
        f"`{name}` cannot start at {float(system.kernel.w[first.start]):.4g}: the loop of {loop} "
        f"holds it at {value}, and {only}",
        place,
        hint=one_way(program, system.kernel, [owner(first.display)])
        or "change a length in this loop, or the direction of a slide",
        related=tuple(
            Related(f"`{n}` moves here", declaration(program, f"{n}.x", NOWHERE)) for n in names
        ),
    )


def _beside(program: Program, held: CandidateSlot | FixedSlot) -> list[str]:
    """The parts beside the mechanism that know a variable by a name of their own, as motors do."""
    mechanism = program.mechanism
    frames = {f for link in mechanism.links for f in link.frames} if mechanism else set()
    inside = own_names(program, map(owner, frames))
    same = (owner(c.name) for c in program.columns if c.slot == held.slot)
    return [n for n in own_names(program, same) if n not in (*inside, owner(held.start_name))]


def _hidden_drive(program: Program, held: CandidateSlot | FixedSlot) -> str:
    """The variable of a part beside the mechanism, such as a motor, that is the same one, where
    nothing at the user's own place says that it is fixed."""
    if not held.fixed or _FIXED.search(declaration(program, held.start_name, held.span).text):
        return ""
    mechanism = program.mechanism
    joints = {j.name for j in mechanism.joints} if mechanism else set()
    same = (c.name for c in program.columns if c.slot == held.slot)
    for name in same:
        part = own_part(program, owner(name))
        if part is not None and part.name == owner(name) and part.name not in joints:
            return name
    return ""
