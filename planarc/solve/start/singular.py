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
from planarc.ir.places import declaration, own_names, owner
from planarc.ir.program import CandidateSlot
from planarc.solve.start.held import INDEPENDENT, Choice, Weakness, weakness
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.solve.start.failure import NotAssembled

#: Length (m) or angle (rad) by which a loop may be open.
_OPEN = 1e-6
#: A share that is nothing but rounding.
_NOTHING = 1e-12


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
        raise _singular(system, place, columns, held, found)


def _closed(system: System, u: Vector, level: tuple[Sequence[int], Sequence[int]]) -> bool:
    residuals = system(u)
    return residuals is not None and bool((abs(residuals[level[0]]) < _OPEN).all())


def _singular(
    system: System, place: Vector, columns: Sequence[int], held: Sequence[int], found: Weakness
) -> NotAssembled:
    from planarc.solve.messages import trouble
    from planarc.solve.start.failure import NotAssembled

    candidates = system.program.candidates
    moving = [c for c in columns if c not in held]
    largest = candidates[max(moving, key=lambda c: abs(found.motion[list(columns).index(c)]))]
    speed = float(found.motion[list(columns).index(candidates.index(largest))])
    told = f"{speed:.4g} (condition {1 / found.share:.0e})".replace("e+", "e")
    told = told if found.share > _NOTHING else "infinite"
    first = candidates[held[0]]
    kept = listed(f"`{candidates[c].display}` = {place[c]:.4g}" for c in held)
    blocks = {candidates[c].block for c in held}
    around = [owner(candidates[c].display) for c in columns if candidates[c].block in blocks]
    parts = trouble.names(own_names(system.program, around))
    instead = trouble.names([*_position(candidates, largest), largest.display])
    left_out = trouble.names(
        [n for c in held for n in (*_position(candidates, candidates[c]), candidates[c].display)]
    )
    return NotAssembled(
        Diagnostic(
            "R428",
            f"the loop of {parts} starts at a dead centre, where {kept} cannot be held: "
            f"`{largest.display}` would have to be {told}",
            declaration(system.program, first.display, first.span),
            hint=f"give start values of {instead} instead of {left_out}, or start farther from "
            "the dead centre",
        )
    )


def _position(candidates: Sequence[CandidateSlot], velocity: CandidateSlot) -> list[str]:
    """The candidate of which another one is the derivative."""
    return [c.display for c in candidates if c.derivative == velocity.slot]
