"""A name that is not there, with the nearest ones that are."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.core.nearest import did_you_mean
from planarc.core.prose import ticked


class UnknownName(UsageError, KeyError):
    """There is no such parameter or variable; the hint names the nearest ones."""


def unknown_name(kind: str, name: object, known: Iterable[str]) -> UnknownName:
    names = list(known)
    if not isinstance(name, str):
        return UnknownName(
            Diagnostic("C202", f"the name of a {kind} is a text, not {type(name).__name__}")
        )
    hint = did_you_mean(name, names)
    if hint is None and 0 < len(names) <= 8:
        hint = f"choose among {ticked(names)}"
    return UnknownName(Diagnostic("C201", f"there is no {kind} `{name}`", hint=hint))


def refuse_unknown(kind: str, names: Iterable[object], known: Collection[str]) -> None:
    """Raise UnknownName for the first of some names that is not there."""
    for name in names:
        if name not in known:
            raise unknown_name(kind, name, known)
