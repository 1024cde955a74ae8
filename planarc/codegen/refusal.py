"""What both back ends refuse."""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error


def not_differentiable(function: str) -> PlanarcError:
    """A derivative of an external function is asked for, which only its author could tell."""
    return error(
        "G401",
        f"the external function `{function}` cannot be differentiated",
        hint="call it in a when-clause, or with arguments that change at events only",
    )
