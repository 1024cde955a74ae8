"""Followers with a flat face that nothing guides.

In:   Dae, Mechanism
Out:  warnings S323

The only joint of a body is a contact, in which its own curve is a straight line: it tips over, and
slides off along its face.

Example: the plunger of a cam whose slide was forgotten.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.insight.connectors import owner
from planarc.insight.massless import loaded_links
from planarc.ir.dae import Dae
from planarc.ir.mechanism import Mechanism
from planarc.ir.places import declared_part

_CURVES = {"frame_a": "curve1", "frame_b": "curve2"}


def unguided_followers(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    contacts = {j.name: j for j in mechanism.joints if j.conditions == 1 and len(j.links) == 2}
    flat = {p.name for p in dae.parts if p.class_name.endswith(".StraightLine")} if contacts else {}
    for link in loaded_links(dae, mechanism) if flat else ():
        if len(link.joints) != 1 or link.joints[0] not in contacts or not link.heavy:
            continue
        (contact,) = link.joints
        (face, *_) = (f.rpartition(".")[2] for f in link.frames if owner(f) == contact)
        body = declared_part(dae, sorted(link.heavy)[0])
        if body is not None and f"{contact}.{_CURVES.get(face)}" in flat:
            yield Diagnostic(
                "S323",
                f"`{contact}` alone holds `{body.name}`, which tips over and slides off along its "
                "face",
                body.span,
                Severity.WARNING,
                hint=f"guide it: connect a slide, such as `Joints.Prismatic guide(n={{0, 1}})`, "
                f"between the ground and `{body.name}`",
            )
