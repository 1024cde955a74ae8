"""Numbers and signs as a printed text has them: 1e-05 is 10⁻⁵, 3*2 is 3×2, 2 N.s is 2 N·s, -> is →.

What stands between backticks is a name or a text of the language, and stays.
"""

from __future__ import annotations

import math
import re

_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_POWER = re.compile(r"(?<![\w.])([-−]?\d+(?:\.\d+)?)e([+-]?\d+)\b")
_TIMES = re.compile(r"(?<=\d)\*(?=\d)")
_PRODUCT = re.compile(r"(?<=\d N)\.(?=[ms]\b)")  # of units
_MINUS = re.compile(r"(?<![\w.\])])-(?=\d)|(?<=\d )-(?= \d)")


def typeset(text: str) -> str:
    """A text of the program's own, with the signs of print."""
    pieces = text.split("`")
    pieces[::2] = map(_plain, pieces[::2])
    return "`".join(pieces)


def number(value: float, count: int = 4) -> str:
    """A number with so many digits."""
    if not math.isfinite(value):
        return "–"
    size = abs(value)
    if size and not 1e-3 <= size < 1e6:
        return _plain(f"{value:.{count - 1}e}")
    before = math.floor(math.log10(size)) if size else 0
    return _plain(f"{value:.{max(0, count - 1 - before)}f}")


def unit(name: str) -> str:
    """A unit: `N.m/s2` is N·m/s²."""
    if name == "1":
        return ""
    return re.sub(r"-?\d+", lambda m: m[0].translate(_RAISED), name.replace(".", "·"))


def _plain(text: str) -> str:
    text = _POWER.sub(_power, _PRODUCT.sub("·", text.replace("->", "→")))
    return _MINUS.sub("−", _TIMES.sub("×", text))


def _power(found: re.Match[str]) -> str:
    raised = f"10{str(int(found[2])).translate(_RAISED)}"
    return raised if found[1] == "1" else f"{found[1]}×{raised}"
