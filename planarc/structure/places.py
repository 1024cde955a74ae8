"""The place to which a message about a variable points: into the user's model."""

from __future__ import annotations

from planarc.core.source import NOWHERE, Span
from planarc.ir.dae import Dae
from planarc.ir.places import own_part, owner


def owner_span(dae: Dae, name: str) -> Span | None:
    """The declaration of the user's component that holds a variable, or of the variable."""
    part = own_part(dae, owner(name))
    if part is not None:
        return part.span
    top = name.partition(".")[0] if "." in name else ""
    spans = [p.span for p in dae.parts if p.name == top]
    spans += [v.span for v in dae.variables if v.name == name]
    return next((s for s in spans if s is not NOWHERE), None)
