"""Joints that constrain what others constrain already, by their numbers.

In:   System at consistent start values
Out:  nothing, or PlanarcError R415 that names the joints and the conditions

The conditions of a loop are dependent where the Jacobian of a block has lost rank. That
may be so in one position only, as when a four-bar lies flat: such a position is passed.
So the mechanism is moved a little along what is free, its loops are closed again, and
only where the rank stays too low at each place a constraint is redundant. Where it
cannot be moved nothing is said.

Example: a parallelogram with a third bar parallel to the other two. Its four conditions
of closing have the rank three, whatever the angle.

Promises:  costs one small singular value decomposition where all is well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.options import ACCEPTING
from planarc.ir.flat import StateSelect
from planarc.ir.places import owner, point_home
from planarc.ir.program import BlockCode
from planarc.solve.messages.loops import loop_names
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System, gradients

if TYPE_CHECKING:
    from planarc.solve.start.newton import Vector

#: Singular values below this part of the largest count as zero.
RANK = 1e-8
#: Ways by which the mechanism is moved (radians, metres), and the way that it must have got.
STEPS, MOVED = (0.07, -0.11), 0.01
#: A condition takes part in a dependency with at least this weight.
PART = 0.05
_WORST = 4


class Redundant(PlanarcError):
    """Joints that hold the same motion twice, and are not accepted (R415)."""


def refuse_redundancy(system: System, values: Vector) -> None:
    """Leaves the workspace at `values`."""
    for i, block in system.blocks:
        if not block.residuals or block.height < 2:
            continue
        rows = _dependent_rows(system, i)
        if rows is None:
            continue
        redundant = all(_stays(system, i, block, values, step) for step in STEPS)
        system.evaluate_flag(values)
        if redundant:
            raise _redundant(system, i, block, rows)


def _dependent_rows(system: System, i: int) -> Vector | None:
    """Weights of the residuals in the combinations that vanish; None at full rank."""
    import numpy as np

    matrix = np.array(system.kernel.jacobian(i), dtype=float)
    if not math.isfinite(matrix.sum()):
        return None
    sizes = np.linalg.svd(matrix, compute_uv=False).tolist()
    rank = sum(s > RANK * max(1.0, sizes[0]) for s in sizes)
    if rank == len(matrix):
        return None
    left = np.linalg.svd(matrix)[0]
    weights: Vector = np.abs(left[:, rank:]).max(axis=1)
    return weights


def _stays(system: System, i: int, block: BlockCode, values: Vector, step: float) -> bool:
    """Whether conditions are dependent in a position beside this one, too."""
    import numpy as np

    system.evaluate_flag(values)
    columns = list(range(block.first, block.first + len(block.tears)))
    _, sizes, directions = np.linalg.svd(np.array(system.kernel.jacobian(i), dtype=float))
    rank = int(np.sum(sizes > RANK * max(1.0, sizes[0])))
    free = directions[rank:]
    if not len(free):
        return False
    moved = values.copy()
    moved[columns] += step * np.cos(np.arange(len(free))) @ free
    root = solve_stage(system, moved, list(system.block_rows[i]), columns)
    far = float(np.max(np.abs(root.point[columns] - values[columns])))
    if not root.converged or far < MOVED:
        return False
    system.evaluate_flag(root.point)
    return _dependent_rows(system, i) is not None


def _redundant(system: System, i: int, block: BlockCode, weights: Vector) -> PlanarcError:
    program = system.program
    chosen = [k for k, weight in enumerate(weights) if weight > PART]
    infos = [program.equations[block.equations[k]] for k in chosen]
    joints = _joints(system, i, block, chosen)
    found = Diagnostic(
        "R415",
        f"a constraint in the loops of {loop_names(program, joints)} follows from the others in "
        "every position: joints or bars hold the same motion twice, and their forces are "
        "not determined",
        infos[0].span if infos else None,
        hint="leave a parallel bar out, replace one of these joints by a freer one, or accept "
        f"them with {ACCEPTING}",
        related=tuple(Related(f"`{e.text}` depends on others", e.span) for e in infos[:_WORST]),
    )
    return Redundant(point_home(program, found, joints[-1] if joints else infos[0].component))


def _joints(system: System, i: int, block: BlockCode, chosen: Sequence[int]) -> list[str]:
    """The owners of the joint coordinates that the dependent conditions tie."""
    import numpy as np

    program = system.program
    matrix = np.array(system.kernel.jacobian(i), dtype=float)[list(chosen)]
    point = np.array([system.kernel.w[c.slot] for c in program.candidates])
    tied = [block.first + j for j in range(len(block.tears)) if np.any(np.abs(matrix[:, j]) > RANK)]
    names = [owner(program.candidates[c].display) for c in tied]
    dependent = [
        f for f in program.fixed if f.select >= StateSelect.PREFER and f.height == block.height
    ]
    slopes = gradients(system, point, dependent)
    names += [
        owner(f.display)
        for f, slope in zip(dependent, slopes, strict=True)
        if np.any(np.abs(slope[tied]) > RANK)
    ]
    return [n for n in dict.fromkeys(names) if n]
