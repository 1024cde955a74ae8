"""Names near to a misspelt one: one measure, one cut-off and one wording for all messages."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from planarc.core.mend import Meant

MOST = 3  # names in a hint
CUTOFF = 0.6  # share of letters that two names have in common, in their order


def nearest(name: str, known: Iterable[str], most: int = MOST, cutoff: float = CUTOFF) -> list[str]:
    """The names most like `name`, best first; else those that differ in capitals only."""
    from difflib import get_close_matches

    names = list(dict.fromkeys(known))
    lower = name.lower()
    near = get_close_matches(name, names, most, cutoff)
    return near or [n for n in names if n.lower() == lower][:most]


@cache
def _words() -> dict[str, list[str]]:
    """Words of the field, in small letters, and names that libraries give to the same thing."""
    lines = Path(__file__).with_name("synonyms.txt").read_text("utf-8").splitlines()
    return {word: names.split() for word, _, names in (line.partition(": ") for line in lines)}


def synonyms(name: str, known: Iterable[str]) -> list[str]:
    """Known names that say the same in the field's words: `hinge.w` for `hinge.omega`."""
    names = set(known)
    head, dot, last = name.rpartition(".")
    return [m for w in in_other_words(last) if (m := head + dot + w) in names]


def in_other_words(name: str) -> list[str]:
    """The names that libraries give to what a word of the field says."""
    word = name.lower()
    return _words().get(word) or _words().get(word.replace("_", ""), [])


def did_you_mean(name: str, known: Iterable[str], most: int = MOST) -> Meant | None:
    """What a user may have meant; None where nothing is near."""
    names = list(known)
    ending = [n for n in names if n.endswith((f"_{name}", f".{name}"))]  # `frame_b` for `b`
    ending.sort(key=lambda n: n.count("."))  # `world.g` for `g`: the outermost first
    found = (synonyms(name, names) or ending)[:most] or nearest(name, names, most)
    return Meant(name, tuple(found)) if found else None
