"""Starts where all bars of a loop lie on one line: the loop can leave them in more than one way.

In:   System at consistent start values, a block whose conditions have lost rank there only
Out:  PlanarcError R437, with a place on each way

Which way a mechanism takes is not in its equations there, and its accelerations have no value:
rounding would choose.

Example: a parallelogram in which all angles are 0 goes on as a parallelogram, both cranks turning
alike, or crosses its bars, the cranks turning against each other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.places import declaration, owner
from planarc.ir.program import BlockCode
from planarc.solve.messages.loops import loop_names
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Distance from the flat position at which ways are told (rad, m), the least distance between two
#: of them there, and the farthest that another unknown may go on its way there.
_ASIDE, _APART, _FAR = 0.1, 1e-3, 1.0
#: Directions that are tried on half a turn.
_FAN = 12


def flat_start(
    system: System, i: int, block: BlockCode, values: Vector, free: Vector
) -> PlanarcError:
    """The message, with two ways and what tells them apart. Leaves the workspace elsewhere.
    `free`: the motions of the block's unknowns that keep its conditions, one in each row."""
    program = system.program
    columns = range(block.first, block.first + len(block.tears))
    names = [program.candidates[c].display for c in columns]
    moves = abs(free).max(axis=0)
    asking = (c for c in system.asking if isinstance(c, int) and c in columns)
    leading = next((c for c in asking if moves[c - block.first] > _APART), columns[0])
    hint = f"let it start beside that position: give `{names[leading - block.first]}` and "
    hint += "another joint of the loop start values that lie on the way that is meant"
    ways = _ways(system, i, columns, values, free, leading)
    if len(ways) > 1:
        other = max(columns, key=lambda c: abs(ways[0][c] - ways[1][c]))
        one, two = sorted(float(way[other] * system.units[other]) for way in ways[:2])
        lead_at = ways[0][leading] * system.units[leading]
        hint += (
            f": with `{names[leading - block.first]}` = {lead_at:.4g}, "
            f"`{names[other - block.first]}` is {one:.4g} on one and {two:.4g} on the other"
        )
    loop = loop_names(program, [owner(n) for n in names])
    lead = program.candidates[leading]
    return PlanarcError(
        Diagnostic(
            "R437",
            f"the loop of {loop} starts in a flat position, from which it can move in more than "
            "one way; the equations do not say in which",
            declaration(program, lead.display, lead.span),
            hint=hint,
        )
    )


def _ways(
    system: System, i: int, columns: range, values: Vector, free: Vector, leading: int
) -> list[Vector]:
    """Places with closed loops where the leading unknown has moved, no two alike; the nearest
    first."""
    import numpy as np

    found: list[Vector] = []
    others = [c for c in columns if c != leading]
    wide = np.cos(np.arange(len(free))) @ free
    for turn in np.pi * (np.arange(_FAN) + 0.5) / _FAN:
        direction = np.cos(turn) * free[0] + np.sin(turn) * (free[1] if len(free) > 1 else wide)
        lead = direction[leading - columns.start]
        if abs(lead) < _APART:
            continue
        guess = values.copy()
        guess[list(columns)] += _ASIDE / lead * direction
        root = solve_stage(system, guess, list(system.block_rows[i]), others)
        if root.converged and all(_distance(root.point, place) > _APART for place in found):
            found.append(root.point)
    near = [place for place in found if _distance(place, values) < _FAR]
    return sorted(near, key=lambda place: _distance(place, values))


def _distance(one: Vector, other: Vector) -> float:
    return float(max(abs(one - other)))
