"""What a model does not need is left out when it is exported.

In:   text of LLVM, names that are called from elsewhere
Out:  the text with the functions alone that these reach

Code that all models share serves those with loops, events and contacts; most need some of it. What
a model has none of (`without`) is a 0 or, of places, -1 in its table: told as a constant, LLVM
leaves out what is done about it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

#: Numbers of a table that tell that there is none.
NONE = (0, -1)
FUNCTION = re.compile(r"(?:; [^\n]*\n)?^define [^@]*@(\w+)\((?:[^\n]*\n)+?}\n?", re.MULTILINE)
_NAME = re.compile(r"@(\w+)")
_ELSEWHERE = re.compile(r"^(?:declare [^@]*)?@(p[cx]_\w+)(?:\(| = external )", re.MULTILINE)
_LOADED = (
    r"(%\w+) = getelementptr inbounds i64, ptr @{}, i64 (\d+)\n"
    r"\s*(%\w+) = load i64, ptr \1, align 8$"
)


def prune(text: str, wanted: Iterable[str]) -> str:
    """The text without functions that are not wanted, neither by themselves nor by others."""
    calls = {f[1]: _NAME.findall(f[0]) for f in FUNCTION.finditer(text)}
    found, todo = set(), list(wanted)
    while todo:
        name = todo.pop()
        if name in calls and name not in found:
            found.add(name)
            todo += calls[name]
    return FUNCTION.sub(lambda f: f[0] if f[1] in found else "", text)


def calls_in(text: str) -> set[str]:
    """The functions that those of a text call."""
    return {name for f in FUNCTION.finditer(text) for name in _NAME.findall(f[0])}


def asked_in(text: str) -> set[str]:
    """The functions of planarc, and the constants, that a text has from elsewhere and mentions."""
    return set(_ELSEWHERE.findall(text)) & calls_in(text)


def without(text: str, table: str, none: Mapping[int, int]) -> str:
    """The text, where places of a `table` tell what there is none of."""

    def told(found: re.Match[str]) -> str:
        number = none.get(int(found[2]))
        return found[0] if number is None else f"{found[3]} = add i64 {number}, 0"

    return re.sub(_LOADED.format(table), told, text, flags=re.MULTILINE)


def numbers_of(text: str, table: str) -> list[int]:
    """The numbers of a table."""
    found = re.search(rf"^@{table} = .*\[(.*)\]$", text, re.MULTILINE)
    assert found is not None, f"no table `{table}`"
    return [int(n) for n in re.findall(r"i64 (-?\d+)", found[1])]
