"""Loads that hang where their mass moves nothing.

In:   Dae, Mechanism
Out:  warnings S323

on the ground   A joint on the ground moves nothing but further joints, and a body is connected to
                its standing side: `connect(rail.frame_a, cart.frame_a)` where `rail.frame_b` was
                meant.
on an axis      A bar with mass turns about a hinge on the ground, its far end carries nothing, and
                a small heavy body is connected to its near end: `connect(shank.frame_a,
                foot.frame_a)` where `shank.frame_b` was meant. A flywheel there has a radius of
                gyration of some size beside the bar's length, and is none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.evaluate.declared import DeclaredValues
from planarc.insight.connectors import find_frames, find_pins, owner
from planarc.insight.massless import loaded_links
from planarc.ir.dae import Dae
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import declared_part, is_own

#: A load's radius of gyration, at most, as part of the bar's length.
_SMALL = 0.2


def loads_on_ground(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    frames = Counter(owner(f) for link in mechanism.links for f in link.frames)
    masses = {p.name for p in dae.parameters if p.name.endswith(".m")}
    standing = mechanism.links[GROUND].frames
    loads = {f for f in standing if frames[owner(f)] == 1 and f"{owner(f)}.m" in masses}
    if not loads:
        return
    on_ground = {j.name: j.frames for j in mechanism.joints if GROUND in j.links}
    links = [i for i in loaded_links(dae, mechanism) if not i.heavy and len(i.joints) > 1]
    bare = [(link, j) for link in links for j in link.joints if j in on_ground]
    own = [c for c in dae.connects if is_own(dae, c.span)]
    used = Counter(n for c in own for n in (c.left, c.right))
    for c in own if bare else ():
        load = next((n for n in (c.left, c.right) if n in loads), "")
        if not load or used[load] > 1:
            continue
        there = [(i, j) for i, j in bare if {c.left, c.right}.intersection(on_ground[j])]
        link, joint = (there or bare)[0]
        far = next(f for f in on_ground[joint] if f in link.frames)
        yield Diagnostic(
            "S323",
            f"`{owner(load)}` moves nothing by its mass: it is fastened to the ground, and nothing "
            f"that `{joint}` itself carries has a mass",
            c.span,
            Severity.WARNING if there else Severity.NOTE,
            hint=f"write `connect({far}, {load});`, if it moves along",
        )


def loads_on_axes(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    found = find_frames(v.name for v in dae.variables)
    frames = [f for f in found if declared_part(dae, owner(f))]
    count = Counter(map(owner, frames))
    pins = find_pins(dae, mechanism)
    on_ground = [j for j in mechanism.joints if j.name in pins and GROUND in j.links]
    held = {frame: j.name for j in on_ground for frame in j.frames}
    for near in dae.connections:
        joints = [*dict.fromkeys(held[n] for n in near if n in held)]
        beside = [n for n in near if owner(n) in count and owner(n) not in joints]
        loads = [n for n in beside if count[owner(n)] == 1]
        if len(joints) != 1 or len(beside) != 2 or len(loads) != 1:
            continue
        (bar,) = (n for n in beside if n not in loads)
        far = _far_end(dae, bar, frames)
        if far is not None:
            yield from _told(dae, joints[0], (bar, far), loads[0])


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
    of_load = (f"{body}.{n}" for n in ("r_CM[1]", "r_CM[2]", "m", "I"))
    numbers = DeclaredValues(dae).named(f"{rod}.r[1]", f"{rod}.r[2]", f"{rod}.m", *of_load)
    here = [c for c in dae.connects if load in (c.left, c.right) and is_own(dae, c.span)]
    if numbers is None or not here:
        return
    x, y, mass, *centre, m, inertia = numbers
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
