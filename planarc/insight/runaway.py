"""Speeds that grow beyond all bounds, or in a way in which only a wrong sign makes them grow.

In:   Result
Out:  a warning R448, at the user's part

Example: a controller whose torque has the wrong sign turns its arm by 1e24 rad; or its slide is
2.1 times as fast every 2 s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from planarc.core.diagnostic import Diagnostic, Runaway, Severity
from planarc.core.prose import shortened
from planarc.core.unit import RPM
from planarc.ir.once import once
from planarc.ir.places import own_names, own_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.ir.result import Result

#: The names of speeds, where each is found, and its unit.
_Speeds: TypeAlias = Sequence[tuple[str, int, str]]
#: A speed, in m/s or rad/s, that nothing has: light is slower.
_FASTEST = 1e9
_TURNING = "rad/s"
_SPEEDS = ("m/s", _TURNING)
#: A speed of turning, in rad/s, above those of turbines and drills: some 570,000 rpm.
_FASTEST_TURN = 6e4
#: A speed above which growth by the same number in equal times is told; this number, at least; and
#: how much it may vary. A fall grows less, a pole that tips over ends below.
_FAST, _LEAST, _STEADY = 30.0, 1.6, 1.5
#: Powers of ten below that from which its growth is told.
_DECADES = 6
_SHOWN = 3


def judge_runaway(result: Result) -> Diagnostic | None:
    """The warning about the first of the speeds that passes the bound. What comes after is left
    alone: an angle that large has no digits left."""
    import numpy as np

    if len(result.time) < 3:
        return None
    speeds = [(n, result.stored[s], u) for n, s, u in _speeds(result.program) if s in result.stored]
    if not speeds:
        return None
    sizes = np.abs(result.data.take([column for _, column, _ in speeds], 1))
    largest = float(np.maximum.reduce(sizes, None))
    if math.isfinite(largest) and largest <= _FAST:
        return None
    with np.errstate(all="ignore"):
        beyond = sizes > _FASTEST
        fast = sizes > [_FASTEST_TURN if unit == _TURNING else np.inf for *_, unit in speeds]
    passed = beyond if beyond.any() else fast
    if not passed.any():
        return _multiplied(result, speeds, sizes)
    row = int(np.argmax(passed.any(axis=1)))
    at = int(np.argmax(passed[row]))
    name, _, unit = speeds[at]
    t = float(result.time[row])
    if passed is beyond:
        message = f"grows beyond all bounds: at t = {t:.3g} s it is above {_FASTEST:.0e} {unit}"
        message += _growth(result.time[: row + 1], sizes[: row + 1, at])
    else:
        most = float(np.nanmax(sizes[:, at]))
        message = f"reaches {most:.3g} {unit}, which is {most / RPM:.3g} rpm: nothing turns as fast"
    return _told(result.program, name, message)


def _multiplied(result: Result, speeds: _Speeds, sizes: Vector) -> Diagnostic | None:
    if (growth := _multiplying(result.time, sizes)) is None:
        return None
    at, ratio, span = growth
    name, _, unit = speeds[at]
    message = f"grows {ratio:.2g} times every {span:.2g} s, to {sizes[-1, at]:.3g} {unit}"
    return _told(result.program, name, message)


def _multiplying(time: Vector, sizes: Vector) -> tuple[int, float, float] | None:
    """The speed that is multiplied in each tenth of the last half of a run, the number by which it
    is, and the tenth; the most growing one."""
    import numpy as np

    rows = np.searchsorted(time, np.linspace(time[0], time[-1], 11)[5:])
    span = float(time[-1] - time[0]) / 10
    if len({*rows.tolist()}) < len(rows) or span <= 0:
        return None
    with np.errstate(all="ignore"):
        ratios = sizes[rows[1:]] / sizes[rows[:-1]]
        steady = (ratios.min(axis=0) > _LEAST) & (ratios.max(axis=0) < _STEADY * ratios.min(axis=0))
        found = np.flatnonzero(steady & (sizes[-1] > _FAST))
    if not len(found):
        return None
    at = int(found[np.argmax(sizes[-1, found])])
    return at, float(np.median(ratios[:, at])), span


def _told(program: Program, name: str, message: str) -> Diagnostic:
    part = own_part(program, name.rpartition(".")[0])
    drives = [d.component for d in program.declared if d.name == "suppliedPower"]
    own = own_names(program, drives)
    hint = "look for what pushes the same way as it moves, and the more the farther it goes"
    if own:
        hint += f": the sign of what gives {shortened([f'`{n}`' for n in own], _SHOWN)} its value"
    return Runaway(
        "R448", f"`{name}` {message}", part.span if part else None, Severity.WARNING, hint=hint
    )


def _growth(time: Vector, sizes: Vector) -> str:
    """How soon it becomes ten times as much, by the time since it was a thousandth of a thousandth;
    nothing where that is less than a few rows."""
    import numpy as np

    small = np.flatnonzero(sizes < _FASTEST * 10.0**-_DECADES)
    rows = len(sizes) - int(small[-1]) if len(small) else 0
    span = float(time[-1] - time[small[-1]]) / _DECADES if len(small) else 0.0
    return f", ten times as much every {span:.2g} s" if rows > _DECADES else ""


@once
def _speeds(program: Program) -> _Speeds:
    """Speeds that may be states, as the user's parts name them, with their slots and units."""
    slots = {candidate.slot for candidate in program.candidates}
    found: dict[int, tuple[str, str]] = {}
    for c in program.columns:
        if c.unit in _SPEEDS and c.slot in slots and own_part(program, c.name.rpartition(".")[0]):
            known = found.get(c.slot)
            if known is None or c.name.count(".") < known[0].count("."):
                found[c.slot] = c.name, c.unit
    return tuple((name, slot, unit) for slot, (name, unit) in found.items())
