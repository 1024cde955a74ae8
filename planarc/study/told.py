"""What the runs of a study warn of, told once.

In:   outcomes, as they come
Out:  a warning for each that is distinct, with the number of its runs

Warnings of one place that differ by numbers alone are one; the first point's is told. Example:
"`hinge.phi` starts at 0.2, ... (in 3 runs, first at point 1)".
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic
from planarc.core.prose import counted
from planarc.study.bundle import Outcome

_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


class Told:
    """The warnings so far."""

    def __init__(self) -> None:
        self._first: dict[object, tuple[int, Diagnostic]] = {}
        self._counts: dict[object, int] = {}

    def take(self, outcomes: Iterable[Outcome]) -> list[Outcome]:
        """Keep the warnings of outcomes, which are given back without: many hold whole texts."""
        found = []
        for o in outcomes:
            for key, warning in {_key(w): w for w in reversed(o.warnings)}.items():
                self._counts[key] = self._counts.get(key, 0) + 1
                if key not in self._first or o.index < self._first[key][0]:
                    self._first[key] = o.index, warning
            found.append(replace(o, warnings=()) if o.warnings else o)
        return found

    def warnings(self) -> tuple[Diagnostic, ...]:
        """By the points at which they come first."""
        order = sorted(self._first, key=lambda k: (self._first[k][0], self._first[k][1].message))
        return tuple(self._counted(key) for key in order)

    def _counted(self, key: object) -> Diagnostic:
        index, warning = self._first[key]
        runs = counted(self._counts[key], "run")
        where = f"first at point {index + 1}" if self._counts[key] > 1 else f"point {index + 1}"
        return replace(warning, message=f"{warning.message} (in {runs}, {where})")


def _key(warning: Diagnostic) -> object:
    """The code, the place, and the message without numbers outside of names."""
    parts = warning.message.split("`")
    words = [_NUMBER.sub("0", part) if i % 2 == 0 else part for i, part in enumerate(parts)]
    span = warning.span
    place = None if span is None else (span.source.name, span.start, span.end)
    return warning.code, place, tuple(words)
