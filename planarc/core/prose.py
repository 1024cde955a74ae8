"""Lists and counts as messages word them.

Example: `listed(["a", "b", "c"])` is "a, b and c", `ticked(["a", "b"])` is "`a`, `b`",
`shortened(names, 3)` is "a, b, c and 5 more", `counted(2, "alias")` is "2 aliases",
`sized([(3,), (2, 3)])` is "the sizes 3 and 2 by 3".
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def ticked(names: Iterable[str], joint: str = ", ") -> str:
    """Names in backticks with a comma, or other words, between them."""
    return joint.join(f"`{n}`" for n in names)


def either(names: Iterable[str]) -> str:
    return ticked(names, " or ")


def both(names: Iterable[str]) -> str:
    return ticked(names, " and ")


def listed(parts: Iterable[str], last: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`; nothing where there are none."""
    *first, end = list(parts) or [""]
    return f"{', '.join(first)} {last} {end}" if first else end


def shortened(parts: Sequence[str], most: int) -> str:
    """All parts, or the first `most` and the number of the others."""
    more = len(parts) - most
    return ", ".join(parts[:most]) + (f" and {more} more" if more > 0 else "")


def counted(number: int, noun: str) -> str:
    """`1 equation`, `2 equations`, `2 aliases`."""
    return f"{number} {noun}" if number == 1 else f"{number} {plural(noun)}"


def sized(shapes: Iterable[Sequence[int | None]]) -> str:
    """`the size 3`, `the sizes 3 and 2 by any`: of arrays, by their dimensions."""
    texts = [" by ".join("any" if n is None else str(n) for n in shape) for shape in shapes]
    return f"the {'size' if len(texts) == 1 else 'sizes'} {listed(texts)}"


def plural(noun: str) -> str:
    if noun.endswith("y") and noun[-2:-1] not in "aeiou":
        return f"{noun[:-1]}ies"
    return noun + ("es" if noun.endswith("s") else "s")


def be(number: int) -> str:
    """The verb that a number of things needs."""
    return "is" if number == 1 else "are"
