"""Joints with dry friction that do not move at a point: what an analysis there leaves out.

In:   Point
Out:  warnings (R475), one for each joint that rubs and rests

At rest friction is whatever holds, up to a limit, and has no slope: places of rest are a range, and
a linear model knows only of sliding one way, or of holding for good.
"""

from __future__ import annotations

import numpy as np

from planarc.api.analysis.point import Point
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.places import own_part, owner

#: Slip below this one, in m/s, is none.
CREEP = 1e-6
#: Modes of what sticks, and of what does not rub (`Joints.Internal.Rubbing`).
_STICKS, _FREE = 0, 2
_RANGE = (
    "{joint} rubs: this is {where} of a range of places in which its friction holds it",
    "with `mu = 0` there, the place without friction is found; a run shows where it stops",
)
_LINEAR = (
    "{joint} rubs, and rests here: the linear model {takes}",
    "with `mu = 0` there, the modes without friction are found; those of a motion, at a time at "
    "which it moves",
)


def told_at_rest(point: Point) -> tuple[Diagnostic, ...]:
    """What a state of rest does not say about joints that rub."""
    return tuple(
        _told(point, joint, _RANGE, where="one" if sticks else "an end")
        for joint, sticks in _resting(point)
    )


def told_of_modes(point: Point) -> tuple[Diagnostic, ...]:
    """What a linear model does not say about joints that rub."""
    takes = {
        True: "lets nothing move it",
        False: "takes its friction for that of sliding one way, which neither holds nor damps",
    }
    return tuple(
        _told(point, joint, _LINEAR, takes=takes[sticks]) for joint, sticks in _resting(point)
    )


def _resting(point: Point) -> list[tuple[str, bool]]:
    """The joints that rub and do not move, with whether they stick."""
    from planarc.solve.contact.touches import Touches

    touches = Touches(point.program, point.kernel)
    if not touches.bound.any() or not touches.evaluate(point.t, point.y.tolist()):
        return []
    mechanism = point.program.mechanism
    joints = {j.name for j in mechanism.joints} if mechanism else set()  # and no belts
    slip, way, mu = (touches.get(name) for name in ("slip", "way", "mu"))
    rest = touches.bound & (mu > 0) & (way != _FREE) & (np.abs(slip) <= CREEP)
    named = [(owner(touches.all[i].name), bool(way[i] == _STICKS)) for i in np.flatnonzero(rest)]
    return [(joint, sticks) for joint, sticks in named if joint in joints]


def _told(point: Point, joint: str, texts: tuple[str, str], **said: str) -> Diagnostic:
    message, hint = texts
    part = own_part(point.program, joint)
    return Diagnostic(
        "R475",
        message.format(joint=f"`{joint}`", **said),
        part.span if part else None,
        Severity.WARNING,
        hint=hint,
    )
