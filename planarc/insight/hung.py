"""Loads at the near end of a bar, on its axis, where their mass moves nothing.

In:   Dae, Mechanism
Out:  warnings S323

A bar with mass turns about a hinge on the ground, its far end carries nothing, and a small heavy
body is connected to its near end. A flywheel there has a radius of gyration of some size beside the
bar's length, and is none.

Example: `connect(shank.frame_a, foot.frame_a)` where `shank.frame_b` was meant.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.evaluate.declared import DeclaredValues
from planarc.insight.connectors import find_frames, find_pins, owner
from planarc.ir.dae import Dae
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import is_own, own_part

#: A load's radius of gyration, at most, as part of the bar's length.
_SMALL = 0.2


def loads_on_axes(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    found = find_frames(v.name for v in dae.variables)
    frames = [f for f in found if (p := own_part(dae, owner(f))) and p.name == owner(f)]
    pins = find_pins(dae, mechanism)
    for joint in mechanism.joints:
        if joint.name not in pins or GROUND not in joint.links:
            continue
        for near in (names for names in dae.connections if {*joint.frames} & {*names}):
            beside = [n for n in near if n in frames and owner(n) != joint.name]
            bars = [(n, far) for n in beside if (far := _far_end(dae, n, frames))]
            loads = [n for n in beside if sum(owner(f) == owner(n) for f in frames) == 1]
            if len(beside) == 2 and len(bars) == len(loads) == 1:
                yield from _told(dae, joint.name, bars[0], loads[0])


def _far_end(dae: Dae, frame: str, frames: Sequence[str]) -> str | None:
    """The other end of a bar, where nothing but its own insides is connected to it."""
    part = owner(frame)
    others = [f for f in frames if owner(f) == part and f != frame]
    if len(others) != 1:
        return None
    joined = (n for names in dae.connections if others[0] in names for n in names)
    return others[0] if all(n.startswith(f"{part}.") for n in joined) else None


def _told(dae: Dae, joint: str, bar: tuple[str, str], load: str) -> Iterator[Diagnostic]:
    rod, body = owner(bar[0]), owner(load)
    names = [f"{rod}.r[1]", f"{rod}.r[2]", f"{rod}.m"]
    names += [f"{body}.r_CM[1]", f"{body}.r_CM[2]", f"{body}.m", f"{body}.I"]
    given = {p.name: p.value for p in dae.parameters if p.name in names}
    here = [c for c in dae.connects if load in (c.left, c.right) and is_own(dae, c.span)]
    if len(given) < len(names) or not here:
        return
    value = DeclaredValues(dae)
    try:
        x, y, mass, *centre, m, inertia = (value(given[n]) for n in names)
    except (KeyError, ArithmeticError, ValueError):  # as of a function that the user wrote
        return
    about_axis = inertia + m * (centre[0] ** 2 + centre[1] ** 2)
    if mass > 0 and m > 0 and about_axis < m * (_SMALL**2 * (x**2 + y**2)):
        yield Diagnostic(
            "S323",
            f"`{body}` moves nothing by its mass: it is on the axis of `{joint}`, and `{bar[1]}` "
            "carries nothing",
            here[0].span,
            Severity.WARNING,
            hint=f"write `connect({bar[1]}, {load});`, if it hangs there",
        )
