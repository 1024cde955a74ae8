"""Parts of the language that planarc does not have: refused by name, never ignored."""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span


def unsupported(feature: str, section: str, span: Span | None) -> PlanarcError:
    """The diagnostic for a feature, with the section of the specification that defines it."""
    return error(
        "F299",
        f"planarc does not support {feature} (Modelica specification, section {section})",
        span,
    )
