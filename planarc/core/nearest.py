"""Names near to a misspelt one: one measure, one cut-off and one wording for all messages."""

from __future__ import annotations

from collections.abc import Iterable

from planarc.core.prose import either

MOST = 3  # names in a hint
CUTOFF = 0.6  # share of letters that two names have in common, in their order


def nearest(name: str, known: Iterable[str], most: int = MOST, cutoff: float = CUTOFF) -> list[str]:
    """The names most like `name`, best first; else those that differ in capitals only."""
    from difflib import get_close_matches

    names = list(dict.fromkeys(known))
    lower = name.lower()
    near = get_close_matches(name, names, most, cutoff)
    return near or [n for n in names if n.lower() == lower][:most]


def did_you_mean(name: str, known: Iterable[str], most: int = MOST) -> str | None:
    """The hint that names what a user may have meant; None where nothing is near."""
    return meant(nearest(name, known, most))


def meant(names: Iterable[str]) -> str | None:
    found = either(names)
    return f"did you mean {found}?" if found else None
