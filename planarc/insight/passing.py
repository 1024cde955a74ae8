"""Springs whose ends pass through each other.

In:   Result
Out:  a warning R447, at the user's part

Steps and rows may go past the instant at which the two ends of a spring coincide: beyond it, the
spring pulls the other way. Components declare the vector between such ends by
`annotation(__planarc(line = d))`. A spring whose length without load is written as 0 is meant to
draw its ends together: its force is as smooth there as anywhere.

Example: 320 kg on 20 N/m, which was to be 20 N/mm.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.once import once
from planarc.ir.places import own_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: Ends pass through each other where the way between two rows leads past zero within this part of
#: it, and is that of the rows before, to this part.
_NEAR, _STRAIGHT = 0.02, 0.5
_MEANT = r"\bs_unstretched\s*=\s*0(\.0*)?\s*[,)]"


def judge_passing(result: Result) -> Iterator[Diagnostic]:
    """The warning about the first such spring."""
    lines = declared_lines(result.program)
    if not lines or len(result.time) < 3:
        return
    for component, d in lines:
        part = own_part(result.program, component)
        if part is None or re.search(_MEANT, part.span.text):
            continue
        if (t := _passes(result, d)) is not None:
            hint = "look at its stiffness (in N/m: 1 N/mm is 1e3 N/m) and at its length without "
            hint += "load, or put stops where its ends meet"
            free = result.columns.get(f"{component}.s_unstretched")
            if free is not None and result.constants.get(free.slot) == 0:
                hint = "its length without load is 0, so that it draws its ends together: give "
                hint += f"`{part.name}.s_unstretched`"
            yield Diagnostic(
                "R447",
                f"the ends of `{part.name}` pass through each other at t = {t:.4g} s, and it pulls "
                "the other way from there on",
                part.span,
                Severity.WARNING,
                hint=hint,
            )
            return


def _passes(result: Result, slots: tuple[int, int]) -> float | None:
    """The first time at which the way of a vector leads past zero."""
    import numpy as np

    rows = np.array([np.broadcast_to(result.of_slot(s), result.time.shape) for s in slots]).T
    time, way = result.time, np.diff(rows, axis=0)
    begin, before, h = rows[1:-1], way[:-1], np.diff(time)
    step = way[1:]
    turned = (begin * rows[2:]).sum(axis=1) < 0
    if not turned.any():
        return None
    with np.errstate(all="ignore"):
        length = (step**2).sum(axis=1)
        part = -(begin * step).sum(axis=1) / length
        least = np.hypot(*(begin + part[:, None] * step).T)
        expected = before * (h[1:] / h[:-1])[:, None]
        straight = np.hypot(*(step - expected).T) < _STRAIGHT * np.sqrt(length)
        found = np.flatnonzero(turned & straight & (least < _NEAR * np.sqrt(length)))
    if not len(found):
        return None
    i = int(found[0])
    return float(time[i + 1] + part[i] * h[i + 1])


@once
def declared_lines(program: Program) -> tuple[tuple[str, tuple[int, int]], ...]:
    """The components that declare a vector between their ends, and the slots of this."""
    slots = {c.name: c.slot for c in program.columns}
    found = []
    for d in program.declared:
        if d.kind == "line" and isinstance(d.value, tuple):
            x, y = (slots.get(repr(e), -1) for e in d.value)
            if x >= 0 and y >= 0:
                found.append((d.component, (x, y)))
    return tuple(found)
