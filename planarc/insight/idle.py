"""Parts that change nothing of a mechanism, though a user put them there.

In:   Dae, Mechanism
Out:  warnings S323

    both ends together   a spring whose ends are connected to each other
    free beside a joint  a part that only gives coordinates, as `FreeMotion`, between links that
                         joints hold together; with start values of its own it is no idle one
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import both, shortened
from planarc.insight.connectors import grouped, owner
from planarc.ir.dae import Dae
from planarc.ir.flat import StateSelect
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import own_part

_FLOWS = ("f[1]", "f[2]", "t")
_SHOWN = 3


def idle_parts(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    link_of = {f: i for i, link in enumerate(mechanism.links) for f in link.frames}
    yield from _ends_together(dae, link_of)
    yield from _free_beside_joints(dae, mechanism, link_of)


def _ends_together(dae: Dae, frames: Mapping[str, int]) -> Iterator[Diagnostic]:
    for names in dae.connections:
        for component, ends in grouped((n for n in names if n in frames), owner).items():
            part = own_part(dae, component)
            if len(ends) > 1 and part is not None and part.name == component:
                yield Diagnostic(
                    "S323",
                    f"both ends of `{component}` are connected to each other: {both(ends)}",
                    part.span,
                    Severity.WARNING,
                    hint="connect one of them to another part",
                )


def _free_beside_joints(
    dae: Dae, mechanism: Mechanism, link_of: Mapping[str, int]
) -> Iterator[Diagnostic]:
    wanted = {v.component for v in dae.variables if v.state_select >= StateSelect.PREFER}
    wanted -= {v.component for v in dae.variables if v.start_written}
    wanted -= {joint.name for joint in mechanism.joints}
    ends_of = grouped((f for f in link_of if owner(f) in wanted), owner)
    if not ends_of:
        return
    zero = {e.left.name for e in dae.equations if e.right is dae.table.zero and e.left.is_symbol}
    joined = DisjointSets(range(len(mechanism.links)))
    for joint in mechanism.joints:
        for other in joint.links[1:]:
            joined.join(joint.links[0], other)
    for component, ends in ends_of.items():
        part = own_part(dae, component)
        if (
            part is None
            or len(ends) != 2
            or any(f"{e}.{f}" not in zero for e in ends for f in _FLOWS)
        ):
            continue
        first, second = (link_of[end] for end in ends)
        if joined.join(first, second):
            continue
        moving = {first, second} - {GROUND}
        joints = [j.name for j in mechanism.joints if moving.intersection(j.links)]
        holders = shortened([f"`{name}`" for name in joints], _SHOWN) or "another part"
        yield Diagnostic(
            "S323",
            f"`{part.name}` frees nothing: {holders} says already how its ends may move",
            part.span,
            Severity.WARNING,
            hint=f"leave `{part.name}` out; or leave out the joint, if that body is to fly freely",
        )
