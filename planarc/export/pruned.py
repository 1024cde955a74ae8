"""What nothing calls is left out of an exported model.

In:   text of LLVM, names that are called from elsewhere
Out:  the text with the functions alone that these reach

Code that all models share serves those with loops, events and contacts; most need some of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_FUNCTION = re.compile(r"(?:; [^\n]*\n)?^define [^@]*@(\w+)\(.*?^}\n?", re.MULTILINE | re.DOTALL)
_NAME = re.compile(r"@(\w+)")


def prune(text: str, wanted: Iterable[str]) -> str:
    """The text without functions that are not wanted, neither by themselves nor by others."""
    calls = {f[1]: _NAME.findall(f[0]) for f in _FUNCTION.finditer(text)}
    found, todo = set(), list(wanted)
    while todo:
        name = todo.pop()
        if name in calls and name not in found:
            found.add(name)
            todo += calls[name]
    return _FUNCTION.sub(lambda f: f[0] if f[1] in found else "", text)


def calls_in(text: str) -> set[str]:
    """The functions that those of a text call."""
    return {name for f in _FUNCTION.finditer(text) for name in _NAME.findall(f[0])}
