"""Contacts that are twice there: between the same two frames, with the same contours.

In:   Dae
Out:  warnings S323, at the second one

Example: `belt2`, whose `frame_a` was copied from `belt1` and is on the same carton.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.evaluate.declared import DeclaredValues
from planarc.ir.dae import Dae
from planarc.ir.flat import Part
from planarc.ir.places import declared_part

_CONTACTS = "PlanarMultiBody.Contacts."
_CONTOURS = ("contour1", "contour2")


def doubled_contacts(dae: Dae) -> Iterator[Diagnostic]:
    contacts = [p for p in dae.parts if p.class_name.startswith(_CONTACTS)]
    if len(contacts) < 2:
        return
    classes = {p.name: p.class_name for p in dae.parts}
    point = {n: k for k, names in enumerate(dae.connections) for n in names}
    shapes: dict[str, list[str]] = {}  # of each contact: the parameters of its contours
    for p in dae.parameters:
        part, _, rest = p.name.partition(".contour")
        if rest:
            shapes.setdefault(part, []).append(p.name.removeprefix(f"{part}."))
    value = DeclaredValues(dae)
    first: dict[object, Part] = {}
    for contact in contacts:
        name, ends = contact.name, (f"{contact.name}.frame_a", f"{contact.name}.frame_b")
        own = declared_part(dae, name)
        if name not in shapes or own is None or not {*ends} <= point.keys():
            continue
        numbers = value.named(*(f"{name}.{n}" for n in shapes[name]))
        if numbers is None:
            continue
        contours = tuple(classes.get(f"{name}.{contour}") for contour in _CONTOURS)
        sizes = tuple(zip(shapes[name], numbers, strict=True))
        key = (*(point[e] for e in ends), *contours, sizes)
        other = first.setdefault(key, contact)
        if other is not contact:
            yield Diagnostic(
                "S323",
                f"`{name}` changes nothing: `{other.name}` is the same contact between the same "
                "two frames",
                own.span,
                Severity.WARNING,
                hint=f"connect `{name}` to what else is to touch there, or leave it out",
                related=(Related("the other one", other.span),),
            )
