"""A name that is not there, with the nearest ones that are."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from planarc.core.diagnostic import Diagnostic, UsageError


class UnknownName(UsageError, KeyError):
    """There is no such parameter or variable; the hint names the nearest ones."""


def unknown_name(kind: str, name: object, known: Iterable[str], code: str = "C201") -> UnknownName:
    names = list(known)
    if not isinstance(name, str):
        return UnknownName(
            Diagnostic(code, f"the name of a {kind} is a text, not {type(name).__name__}")
        )
    near = get_close_matches(name, names, n=3, cutoff=0.6)
    hint = f"did you mean {' or '.join(f'`{n}`' for n in near)}?" if near else None
    if hint is None and 0 < len(names) <= 8:
        hint = f"choose among {', '.join(f'`{n}`' for n in names)}"
    return UnknownName(Diagnostic(code, f"there is no {kind} `{name}`", hint=hint))
