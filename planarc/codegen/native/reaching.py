"""How far a step of an integrator may move a loop.

A loop can be closed in several ways, and Newton's method takes one that is near. So a step must not
move its angles farther than to the next way: a shaft whose speed is given tells an integrator
nothing of the loop that it drives, whose steps would grow without end.

Example: a crank of 0.1 m and a rod of 0.4 m, with 6 rad/s. In steps of 1 s the piston is now on one
side of the crank, now on the other.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value
from planarc.ir.frame import Frame
from planarc.ir.march import REACH


def give_where_far(
    c: Code, frame: Value, angles: Value, value: Value | int = 1, type: str = FLAG
) -> None:
    """Give a value where a loop has moved too far since the last accepted point; `angles` as
    `Frame.ANGLES`."""
    w, accepted = frame.load(POINTER, Frame.W), frame.load(POINTER, Frame.ACCEPTED)
    with c.loop(angles.load(INT)) as i:
        pair = angles.at(i * 2)
        now = w.load(REAL, pair.load(INT, 1))
        before = accepted.load(REAL, pair.load(INT, 2))
        with c.when(c.absolute(now - before) > REACH, leaves=True):
            c.give(value, type)
