"""All ways to put a mechanism together, found from many guesses.

In:   Model, parameters, start values
Out:  assemblies, the one nearest to the model's own guess first

What is held at the start (see solve/start/solve.py), or by initial equations, stays; the other
positions are guessed
anew, angles all around and lengths within the size of the mechanism, always the same
guesses. Solutions that differ by whole turns are one.

Example: a four-bar with a held crank has two, the rocker on one side or the other.

Promises:  each of them is a solution; that there are no others is likely, not certain.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planarc.api.analysis.point import starts_at
from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.diagnostic import error, usage_error
from planarc.core.options import RunOptions
from planarc.core.unknown import refuse_unknown
from planarc.solve.measure import length_of
from planarc.solve.opened import open_program
from planarc.solve.start.held import choose_held
from planarc.solve.start.sharing import missed
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System

if TYPE_CHECKING:
    from planarc.api.model import Model

#: Two solutions nearer than this, in the measure of the mechanism, are the same.
SAME = 1e-5


class Assembly(Data):
    """A way to put the mechanism together. `start` are start values for `simulate` by name, in SI
    units; `distance` is the length of the way (rad, m) from the model's own guess."""

    start: Mapping[str, float]
    distance: float

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.start)

    def __getitem__(self, name: str) -> float:
        """A start value, in its SI unit. Raises UnknownName."""
        refuse_unknown("start value", (name,), self.start)
        return self.start[name]


def assemble(model: Model, options: RunOptions, tries: int) -> tuple[Assembly, ...]:
    """All assemblies. Raises PlanarcError R472 where there is none."""
    if not isinstance(tries, int) or tries < 1:
        raise usage_error("C241", f"the number of tries is above 0, not {tries!r:.20}")
    program, kernel = model.program, model.compiled().load()
    request = open_program(program, kernel, options)
    length = length_of(program, kernel)
    system = System(program, kernel, request.start, frozenset(request.starts), length=length)
    guess = np.array([float(kernel.w[c.start]) for c in program.candidates]) / system.units
    rows, columns = position_stage(system)
    if not columns:
        return ()
    choice = choose_held(system, guess)
    system = system.holding(choice.others)
    rows, columns = position_stage(system)
    held = choice.held
    free = [c for c in columns if not held[c]]
    turns = _turns(system)
    written = _rows_of_positions(system, guess, columns)
    rows = [*rows, *written]
    found: list[Vector] = []
    places: list[Vector] = []  # the same, but for whole turns that an initial equation counts
    size = _size(system) / length
    for trial in _guesses(guess, free, turns, size, tries if rows else 1):
        root = solve_stage(system, trial, rows, free)
        if root.converged and not missed(system, root.point):
            point = _nearest_turns(root.point, guess, free, turns)
            if not any(np.max(np.abs(point[columns] - p[columns])) < SAME for p in found):
                found.append(point)
                values = system(point)
                turned = values is None or np.max(np.abs(values[written]), initial=0.0) > SAME
                places.append(root.point if turned else point)
    if not found:
        raise error(
            "R472",
            f"no way to put the mechanism together was found in {tries} tries",
            hint="check the lengths of its parts, and what is held at the start",
        )
    assemblies = []
    for point in places:
        system(point)
        known = starts_at(program, kernel.w)
        positions = {n: v for n, v in known.items() if n in position_names(system, columns)}
        distance = float(np.linalg.norm(((point - guess) * system.units)[columns]))
        assemblies.append(Assembly(positions, distance))
    return tuple(sorted(assemblies, key=lambda a: (round(a.distance, 9), *a.start.values())))


def position_stage(system: System) -> tuple[list[int], list[int]]:
    """The rows and candidates of the lowest level."""
    return next(iter(system.stages), ([], []))


def _rows_of_positions(system: System, guess: Vector, columns: Sequence[int]) -> list[int]:
    """The initial equations that hold positions, and nothing else."""
    slopes = system.slopes(guess) if system.initial_rows else None
    if slopes is None:
        return []
    others = np.delete(slopes, columns, axis=1)
    return [r for r in system.initial_rows if slopes[r].any() and not others[r].any()]


def position_names(system: System, columns: Sequence[int]) -> set[str]:
    """The names of positions: candidates, and others with a start value."""
    program = system.program
    found = {
        n for c in columns for n in (program.candidates[c].display, program.candidates[c].name)
    }
    lowest = max((b.height for b in program.blocks), default=0)
    return found | {f.display for f in program.fixed if f.height == lowest}


def _turns(system: System) -> set[int]:
    """Candidates that are angles."""
    units = {c.slot: c.unit for c in system.program.columns}
    return {i for i, c in enumerate(system.program.candidates) if units.get(c.slot) == "rad"}


def _size(system: System) -> float:
    """A length that is about that of the mechanism: its longest parameter in metres."""
    w = system.kernel.w
    lengths = [
        abs(float(w[p.slot]))
        for p in system.program.parameter_slots
        if p.unit == "m" and math.isfinite(float(w[p.slot]))
    ]
    return 2 * max((x for x in lengths if x < 1e6), default=1.0) or 1.0


def _guesses(
    guess: Vector, free: Sequence[int], turns: set[int], size: float, tries: int
) -> list[Vector]:
    random = np.random.default_rng(1)
    trials = [guess]
    for _ in range(tries - 1):
        trial = guess.copy()
        for i, u in zip(free, random.uniform(-1, 1, len(free)), strict=True):
            trial[i] = math.pi * u if i in turns else guess[i] + size * u
        trials.append(trial)
    return trials


def _nearest_turns(point: Vector, guess: Vector, free: Sequence[int], turns: set[int]) -> Vector:
    """Angles within half a turn of the guess."""
    result = point.copy()
    for i in free:
        if i in turns:
            away = point[i] - guess[i]
            result[i] = guess[i] + away - 2 * math.pi * round(away / (2 * math.pi))
    return result
