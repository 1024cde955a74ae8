"""Parts that stand side by side: what is wrong in any of them is told at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.refusal import joined

Part = TypeVar("Part")
Result = TypeVar("Result")


def for_each(parts: Iterable[Part], do: Callable[[Part], Result]) -> list[Result]:
    """`do` of every part. Raises one PlanarcError with the diagnostics of all that fail."""
    found: list[Result] = []
    wrong: list[PlanarcError] = []
    for part in parts:
        try:
            found.append(do(part))
        except PlanarcError as problem:
            wrong.append(problem)
    if wrong:
        raise joined(wrong)
    return found
