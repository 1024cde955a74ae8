"""Loops of three hinges in a mechanism that moves: nothing in them can turn.

In:   Dae, Mechanism
Out:  warnings S322

Three links that are joined by three hinges are one rigid triangle. It is told where one of them is
put together of two bars, since mostly one of these was to stand on the other side of a joint. Of
one bar each they are a truss, which may be meant. Where nothing moves at all, `attachment` tells.

Example: a four-bar whose ground link was connected to the moving side of the crank's bearing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.prose import both, listed
from planarc.insight.attachment import place
from planarc.insight.connectors import find_pins, owner, triangles
from planarc.ir.dae import Dae
from planarc.ir.mechanism import GROUND, Joint, Link, Mechanism
from planarc.ir.places import declared_part, is_own

#: The hinges of a triangle. Where there are no more, nothing moves.
_THREE = 3


def rigid_triangles(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    pins = find_pins(dae, mechanism)
    plain = [j for j in mechanism.joints if j.name in pins and len(j.links) == 2]
    for three in triangles(plain) if len(plain) > _THREE else ():
        links = {number for joint in three for number in joint.links}
        for number in sorted(links - {GROUND}):
            near = [joint for joint in three if number in joint.links]
            bars = [_bar_at(dae, joint, mechanism.links[number]) for joint in near]
            where = _common(dae, bars)
            if where:
                yield _told(dae, three, bars, where)
                return


def _bar_at(dae: Dae, joint: Joint, link: Link) -> str:
    """The bar that carries a joint on a link: the part beside it with another end."""
    for names in dae.connections:
        if not {*joint.frames}.isdisjoint(names) and not {*link.frames}.isdisjoint(names):
            for bar in (owner(n) for n in names if n in link.frames):
                if sum(owner(f) == bar for f in link.frames) > 1 and declared_part(dae, bar):
                    return bar
    return ""


def _common(dae: Dae, bars: Sequence[str]) -> tuple[str, ...]:
    """The frames of two bars that are connected to each other without a joint; none of one bar."""
    if len({*bars}) < 2 or "" in bars:
        return ()
    for names in dae.connections:
        there = tuple(n for n in names if owner(n) in bars)
        if len({owner(n) for n in there}) == 2:
            return there
    return ()


def _told(
    dae: Dae, three: Sequence[Joint], bars: Sequence[str], where: Collection[str]
) -> Diagnostic:
    names = [f"`{joint.name}`" for joint in three]
    own = (c for c in dae.connects if is_own(dae, c.span))
    here = (c for c in own if not {c.left, c.right}.isdisjoint(where))
    related = [Related(f"{both(bars)} are joined here", c.span) for c in here][-1:]
    return Diagnostic(
        "S322",
        f"{listed(names)} cannot turn: their loop is a rigid triangle, of which {both(bars)} are "
        "one side",
        place(dae, three[0].name),
        Severity.WARNING,
        hint="connect one of the two to another part, such as the ground, or put a joint between "
        "them, unless a structure is meant",
        related=tuple(related),
    )
