"""Drives whose torque reacts twice on one body: at their hinge, and where they are mounted.

In:   Dae, Mechanism
Out:  warnings S328, at the mounting

From the axis of a hinge the drive is followed through all that turns or carries torque, up to a
`Mounting1D` in which one of its housings is fixed. Where that is on the body at frame_a of this
very hinge, which reacts there (`driveReacts`), the sum of both is no reaction of anything.

Example: a motor between `base` and the axis of the hinge at `base`, its support mounted on `base`:
a torque of 1 N.m on the load takes 2 N.m from the base.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.evaluate.declared import DeclaredValues
from planarc.insight.connectors import owner
from planarc.ir.dae import Dae
from planarc.ir.flat import Part
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import own_part

_LIBRARY = "PlanarMultiBody."
_HINGES = (f"{_LIBRARY}Joints.Revolute", f"{_LIBRARY}Joints.RevoluteWithFriction")
_MOUNTING, _ROTOR = f"{_LIBRARY}Parts.Mounting1D", f"{_LIBRARY}Parts.Rotor1D"
_ROTATIONAL = "Modelica.Mechanics.Rotational."
_FIXED = f"{_ROTATIONAL}Components.Fixed"


def twice_reacting_drives(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    mountings = [p for p in dae.parts if p.class_name == _MOUNTING]
    hinges = [p for p in dae.parts if p.class_name in _HINGES]
    if not mountings or not hinges:
        return
    link_of = {f: i for i, link in enumerate(mechanism.links) for f in link.frames}
    value, told = DeclaredValues(dae), set()
    for hinge in hinges:
        link = link_of.get(f"{hinge.name}.frame_a", GROUND)
        here = {f"{m.name}.flange_b": m for m in mountings if _on(m, link, link_of)}
        if not here or value.named(f"{hinge.name}.driveReacts") == [0.0]:
            continue
        flanges = _reached(dae, f"{hinge.name}.axis")
        found = next((here[f] for f in flanges if f in here), None)
        if found is not None and found.name not in told:
            told.add(found.name)
            turning = {p.name for p in dae.parts if p.class_name == _ROTOR}
            yield _told(dae, hinge, found, not turning.isdisjoint(map(owner, flanges)))


def _on(mounting: Part, link: int, link_of: Mapping[str, int]) -> bool:
    return link != GROUND and link_of.get(f"{mounting.name}.frame_a") == link


def _reached(dae: Dae, axis: str) -> list[str]:
    """The flanges of a drive from the axis that it turns, and those on which it is fixed."""
    classes = {p.name: p.class_name for p in dae.parts}
    at = {name: names for names in dae.connections for name in names}
    flanges: dict[str, list[str]] = {}
    for name in at:
        if _passes(classes.get(owner(name), "")):
            flanges.setdefault(owner(name), []).append(name)
    fixed, seen, front = [], {axis}, [axis]
    for flange in front:
        names: Sequence[str] = at.get(flange, ())
        mounts = [n for n in names if classes.get(owner(n)) == _MOUNTING]
        fixed += mounts
        if mounts:
            continue  # another drive may be fixed there
        beside = [other for name in names for other in flanges.get(owner(name), ())]
        front += (new := [n for n in dict.fromkeys(beside) if n not in seen])
        seen.update(new)
    return front + fixed


def _passes(class_name: str) -> bool:
    """Whether a torque at one flange of such a component is one at its others."""
    return class_name == _ROTOR or (class_name.startswith(_ROTATIONAL) and class_name != _FIXED)


def _told(dae: Dae, hinge: Part, mounting: Part, rotors: bool) -> Diagnostic:
    part, own = own_part(dae, mounting.name), own_part(dae, hinge.name)
    hint = f"leave `{mounting.name}` out, and its supports in the ground"
    if hinge.class_name == _HINGES[0]:
        mounted = f"mount all housings of the drive, and set `{hinge.name}(driveReacts=false)`"
        hint = mounted if rotors else f"{mounted}; or {hint}"
    return Diagnostic(
        "S328",
        f"the drive of `{hinge.name}` reacts twice on one body: at `{hinge.name}.frame_a`, and "
        f"through `{mounting.name}`",
        part.span if part else mounting.span,
        Severity.WARNING,
        hint=hint,
        related=() if own is None else (Related("the hinge", own.span),),
    )
