"""Joints that constrain what others constrain already, and starts in flat positions.

In:   System at consistent start values
Out:  nothing, or PlanarcError: R415 that names the joints and the conditions, R437 (`flat`)

The conditions of a loop are dependent where the Jacobian of a block has lost rank: in one
position only, as when a four-bar lies flat, or in all of them. So the mechanism is moved a
little along what is free, and its loops are closed again. Where the rank stays too low at each
place a constraint is redundant; where it comes back the start is a flat position. Where the
mechanism cannot be moved nothing is said.

Example: a parallelogram with a third bar parallel to the other two. Its four conditions
of closing have the rank three, whatever the angle. Without that bar its two conditions have
the rank one where all bars lie on one line, and two elsewhere.

Promises:  costs some multiplications where all is well and loops are small, and else one small
           singular value decomposition.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from operator import mul
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.mend import Accept
from planarc.core.options import ACCEPTING
from planarc.core.prose import both
from planarc.ir.begin import SUSPECT
from planarc.ir.mechanism import Joint
from planarc.ir.places import own_names, owner, point_home
from planarc.ir.program import BlockCode, Program
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Singular values below this part of the largest count as zero.
RANK = 1e-8
#: A start is flat where the least singular value is below this part of that beside. Rounding,
#: 1e-16 of a bar's length, is an angle of 1e-11 where bars are 1e-5 rad off their line: there
#: the directions of motion are known to six digits, and to none at 1e-8 rad.
FLAT = 1e-5
#: Ways by which the mechanism is moved (radians, metres), and the way that it must have got.
STEPS, MOVED = (0.07, -0.11), 0.01
#: Conditions up to which Python is faster than NumPy.
SMALL = 6
#: A condition takes part in a dependency with at least this weight.
PART = 0.05
_WORST = 4


class Redundant(PlanarcError):
    """Joints that hold the same motion twice, and are not accepted (R415)."""


class _Look(Data):
    """What a block's Jacobian says at one place. `share` is its least singular value, as part
    of the largest where that exceeds 1."""

    share: float
    weights: Vector  # of the conditions in the combinations that vanish, or nearly do
    free: Vector  # motions that keep the other conditions, one in each row


def refuse_redundancy(system: System, values: Vector) -> None:
    """Leaves the workspace at `values`."""
    for i, block in system.blocks:
        if not block.residuals or block.height < 2:
            continue
        here = _look(system, i)
        if here is None:
            continue
        beside = [_beside(system, i, block, values, step * here.free) for step in STEPS]
        system.evaluate_flag(values)
        if here.share <= RANK and all(b is not None and b <= RANK for b in beside):
            raise _redundant(system, i, block, here.weights)
        if any(b is not None and here.share < FLAT * b for b in beside):
            from planarc.solve.start.flat import flat_start

            raise flat_start(system, i, block, values, here.free)


def _look(system: System, i: int) -> _Look | None:
    """None where the conditions are plainly independent, or have no value."""
    import numpy as np

    rows = system.jacobian(i)
    if _are_independent(rows):
        return None
    matrix = np.array(rows, dtype=float)
    sizes = _sizes(matrix)
    small = [s < SUSPECT for s in sizes]
    if True not in small:
        return None
    left, _, right = np.linalg.svd(matrix)
    rank = small.index(True)
    return _Look(sizes[-1], np.abs(left[:, rank:]).max(axis=1), right[rank:])


def _are_independent(rows: Sequence[Sequence[float]]) -> bool:
    """Whether no singular value of a few rows can be suspect: their product is that of the
    distances of each row from what those before it span, and none is larger than `size`."""
    count, size = len(rows), math.hypot(*chain.from_iterable(rows))
    if count > SMALL:
        return False
    volume, units = 1.0, list[list[float]]()
    for row in rows:
        left = list(row)
        for unit in units:
            along = sum(map(mul, left, unit))
            left = [x - along * u for x, u in zip(left, unit, strict=True)]
        length = math.hypot(*left)
        if not length > 0.0:
            return False
        units.append([x / length for x in left])
        volume *= length
    return volume > SUSPECT * size ** (count - 1) * max(1.0, size)


def _sizes(matrix: Vector) -> list[float]:
    """The singular values, falling; none where the matrix is not finite."""
    import numpy as np

    if not math.isfinite(matrix.sum()):
        return []
    sizes = np.linalg.svd(matrix, compute_uv=False)
    return list((sizes / max(1.0, sizes[0])).tolist())


def _beside(system: System, i: int, block: BlockCode, values: Vector, free: Vector) -> float | None:
    """The least singular value at a place beside this one; None where nothing moves."""
    import numpy as np

    columns = list(range(block.first, block.first + len(block.tears)))
    moved = values.copy()
    moved[columns] += np.cos(np.arange(len(free))) @ free
    root = solve_stage(system, moved, list(system.block_rows[i]), columns)
    far = float(np.max(np.abs(root.point[columns] - values[columns])))
    if not root.converged or far < MOVED:
        return None
    system.evaluate_flag(root.point)
    sizes = _sizes(np.array(system.jacobian(i), dtype=float))
    return sizes[-1] if sizes else None


def _redundant(system: System, i: int, block: BlockCode, weights: Vector) -> PlanarcError:
    from planarc.solve.messages.loops import loop_joints, loop_names

    program = system.program
    chosen = [k for k, weight in enumerate(weights) if weight > PART]
    infos = [program.equations[block.equations[k]] for k in chosen]
    parts = [*_joints(system, i, block, chosen), *(e.component for e in infos)]
    loop = loop_joints(program, parts)
    concerned = {joint.name for joint in loop} or {*parts}
    last = next((p.name for p in reversed(program.parts) if p.name in concerned), parts[-1])
    found = Diagnostic(
        "R415",
        f"a constraint in the loops of {loop_names(program, parts)} follows from the others in "
        "every position: joints or bars hold the same motion twice, and their forces are "
        "not determined",
        infos[0].span if infos else None,
        hint=f"{_advice(program, loop)}, or accept them with {ACCEPTING}",
        related=tuple(Related(f"`{e.text}` depends on others", e.span) for e in infos[:_WORST]),
        mend=Accept(),
    )
    return Redundant(point_home(program, found, last))


def _advice(program: Program, loop: Sequence[Joint]) -> str:
    """What to do about joints that hold the same motion."""
    names = own_names(program, (joint.name for joint in loop))
    if len(names) == 2 and len({joint.links for joint in loop}) == 1:
        return (
            f"{both(names)} join the same two parts, which holds these together: leave one of the "
            "two out, put a joint between parts that are connected without one"
        )
    return "leave a parallel bar out, replace one of these joints by a freer one"


def _joints(system: System, i: int, block: BlockCode, chosen: Sequence[int]) -> list[str]:
    """The owners of the candidates that the dependent conditions tie."""
    import numpy as np

    matrix = np.array(system.jacobian(i), dtype=float)[list(chosen)]
    tied = (np.abs(matrix) > RANK).any(axis=0).nonzero()[0]
    names = [owner(system.program.candidates[block.first + j].display) for j in tied.tolist()]
    return [n for n in dict.fromkeys(names) if n]
