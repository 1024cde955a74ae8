"""Sources of signals that begin after the end of a run, or have hardly begun by then: mostly their
times were meant in milliseconds.

In:   Result
Out:  warnings and notes R453, at the user's part

Example: `Ramp(duration=1000)` in a run of 3 s, which ends at 0.3 % of its way.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.once import once
from planarc.ir.places import declared_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: Share of its duration after which a source has hardly begun.
_HARDLY = 0.01
#: Multiple of the end of a run at which the second point of a table is far away.
_FAR = 10.0

_MILLISECONDS = "times are in s: 1 ms is 1e-3 s"


class _Source(Data):
    """A source with the slots of its times."""

    name: str
    start: int
    duration: int | None
    second: int | None  # time of the second point of a table


def judge_late(result: Result) -> Iterator[Diagnostic]:
    """The notes about sources that give one value all the while."""
    if len(result.time) < 2 or result.ended is not None:
        return
    end = float(result.time[-1])
    for source in timed_sources(result.program):
        told, part = _late(source, result), declared_part(result.program, source.name)
        if told is not None and part is not None:
            what, hint, severity = told
            yield Diagnostic(
                "R453",
                f"`{source.name}` hardly changes: it {what}, and the run ends at {end:g} s",
                part.span,
                severity,
                hint=hint,
            )


def _late(source: _Source, result: Result) -> tuple[str, str, Severity] | None:
    """What of its times lies beyond the run, with what to do; nothing if none does. A source that
    begins later may be switched off by that, so that it has a note alone."""
    begin, end, known = float(result.time[0]), float(result.time[-1]), result.constants
    start = known[source.start]
    if start >= end > begin:
        later = f"let the run end later, as by `--stop {2 * start - begin:g}`"
        hint = _MILLISECONDS if start >= _FAR * end else later
        return f"begins at {start:g} s", hint, Severity.NOTE
    if source.duration is not None:
        duration = known[source.duration]
        if end - max(start, begin) < _HARDLY * duration:
            return f"takes {duration:g} s", _MILLISECONDS, Severity.WARNING
    if source.second is not None:
        second = known[source.second]
        if second >= _FAR * end > 0:
            hint = "times are in s: write `timeScale=1e-3` for a table in ms"
            return f"has its second point at {second:g} s", hint, Severity.WARNING
    return None


@once
def timed_sources(program: Program) -> tuple[_Source, ...]:
    slots = {p.name: p.slot for p in program.parameter_slots}
    found = []
    for name, start in slots.items():
        owner, _, last = name.rpartition(".")
        if last == "startTime" and declared_part(program, owner):  # and not a block inside of it
            duration, second = slots.get(f"{owner}.duration"), slots.get(f"{owner}.table[2,1]")
            found.append(_Source(owner, start, duration, second))
    return tuple(found)
