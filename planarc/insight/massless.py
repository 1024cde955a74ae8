"""Links without mass whose motion nothing determines.

In:   Dae, Mechanism, the unknowns that nothing determines
Out:  the error S303 about such a link; None where each has a mass, or none is loose

What stores or loses energy, but no kinetic energy, has no mass, nor have sensors and joints;
whatever else has derivatives in its equations has.

Example: the angle of the point between a spring and a damper in series, `spring.frame_b.phi`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.prose import be, both, listed, shortened
from planarc.insight.attachment import find_floating, hang, open_apart, place, replacing
from planarc.insight.connectors import FRAME, owner
from planarc.insight.idle import find_elements
from planarc.insight.sensors import find_sensors
from planarc.insight.topology import find_derived, find_moving
from planarc.ir.dae import Dae
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import own_names

_SHOWN = 4


def find_massless(
    dae: Dae, mechanism: Mechanism, undetermined: Collection[str]
) -> Diagnostic | None:
    """The error about the joints and forces around the first such link."""
    for link in _loose_links(dae, mechanism, undetermined):
        what = shortened([f"`{n}`" for n in link.open], _SHOWN)
        if link.moved:
            what = f"how `{link.moved[0]}` moves"
        if link.moved and not link.rigid and len(link.around) == 1:
            return _unloaded(dae, mechanism, link.moved[0], link.frames)
        return _told(dae, link.rigid, link.around, what)
    return None


def find_hung(dae: Dae, mechanism: Mechanism, undetermined: Collection[str]) -> Diagnostic | None:
    """The error about bodies that hang on nothing but a sensor, which such a link lacks."""
    links = _loose_links(dae, mechanism, undetermined)
    for group in find_floating(dae, mechanism) if links else ():
        link = next((i for i in links if {*group.instead}.intersection(i.frames)), None)
        if link is None:
            continue
        names = list(dict.fromkeys(c.partition(".")[0] for c in group.components))
        move = "moves" if len(link.moved) == 1 else "move"
        joints = listed(f"`{name}`" for name in link.moved)
        behind = f": nothing that {joints} {move} has a mass" if joints else ""
        return Diagnostic(
            "S303",
            f"{hang(names, group)}{behind}",
            place(dae, group.sensors[0].partition(".")[0]),
            hint=replacing(group),
        )
    return None


class _Loose(Data):
    """A link without mass whose motion nothing determines."""

    frames: tuple[str, ...]
    moved: tuple[str, ...]  # joints on it whose motion is open
    open: tuple[str, ...]  # unknowns of its frames that are
    rigid: list[str]  # components with two frames of it
    around: list[str]  # joints, and forces with one


def _loose_links(dae: Dae, mechanism: Mechanism, undetermined: Collection[str]) -> list[_Loose]:
    # Open forces say that something is held twice, and nothing of masses.
    frames = [f for link in mechanism.links for f in link.frames]
    places = {f"{f}.{v}" for f in frames for _, v in FRAME}
    derived = find_derived(dae)
    moves = [n for n in undetermined if n in places or n in derived]
    loose = {owner(name) for name in moves}
    sensors = find_sensors(dae, frames).keys()
    weightless = {*sensors, *find_elements(dae), *(j.name for j in mechanism.joints)}
    heavy = find_moving(dae) - weightless
    found = []
    for number, link in enumerate(mechanism.links):
        ends = Counter(owner(f) for f in link.frames if owner(f) not in sensors)
        joints = [j.name for j in mechanism.joints if number in j.links]
        moved = tuple(j for j in joints if j in loose)
        if number == GROUND or not heavy.isdisjoint(ends):
            continue
        if moved or not loose.isdisjoint(link.frames):
            bare = [c for c, count in ends.items() if c not in joints and count > 1]
            # A joint inside of a part stands for that part.
            inside = {o for o in ends if any(j.startswith(f"{o}.") for j in joints)}
            around = own_names(dae, (c for c in ends if c not in bare and c not in inside))
            ours = tuple(n for n in moves if owner(n) in link.frames)
            found.append(_Loose(link.frames, moved, ours, own_names(dae, bare), around))
    return found


def _unloaded(dae: Dae, mechanism: Mechanism, joint: str, frames: Sequence[str]) -> Diagnostic:
    """The message about a joint that moves nothing."""
    end = next(f for f in frames if owner(f) == joint)
    load = open_apart(dae, mechanism)
    return Diagnostic(
        "S303",
        f"nothing that `{joint}` moves has a mass, so that nothing determines how it moves",
        place(dae, joint.partition(".")[0]),
        hint=f"connect `{end}` to {f'`{load}`' if load else 'a body with mass'}",
    )


def _told(dae: Dae, rigid: Sequence[str], around: Sequence[str], what: str) -> Diagnostic | None:
    """The message about the rigid parts of a link, and what is around it: joints and forces."""
    shown = listed([f"`{n}`" for n in rigid[:_SHOWN]])
    hint = "put a body with mass there, or leave one of them out"
    if rigid:
        hint = f"give `{rigid[0]}` a mass, or connect a body with mass to it"
    if len(around) > 1:
        between = f"between {both(around)}"
        message = f"{shown} {between} {be(len(rigid))} without mass" if rigid else ""
        message = message or f"nothing with mass is {between}"
    elif rigid and around:
        message = f"nothing that `{around[0]}` moves has a mass: {shown} {be(len(rigid))} without"
    else:
        return None
    last = (around or rigid)[-1].partition(".")[0]
    return Diagnostic(
        "S303", f"{message}, so that nothing determines {what}", place(dae, last), hint=hint
    )
