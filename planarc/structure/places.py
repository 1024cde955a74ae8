"""The place to which a message about a variable points: into the user's model."""

from __future__ import annotations

from planarc.core.source import NOWHERE, Span
from planarc.ir.dae import Dae


def owner_span(dae: Dae, name: str) -> Span | None:
    """The declaration of the component that holds a variable, or of the variable."""
    for length in range(1, name.count(".") + 1):
        prefix = ".".join(name.split(".")[:length])
        for part in dae.parts:
            if part.name == prefix and part.span is not NOWHERE:
                return part.span
    found = next((v.span for v in dae.variables if v.name == name), NOWHERE)
    return None if found is NOWHERE else found
