"""Rows that lie too far apart to show how something moves.

In:   Result
Out:  a note R456, at the user's part that goes to and fro fastest

The rows of a motion that turns round more often than they show look like another, slower one, or
like noise. Its angular frequency is sqrt(mean a^2/mean v^2), which does not depend on which rows
there are; and between rows the speeds at their ends do not lead from one place to the next.

Example: 600 s of a pendulum that swings in 1.5 s, in 500 rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity, Sparse
from planarc.ir.once import once
from planarc.ir.places import own_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: Runs of fewer rows are to show where they end, and none of which the integrator made so few steps
#: a row goes to and fro between its rows.
_ROWS, _STEPS = 50, 5
#: Rows in a period that show a motion, in which it is known again, and that are offered.
_SHOWING, _PLENTY = 3.0, 20.0
#: The part of a way that the speeds at its ends may leave open.
_OPEN = 0.35
#: What moves by less, as a part of where it is, rests: what is left of its speed is rounding.
_RESTS = 1e-12


def judge_sparse(result: Result) -> Iterator[Diagnostic]:
    rows = len(result.time)
    if rows < _ROWS or (result.statistics.steps or 0) < _STEPS * rows:
        return
    import numpy as np

    steps = np.diff(result.time)
    there = steps > 0
    h = steps[there]
    if not len(h):
        return
    found: list[tuple[float, str]] = []
    for name, place, speed, acceleration in _motions(result.program):
        if not {place, speed, acceleration}.issubset(result.stored):
            continue
        q, v, a = (np.asarray(result.of_slot(s)) for s in (place, speed, acceleration))
        way, expected = np.diff(q)[there], (0.5 * (v[1:] + v[:-1]))[there] * h
        size = float(np.sqrt(np.mean(v**2)))
        missed = float(np.sqrt(np.mean((way - expected) ** 2)))
        moves = float(np.ptp(q)) > _RESTS * max(1.0, float(np.abs(q).max()))
        if moves and size > 0 and a.any() and missed > _OPEN * size * float(h.mean()):
            period = 2 * math.pi * size / float(np.sqrt(np.mean(a**2)))
            found.append((period, name))
    if not found:
        return
    period, name = min(found)
    part = own_part(result.program, name.rpartition(".")[0])
    apart = float(np.median(h))
    if part is not None and period < _SHOWING * apart:
        yield Sparse(
            "R456",
            f"the rows lie {apart:.4g} s apart, and `{name}` goes to and fro about every "
            f"{period:.2g} s: they do not show how it moves",
            part.span,
            Severity.NOTE,
            hint=f"ask for more rows, as by `--interval {period / _PLENTY:.2g}`, or for a shorter "
            "run",
        )


@once
def _motions(program: Program) -> tuple[tuple[str, int, int, int], ...]:
    """The places of joints and bodies, with their slots, and those of speeds and accelerations."""
    derivative = {c.slot: c.derivative for c in program.candidates}
    return tuple(
        (c.display, c.slot, c.derivative, derivative[c.derivative])
        for c in program.candidates
        if c.derivative in derivative
    )
