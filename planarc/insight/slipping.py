"""Driven wheels whose contact has no friction: they spin, and nothing goes along.

In:   Dae, Mechanism
Out:  warnings S323

A wheel is a circle about the pin of the only joint of what it is on. A round cam is not about its
pin, and a disc on a body of its own is driven by nothing.

Example: `Contact contact(redeclare Circle contour1(R=0.3))` of a cart's driven wheel, without `mu`.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.insight.connectors import find_pins
from planarc.ir.dae import Dae
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import own_part

_CONTACT = "PlanarMultiBody.Contacts.Contact"
_SIDES = ("a", "b")


def slipping_wheels(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    contacts = [p for p in dae.parts if p.class_name == _CONTACT]
    if not contacts:
        return
    numbers = {p.name: p.value.data for p in dae.parameters if p.value.is_const}
    smooth = [p.name for p in contacts if numbers.get(f"{p.name}.mu") == 0]
    rough = [p.name for p in contacts if p.name not in smooth]
    names = {v.name for v in dae.variables}
    pins = find_pins(dae, mechanism) if smooth else set()
    for link, joint in _turning(mechanism):
        if joint not in pins or joint in mechanism.passive or f"{joint}.axis.phi" not in names:
            continue
        frames = set(mechanism.links[link].frames)
        if any(f"{c}.frame_{side}" in frames for c in rough for side in _SIDES):
            continue
        ends = {f"{joint}.frame_{side}" for side in _SIDES}
        at_pin = {n for joined in dae.connections if ends & {*joined} for n in joined}
        for contact in smooth:
            part = own_part(dae, contact)
            for number, side in enumerate(_SIDES, start=1):
                frame, circle = f"{contact}.frame_{side}", f"{contact}.contour{number}"
                centred = all(numbers.get(f"{circle}.r[{i}]") == 0 for i in (1, 2))
                round_one = f"{circle}.R" in numbers and centred
                if part is not None and round_one and frame in frames & at_pin:
                    yield Diagnostic(
                        "S323",
                        f"`{joint}` makes its wheel spin, and moves nothing: `{contact}` has no "
                        "friction, mu = 0",
                        part.span,
                        Severity.WARNING,
                        hint=f"write `{part.name}(mu=...)`, such as 0.5",
                    )


def _turning(mechanism: Mechanism) -> Iterator[tuple[int, str]]:
    """The moving links that one joint alone holds, each with it."""
    for number, _ in enumerate(mechanism.links):
        joints = [joint.name for joint in mechanism.joints if number in joint.links]
        if number != GROUND and len(joints) == 1:
            yield number, joints[0]
