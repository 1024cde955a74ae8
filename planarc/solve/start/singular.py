"""Starts at a dead centre: what is held there decides next to nothing.

In:   System, the assembled start, which start values are held
Out:  nothing, or R428

A slider at its dead centre does not move however the crank turns. Held there with a speed of its
own it would need a crank of any speed: 0.5 m/s at 1e-7 m from the end is 1740 rad/s.

    share      the least part of a free motion, of length 1, that held velocities see
    condition  1/share: the factor from an error of what is held to one of the start
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic
from planarc.core.prose import listed
from planarc.ir.begin import INDEPENDENT, OPEN
from planarc.ir.places import declaration, owner
from planarc.ir.program import CandidateSlot, FixedSlot
from planarc.solve.start.contradiction import Contradiction, Level
from planarc.solve.start.held import Choice, Weakness, weakness
from planarc.solve.start.refused import NotAssembled
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import Stage, System, are_velocities

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: A share that is nothing but rounding: positions exact to 1e-12 lie as near as its root.
_NOTHING = 1e-6
#: Part of the largest speed from which the first one declared is named.
_MUCH = 0.5


def refuse_singular(system: System, guess: Vector, values: Vector, choice: Choice) -> None:
    """Raise R428 where held velocities are asked of a mechanism at its dead centre."""
    levels = system.stages
    if len({b.height for _, b in system.blocks}) < 2:
        return
    velocities = next(level for level in levels[1:] if level)
    columns = velocities[1]
    held = [c for c in columns if choice.held[c] and values[c]]
    if not held:
        return
    place, free = values, [c for c in columns if not choice.held[c]]
    asked = max(abs(float(values[c])) for c in held)
    if _closed(system, values, levels[0]):
        if max((abs(float(values[c])) for c in free), default=0.0) * INDEPENDENT <= asked:
            return
    else:  # velocities that cannot be had have moved the positions
        movable = [c for c in levels[0][1] if not choice.held[c]]
        root = solve_stage(system, guess, levels[0][0], movable)
        place = root.point
    found = weakness(system, place, velocities, held)
    if found is not None and found.share < INDEPENDENT:
        starts = [system.program.candidates[c] for c in held]
        raise NotAssembled(_singular(system, place, columns, starts, found))


def _closed(system: System, u: Vector, level: tuple[Sequence[int], Sequence[int]]) -> bool:
    residuals = system(u)
    return residuals is not None and bool((abs(residuals[level[0]]) < OPEN).all())


def dead_centre(system: System, u: Vector, found: Contradiction, level: Stage) -> Diagnostic | None:
    """R428 where fixed velocities that are too many would move their parts anywhere beside this
    position."""
    import numpy as np

    candidates = system.program.candidates
    if found.others or not are_velocities(system.program, level[1]):
        return None
    there = Level(system, u, *system.stages[0]).moved(u)
    span = Level(system, there, *level).span(there, ())
    items = [candidates.index(s) if isinstance(s, CandidateSlot) else s for s in found.beyond]
    moved = [] if span is None else list(map(span.row, items))
    if span is None or min(float(np.linalg.norm(m)) for m in moved) < INDEPENDENT:
        return None
    motion = np.array([span.row(c) @ moved[0] for c in level[1]])
    return _singular(system, u, level[1], found.beyond, Weakness(0.0, motion))


def _singular(
    system: System,
    place: Vector,
    columns: Sequence[int],
    held: Sequence[CandidateSlot | FixedSlot],
    found: Weakness,
) -> Diagnostic:
    from planarc.solve.messages import trouble
    from planarc.solve.messages.loops import loop_names

    program, w = system.program, system.kernel.w
    candidates = program.candidates
    sizes = {c: abs(float(m)) for c, m in zip(columns, found.motion, strict=True)}
    others = [c for c in columns if candidates[c] not in held]
    most = max(map(sizes.__getitem__, others))
    first_moving = next(c for c in others if sizes[c] >= _MUCH * most)
    speed = float(found.motion[list(columns).index(first_moving)] * system.units[first_moving])
    told = "infinite"
    if found.share > _NOTHING:
        told = f"{speed:.4g} (condition {1 / found.share:.0e})".replace("e+", "e")
    first, moving = held[0], candidates[first_moving]
    kept = listed(f"`{s.display}` = {float(w[s.start]):.4g}" for s in held)
    blocks = {candidates[c].block for c in columns if sizes[c] > INDEPENDENT * most}
    around = [owner(candidates[c].display) for c in columns if candidates[c].block in blocks]
    instead = trouble.names([*(p.display for p in _position(system, moving)), moving.display])
    places = [p for s in held for p in _position(system, s)]
    left_out = trouble.names([s.display for s in (*places, *held)])
    where = listed(f"`{p.display}` = {float(w[p.start]):.6g}" for p in places if p.fixed)
    return Diagnostic(
        "R428",
        f"{where and f'at {where} '}the loop of {loop_names(program, around)} starts at a dead "
        f"centre, where {kept} cannot be held: `{moving.display}` would have to be {told}",
        declaration(program, first.display, first.span),
        hint=f"give start values of {instead} instead of {left_out}, or start farther from the "
        "dead centre",
    )


def _position(
    system: System, velocity: CandidateSlot | FixedSlot
) -> list[CandidateSlot] | list[FixedSlot]:
    """The start of that variable of which another one is the derivative."""
    if isinstance(velocity, CandidateSlot):
        return [c for c in system.program.candidates if c.derivative == velocity.slot]
    above = (f for f in system.conditions if f.height > velocity.height)
    return [f for f in above if owner(f.display) == owner(velocity.display)]
