"""A mechanism put together with start values held.

In:   System, guess, the start values held
Out:  all candidates, or None where no way was found

Positions are solved first, then velocities, then everything once more together with initial
equations, which may tie any of them to accelerations. Where Newton's method fails from the
guesses, the loop is first closed with nothing held, and the held values are then moved from
there to where they were wanted.
"""

from __future__ import annotations

from collections.abc import Sequence
from sys import float_info
from typing import TYPE_CHECKING, TypeAlias

from planarc.ir.begin import ROUNDING
from planarc.ir.newton import SMALL
from planarc.solve.start import newton
from planarc.solve.start.branch import nearest_root
from planarc.solve.start.held import Choice, places
from planarc.solve.start.stage import Part, solve_stage
from planarc.solve.start.system import Stage, System

if TYPE_CHECKING:
    import numpy as np

    from planarc.core.arrays import Vector

    Flags: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


def assemble(system: System, u0: Vector, choice: Choice) -> Vector | None:
    """All candidates' values, or None."""
    import numpy as np

    held = np.array(choice.held)
    values = _solve_stages(system, u0, held)
    if values is not None:
        return values
    if _stays_open(system, u0):
        return None
    found = [
        v
        for p in places(u0)[1:]
        if (v := _solve_stages(system, np.where(held, u0, p), held)) is not None
    ]
    if found:
        return min(found, key=lambda v: float(np.linalg.norm(v - u0)))
    free = _solve_stages(system, u0, np.zeros(len(u0), dtype=bool))
    values = None if free is None else _move(system, free, u0, held)
    return _climb(system, u0, held) if values is None else values


def _stays_open(system: System, u0: Vector) -> bool:
    """Whether loops do not close with nothing held either, so that no held values let them."""
    import numpy as np

    if system.initial_rows or not system.stages:
        return False
    rows, columns = system.stages[0]
    lower = [i for i in range(len(u0)) if i not in columns]
    if _says_where(system, lower, np.ones(len(u0), dtype=bool)):
        return False
    nothing = np.zeros(len(u0), dtype=bool)
    return not nearest_root(system, u0, rows, columns, nothing).converged


def _climb(system: System, u0: Vector, held: Flags) -> Vector | None:
    """Initial equations solved by all ways that there are, where these give all that is free."""
    rows, columns = list(range(system.rows)), [i for i, h in enumerate(held) if not h]
    if not system.initial_rows or len(rows) != len(columns):
        return None
    from planarc.solve.rescue.ladder import climb

    part = Part(system, u0, rows, columns)
    for found in climb(part, u0[columns]):
        root = solve_stage(system, part.point(found.point), rows, columns)
        if root.converged:
            return root.point
    return None


def _unmoved(system: System, u0: Vector, u: Vector) -> Vector:
    """The candidates, those exactly at their guesses that lie there but for rounding: a speed of
    -1e-31 would start friction that is to stick."""
    import numpy as np

    for now, before in zip(u.tolist(), u0.tolist(), strict=True):
        if now != before and abs(now - before) <= ROUNDING * max(1.0, abs(before)):
            break
    else:
        return u
    beside = (u != u0) & (abs(u - u0) <= ROUNDING * np.maximum(1.0, abs(u0)))
    rows, slopes = system(u), system.slopes(u)
    if rows is None or slopes is None:
        return u
    sizes = abs(slopes)
    rough = np.maximum(abs(rows), 4 * float_info.epsilon * (sizes @ abs(u)))
    least = np.maximum(rough, SMALL**2 * sizes.max(axis=1, initial=0.0))
    moved = abs(rows[:, None] + slopes * (u0 - u))
    return np.where(beside & (moved <= least[:, None]).all(axis=0), u0, u)


def _solve_stages(system: System, u0: Vector, held: Flags, beside: bool = False) -> Vector | None:
    """`beside`: loops close near their guesses, or not at all."""
    u = u0.copy()
    above: Stage = [], []
    for rows, columns in system.stages:
        root = None
        if system.initial_rows.stop - 1 in rows:
            here = system.again(u)
            if here is not None and not any(map(here.tolist().__getitem__, rows)):
                continue
            root = solve_stage(system, u, rows, _movable(system, u, held))
        if root is None or not root.converged:
            root = nearest_root(system, u, rows, columns, held, beside)
        above = [*{*above[0], *rows}], [*{*above[1], *columns}]
        more = len(above[1]) > len(columns)
        if not root.converged and more and _says_where(system, columns, held):
            root = nearest_root(system, u, *above, held, beside)
        if not root.converged:
            return None
        u = _unmoved(system, u0, root.point)
    return u


def _says_where(system: System, columns: Sequence[int], held: Flags) -> bool:
    """Whether held values of a level decide places of levels above it: a distance that is
    differentiated once, of bodies whose places are differentiated twice. Held speeds do not."""
    candidates = system.program.candidates
    speeds = {c.derivative for c in candidates}
    return any(held[i] and candidates[i].slot not in speeds for i in columns)


def _movable(system: System, u: Vector, held: Flags) -> list[int]:
    """The candidates that closed loops and held values leave free: initial equations are for
    these, and need not shake what is settled."""
    import numpy as np

    free = [i for i, h in enumerate(held) if not h]
    jacobian = system.slopes(u)
    if jacobian is None:
        return free
    kept = np.delete(jacobian, system.initial_rows, axis=0)[:, free]
    moves = np.abs(newton.kernel_of(kept, 1e-8)).max(axis=1, initial=0.0)
    return [i for i, move in zip(free, moves, strict=True) if move > 1e-6]


def _move(
    system: System,
    u: Vector,
    wanted: Vector,
    held: Flags,
) -> Vector | None:
    """Continuation: held values go from an assembled position to where they are wanted."""
    begin, way, step = u[held].copy(), 0.0, 0.25
    while way < 1.0:
        part = min(1.0, way + step)
        trial = u.copy()
        trial[held] = (1 - part) * begin + part * wanted[held]
        following = _solve_stages(system, trial, held, beside=True)
        if following is None:
            step /= 2
            if step < 1e-3:
                return None
        else:
            u, way, step = following, part, min(0.25, 2 * step)
    return u
