"""Connections of what turns with what slides, told once for a component of the wrong kind.

In:   errors found while connections were collected
Out:  the same; those of one component in one, with the class that it was mistaken for

Example: a `Rotational.Components.SpringDamper` between a wall and a mass that slides. Both its
connections are wrong, for one reason: it should be that of `Translational`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Once, Related
from planarc.core.prose import both
from planarc.flatten.connect.sides import Side

_FIELDS = ("Rotational", "Translational")


class OtherKind(Once):
    """A connection of a shaft with a slide. `parts` are the components that it joins, `twins`
    the classes of the same name in the other field, where there are."""

    parts: tuple[str, ...] = ()
    ends: tuple[tuple[str, str], ...] = ()  # the connectors, each with its kind
    twins: tuple[str, ...] = ()


def other_kind(found: Once, sides: Sequence[Side], kinds: Sequence[str]) -> OtherKind:
    owners = [side.node.parent for side in sides]
    parts = tuple("" if o is None or not o.prefix else o.prefix for o in owners)
    twins = []
    for owner in owners:
        names = [] if owner is None else owner.cls.name.split(".")
        field = next((f for f in _FIELDS if f in names), None)
        twin = ""
        if owner is not None and field is not None:
            names[names.index(field)] = _FIELDS[1 - _FIELDS.index(field)]
            twin = ".".join(names)
            twin = twin if owner.session.library.lookup(twin) is not None else ""
        twins.append(twin)
    return OtherKind(
        found.code,
        found.message,
        found.span,
        found.severity,
        found.hint,
        found.related,
        kind=found.message,
        parts=parts,
        ends=tuple((side.name, kind) for side, kind in zip(sides, kinds, strict=True)),
        twins=tuple(twins),
    )


def told_once(errors: Sequence[Diagnostic]) -> list[Diagnostic]:
    """The errors, of several connections of one component the first with the others as notes."""
    wrong = [e for e in errors if isinstance(e, OtherKind)]
    count = Counter(part for e in wrong for part in e.parts if part)
    told: list[Diagnostic] = []
    first: dict[str, int] = {}
    for error in errors:
        part = ""
        if isinstance(error, OtherKind):
            part = max(error.parts, key=lambda p: count[p])
        if not isinstance(error, OtherKind) or count[part] < 2:
            told.append(error)
        elif part in first:
            note = Related(error.message, error.span)
            known = told[first[part]]
            told[first[part]] = replace(known, related=(*known.related, note))
        else:
            first[part] = len(told)
            twin = error.twins[error.parts.index(part)]
            hint = f"take `{twin}` for `{part}`" if twin else error.hint
            ends = dict.fromkeys(
                e.ends[e.parts.index(part)]
                for e in wrong
                if part in e.parts and e.ends[e.parts.index(part)]
            )
            if len({kind for _, kind in ends}) > 1:
                hint = f"exchange {both(name for name, _ in ends)}"
            told.append(replace(error, hint=hint))
    return told
