"""What a final parameter follows from: parameters of its class that may be set.

In:   Span of its declaration, `m=m_o - m_i`
Out:  names, `density`, `length`, ...: those of the formula, and of the formulas of its names

The class is read as text, since the error is raised before it has components.
"""

from __future__ import annotations

import re

from planarc.core.source import Span

_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\s*\()")
_CLASS = re.compile(
    r"^[ \t]*(?:partial[ \t]+)?(?:model|block|class|record)[ \t]+(\w+)", re.MULTILINE
)
_PARAMETER = re.compile(
    r"(?P<final>final\s+)?parameter\s+[\w.]+(?:\[[^\]]*\])?\s+(?P<name>\w+)"
    r"(?:\[[^\]]*\])?(?:\([^()]*\))?(?:\s*=\s*(?P<value>[^;\"]*))?"
)
_PROTECTED = re.compile(r"^[ \t]*protected\b", re.MULTILINE)


def settable(formula: str, declared: Span) -> list[str]:
    """The parameters that a formula in a class follows from and that are set where it is used, in
    the order in which they are met."""
    text = _class_around(declared)
    hidden = _PROTECTED.search(text)
    parameters = {m["name"]: m for m in _PARAMETER.finditer(text)}
    found: dict[str, bool] = {}
    waiting = [formula]
    for part in waiting:
        for name in dict.fromkeys(_NAME.findall(part)):
            known = parameters.get(name)
            if known is None or name in found:
                continue
            inside = hidden is not None and known.start() > hidden.start()
            found[name] = not known["final"] and not inside
            if not found[name]:
                waiting.append(known["value"] or "")
    return [name for name, free in found.items() if free]


def _class_around(declared: Span) -> str:
    text = declared.source.text
    begins = list(_CLASS.finditer(text, 0, declared.start))
    if not begins:
        return text
    begin = begins[-1]
    end = re.compile(rf"\bend\s+{begin[1]}\s*;").search(text, declared.end)
    return text[begin.start() : end.start() if end else len(text)]
