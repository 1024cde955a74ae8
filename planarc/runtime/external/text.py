"""Functions of texts, as the standard library's `Modelica.Utilities.Strings` needs them.

Places in a text count from 1. A scan that finds nothing gives the place where it
began, so that the caller sees that it did not move.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from planarc.runtime.texts import formatted, number_of, text_of

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_INTEGER = re.compile(r"[+-]?\d+(?![\d.eE])")
_REAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_STRING = re.compile(r'"((?:[^"\\]|\\.)*)"', re.DOTALL)


def length(text: str) -> tuple[int]:
    return (len(text),)


def substring(text: str, first: int, last: int) -> tuple[str]:
    """The part from `first` to `last`, both counted from 1 and included."""
    if first < 1 or last > len(text) or first > last + 1:
        raise ValueError(f"{first} to {last} is not in a text of {len(text)} characters")
    return (text[first - 1 : last],)


def compare(left: str, right: str, case_sensitive: bool) -> tuple[int]:
    """1, 2, 3: `left` is less than, equal to, greater than `right`."""
    if not case_sensitive:
        left, right = left.lower(), right.lower()
    return (2 if left == right else 1 if left < right else 3,)


def skip_white_space(text: str, start: int) -> tuple[int]:
    """The place of the first character from `start` on that is no space."""
    place = max(start, 1)
    while place <= len(text) and text[place - 1].isspace():
        place += 1
    return (place,)


def hash_string(text: str) -> tuple[int]:
    """A. Partow's hash function for texts, as a signed integer of 32 bits."""
    found = 0xAAAAAAAA
    for i, byte in enumerate(text.encode()):
        if i % 2:
            found ^= ~((found << 11) + (byte ^ found >> 5))
        else:
            found ^= found << 7 ^ byte * (found >> 3)
        found &= 0xFFFFFFFF
    return ((found ^ 0x80000000) - 0x80000000,)


def scan_identifier(text: str, start: int) -> tuple[int, str]:
    found = _scan(_IDENTIFIER, text, start)
    return (start, "") if found is None else (found.end() + 1, found[0])


def scan_integer(text: str, start: int, unsigned: bool) -> tuple[int, int]:
    found = _scan(_INTEGER, text, start)
    if found is None or (unsigned and found[0][0] in "+-"):
        return start, 0
    return found.end() + 1, int(found[0])


def scan_real(text: str, start: int, unsigned: bool) -> tuple[int, float]:
    found = _scan(_REAL, text, start)
    if found is None or (unsigned and found[0][0] in "+-"):
        return start, 0.0
    return found.end() + 1, float(found[0])


def scan_string(text: str, start: int) -> tuple[int, str]:
    """A text in quotes, given without them."""
    found = _scan(_STRING, text, start)
    return (start, "") if found is None else (found.end() + 1, found[1])


def _scan(pattern: re.Pattern[str], text: str, start: int) -> re.Match[str] | None:
    return pattern.match(text, skip_white_space(text, start)[0] - 1)


def joined(parts: Sequence[float]) -> tuple[float]:
    """The number of the text that values give, each with the number of its format behind it."""
    pairs = zip(parts[::2], parts[1::2], strict=True)
    return (number_of("".join(formatted(value, text_of(form)) for value, form in pairs)),)


def full_path_name(name: str) -> tuple[str]:
    """The path, a relative one behind the working directory."""
    return (Path(name).absolute().as_posix(),)


def file_type(name: str) -> tuple[int]:
    """1: nothing there, 2: a file, 3: a folder, 4: something else."""
    path = Path(name)
    if path.is_file():
        return (2,)
    return (3 if path.is_dir() else 4 if path.exists() else 1,)
