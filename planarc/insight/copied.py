"""Rods whose far end is open, where the far end of one like it has two connections: one of these
was copied, and not all of it was changed.

In:   Dae, Mechanism
Out:  warnings S323, at the later of the two connections

Example: `connect(strutR.frame_b, toFront.frame_b)` beside the same of `strutF`, where `toRear` was
meant, which begins at the chassis as `toFront` does.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.insight.connectors import owner
from planarc.ir.dae import Dae
from planarc.ir.mechanism import Mechanism
from planarc.ir.places import is_own

_BEGIN, _END = "frame_a", "frame_b"


def copied_connections(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    connected = {n for names in dae.connections if len(names) > 1 for n in names}
    classes = {p.name: p.class_name for p in dae.parts}
    begins = {n: k for k, names in enumerate(dae.connections) for n in names}
    joints = {joint.name for joint in mechanism.joints}
    frames = {f for link in mechanism.links for f in link.frames}
    rods = [
        name
        for name in classes
        if {f"{name}.{_BEGIN}", f"{name}.{_END}"} <= frames and name not in joints
    ]
    for rod in (r for r in rods if f"{r}.{_END}" not in connected):
        begin = begins.get(f"{rod}.{_BEGIN}")
        for other in rods:
            alike = classes[other] == classes[rod] and begins.get(f"{other}.{_BEGIN}") == begin
            if begin is None or other == rod or not alike:
                continue
            end = f"{other}.{_END}"
            here = [c for c in dae.connects if end in (c.left, c.right) and is_own(dae, c.span)]
            far = [c.left if c.right == end else c.right for c in here]
            if len(here) != 2 or classes.get(owner(far[0])) != classes.get(owner(far[1])):
                continue
            yield Diagnostic(
                "S323",
                f"nothing is connected to `{rod}.{_END}`, and both `{far[0]}` and `{far[1]}` are "
                f"to `{end}`",
                here[1].span,
                Severity.WARNING,
                hint=f"connect one of them to `{rod}.{_END}`",
                related=(Related("the other one", here[0].span),),
            )
            break
