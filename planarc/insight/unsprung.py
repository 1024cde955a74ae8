"""Bodies on a slide along which nothing acts, in a mechanism with springs: one of these was mostly
connected elsewhere.

In:   Dae, Mechanism
Out:  notes S323

Example: a chassis on its guide, of which the strut's upper end was connected to the ground.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.insight.connectors import find_pins, owner
from planarc.insight.idle import find_elements
from planarc.insight.sensors import find_sensors
from planarc.insight.topology import find_moving
from planarc.ir.dae import Dae
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import own_part

_SLIDE = 2  # conditions of a slide, as of a pin


def unsprung_bodies(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    frames = [f for link in mechanism.links for f in link.frames]
    owners = [owner(f) for f in frames]
    springs = {c for c in find_elements(dae) if owners.count(c) == 2}
    if not springs:
        return
    pins = find_pins(dae, mechanism)
    weightless = {*find_sensors(dae, frames), *springs, *(j.name for j in mechanism.joints)}
    heavy = find_moving(dae) - weightless
    flanged = {owner(v.name).rpartition(".")[0] for v in dae.variables if ".axis." in v.name}
    for number, link in enumerate(mechanism.links):
        joints = [j for j in mechanism.joints if number in j.links]
        parts = {owner(f) for f in link.frames}
        masses = parts & heavy
        if number == GROUND or len(joints) != 1 or not masses:
            continue
        slide = joints[0]
        if slide.conditions != _SLIDE or slide.name in pins or slide.name in flanged:
            continue
        body, guide = own_part(dae, sorted(masses)[0]), own_part(dae, slide.name)
        if body is None or guide is None or not parts <= {*masses, slide.name}:
            continue
        yield Diagnostic(
            "S323",
            f"nothing but its weight acts on `{body.name}` along `{guide.name}`",
            body.span,
            Severity.NOTE,
            hint=f"connect a spring, a stop or a drive to `{body.name}`, unless it is to slide "
            "freely",
        )
