"""Lengths of a loop that cannot be assembled, which may be mistaken.

In:   Program, how far the bars of the loop reach, in m by name; the joint whose start is given
Out:  a note, or a hint; nothing where lengths say nothing

Example: a crank of 0.14 m and a rod of 0.045 m to a slide, which were exchanged: the crank cannot
go round, wherever it starts.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from planarc.core.diagnostic import Related
from planarc.core.prose import listed
from planarc.ir.mechanism import GROUND
from planarc.ir.places import own_part, owner
from planarc.ir.program import Program
from planarc.solve.messages.loops import loop_joints

#: A bar that is shorter by so many times than the next one of its loop may be a slip.
_SHORT = 3.0


def much_shorter(
    program: Program, lengths: Mapping[str, float], turned: str, gap: float
) -> tuple[Related, ...]:
    """The note about a bar that is much shorter than all others of its loop, and than the `gap` in
    it; and no crank, which the joint that is `turned` carries."""
    shortest, *others = sorted(lengths, key=lambda name: lengths[name]) or [""]
    if len(others) < 2 or lengths[shortest] > min(gap, lengths[others[0]] / _SHORT):
        return ()
    part = own_part(program, shortest)
    if part is None or _carries(program, turned, shortest):
        return ()
    told = listed(f"`{name}` {lengths[name]:.4g} m" for name in others)
    message = f"`{shortest}` is {lengths[shortest]:.4g} m long, and {told}: is it too short?"
    return (Related(message, part.span),)


def longer_crank(
    program: Program, components: Collection[str], lengths: Mapping[str, float], turned: str
) -> str:
    """What to do about a crank that is longer than the rod between it and a slide on the ground, as
    the beginning of a hint; else nothing."""
    joints = {j.name: j for j in loop_joints(program, components)}
    columns = {c.name for c in program.columns}
    slides = [name for name in joints if f"{name}.s" in columns]
    if len(joints) != 4 or len(slides) != 1 or len(lengths) != 2 or turned not in joints:
        return ""
    if any(GROUND not in joints[name].links for name in (turned, *slides)):
        return ""
    crank, rod = sorted(lengths, key=lambda name: not _carries(program, turned, name))
    if not _carries(program, turned, crank) or lengths[crank] <= lengths[rod]:
        return ""
    return (
        f"`{crank}` ({lengths[crank]:.4g} m) is longer than `{rod}` ({lengths[rod]:.4g} m) and "
        "cannot go round: exchange their lengths; or "
    )


def _carries(program: Program, joint: str, bar: str) -> bool:
    """Whether a bar is on one of a joint's links."""
    mechanism = program.mechanism
    found = next((j for j in mechanism.joints if j.name == joint), None) if mechanism else None
    links = [mechanism.links[i] for i in found.links] if mechanism and found else []
    return any(owner(frame) == bar for link in links for frame in link.frames)
