"""States that a run was to begin with, and that stay below the errors which its steps may make.

In:   the rows of a run, the states and their absolute tolerances
Out:  a warning R458, where there is one

What is small by itself, since nothing excites it, is no reason for a word; a start value that is
given and not zero says that its size is meant.

Example: a mass on a spring that swings by a nanometre, at the tolerance 1e-6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import listed
from planarc.ir.places import declaration
from planarc.ir.program import CandidateSlot, Program

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Multiple of its absolute tolerance below which a state is told: runs err by several percent of
#: it, and by more where they are long.
FAINT = 10.0
#: States that are named, at most.
_MOST = 3
#: The finest tolerance that is proposed.
_FINEST = 1e-13


def judge_faint(
    program: Program,
    states: Mapping[int, float],
    parameters: Sequence[float],
    stored: Mapping[int, int],
    data: Vector,
) -> list[Diagnostic]:
    """`states` are indices of candidates, each with its absolute tolerance; `parameters` the
    workspace."""
    faint: list[tuple[CandidateSlot, float, float]] = []
    for index, absolute in states.items():
        c = program.candidates[index]
        if c.slot not in stored or not c.start_written or parameters[c.start] == 0:
            continue
        peak = float(abs(data[:, stored[c.slot]]).max(initial=0.0))
        if 0 < peak < FAINT * absolute:
            faint.append((c, peak, absolute))
    if not faint:
        return []
    first, peak, absolute = faint[0]
    names = listed([f"`{c.display}`" for c, *_ in faint[:_MOST]])
    others = f" and {len(faint) - _MOST} more" if len(faint) > _MOST else ""
    stay = "stays" if len(faint) == 1 else "stay"
    most = max(p for _, p, _ in faint)
    size, finer = f"`{first.start_name}(nominal={peak:.1g})`", 1e-4 * peak
    lower = f", or lower `--tolerance` to {finer:.0g}" if finer >= _FINEST else ""
    told = Diagnostic(
        "R458",
        f"{names}{others} {stay} below {most:.2g} in this run, where each step may err by "
        f"{absolute:.2g}: the values say little",
        declaration(program, first.start_name, first.span),
        Severity.WARNING,
        hint=f"tell its size, as {size}{lower}",
    )
    return [told]
