"""Texts without their quotes where a String is expected: read as a name that nothing has.

In:   PlanarcError, Span   the error of an expression, and its place
Out:  PlanarcError         the same, or one with the hint to write quotes

Example: `unit=N.m` looks for a class `N`, and `fileName = data.csv` for a component `data`.
"""

from __future__ import annotations

import re

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError
from planarc.core.mend import Meant, Write
from planarc.core.source import Span


def meant_as_text(problem: PlanarcError, span: Span | None) -> PlanarcError:
    """The error of an unknown name, which may be meant as a text; any other one as it is."""
    first = next(iter(problem.diagnostics), None)
    written = quoted(span)
    if first is None or written is None or any(d.code != "F210" for d in problem.diagnostics):
        return problem
    if isinstance(first.mend, Meant) or not _plain(first.message):
        return problem  # it is almost the name of something, or has quotes of its own
    hint = f"a text stands in double quotes: write {written}"
    return PlanarcError(replace(first, span=span, hint=hint, mend=Write(written.strip("`"))))


def _plain(message: str) -> bool:
    return "`'" not in message


def quoted(span: Span | None) -> str | None:
    """What is written, in quotes, where it is a name, a path of names or the like."""
    text = span.text if span else ""
    return f'`"{text}"`' if re.fullmatch(r"[\w.\-/* ^]{1,60}", text) else None
