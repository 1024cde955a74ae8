"""The texts of LLVM that an export writes, as data.

In:   texts of `export.module`
Out:  Listing   functions with their instructions, constants

Only what `codegen.native.assembly` writes is understood. A branch names its targets, and a value
that hangs on the way it was reached (`phi`) is set at the ends of those ways instead.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from planarc.core.data import Data

_HEAD = re.compile(r"define (\S+) @(\w+)\((.*?)\)")
_CONSTANT = re.compile(r"@(\w+) = constant \[\d+ x (i64|i8)\] (.*)")
_PHI = re.compile(r"phi (\S+) (.*)")
_WAY = re.compile(r"\[ (\S+), %(\w+) \]")
_REGISTER = re.compile(r"%\w+")


class Line(Data):
    """A label, or an instruction and the register that it sets."""

    text: str
    target: str = ""
    label: str = ""

    def uses(self) -> list[str]:
        """The registers that are read, with those that are read twice."""
        return _REGISTER.findall(re.sub(r"label %\w+", "", self.text))


class Function(Data):
    """`told` is what its source says of it."""

    name: str
    result: str
    arguments: tuple[tuple[str, str], ...]
    lines: tuple[Line, ...]
    told: str = ""

    def calls(self) -> set[str]:
        """Names of functions and constants."""
        return {name for line in self.lines for name in re.findall(r"@([\w.]+)", line.text)}


class Listing(Data):
    """`numbers` are tables, `strings` are messages."""

    functions: dict[str, Function]
    numbers: dict[str, tuple[int, ...]]
    strings: dict[str, str]


def read(texts: Iterable[str]) -> Listing:
    """All modules together."""
    functions: dict[str, Function] = {}
    numbers: dict[str, tuple[int, ...]] = {}
    strings: dict[str, str] = {}
    told: list[str] = []
    for line in (rows := iter(line for text in texts for line in text.splitlines())):
        if line.startswith("define "):
            found = _function(line, rows, " ".join(told))
            functions[found.name] = found
        elif match := _CONSTANT.match(line):
            name, kind, value = match.groups()
            if kind == "i64":
                numbers[name] = tuple(map(int, re.findall(r"i64 (-?\d+)", value)))
            else:
                strings[name] = _bytes(value[2:-1])[:-1].decode()
        told = [*told, line[1:].strip()] if line.startswith(";") else []
    return Listing(functions, numbers, strings)


def _bytes(text: str) -> bytes:
    parts = re.findall(r"\\([0-9A-F]{2})|(.)", text)
    return bytes(int(code, 16) if code else ord(sign) for code, sign in parts)


def _function(head: str, rows: Iterator[str], told: str) -> Function:
    match = _HEAD.match(head)
    assert match is not None, head
    result, name, listed = match.groups()
    arguments = tuple(
        (kind, register) for kind, register in (a.split() for a in listed.split(", ") if a)
    )
    lines: list[Line] = []
    for row in rows:
        text = re.sub(r"%(?=\d)", "%v", row.strip())  # C's names begin with letters
        if text == "}":
            break
        if text.endswith(":"):
            lines.append(Line("", label=text[:-1]))
        elif match := re.match(r"(%\w+) = (.*)", text):
            lines.append(Line(match[2], target=match[1]))
        elif text:
            lines.append(Line(text))
    if lines and lines[0].label == "entry":
        lines = lines[1:]
    return Function(name, result, arguments, tuple(_without_phis(lines)), told)


def _without_phis(lines: list[Line]) -> list[Line]:
    """Set what a `phi` chooses at the ends of the blocks that lead to it."""
    sets: dict[str, list[Line]] = {}
    for line in lines:
        if match := _PHI.match(line.text):
            for value, block in _WAY.findall(match[2]):
                sets.setdefault(block, []).append(Line(f"set {match[1]} {value}", line.target))
    if not sets:
        return lines
    found: list[Line] = []
    block = "entry"
    for line in lines:
        block = line.label or block
        if line.text.startswith(("br ", "ret ")):
            found += sets.get(block, ())
        if not _PHI.match(line.text):
            found.append(line)
    return found
