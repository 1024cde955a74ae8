"""Contacts that pull, of joints whose `inContact` tells it to the model.

In:   Result
Out:  notes R455, at the user's part

A joint holds two curves together whatever the force is, and with `detectSeparation` no assertion
says that real ones would part. A run that ends there is what `inContact` is for.

Example: a valve spring that is shorter than the room it is built into.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.once import once
from planarc.ir.places import declared_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: The share of a run's time through which a contact may pull without a word.
_SOME = 0.01


def judge_pulling(result: Result) -> Iterator[Diagnostic]:
    joints = telling_joints(result.program)
    if not joints:
        return
    import numpy as np

    steps = np.diff(result.time)
    if len(steps) < 2 or not steps.any():
        return
    for name in joints:
        part = declared_part(result.program, name)
        pulls = np.broadcast_to(result[f"{name}.f_N"] < 0, result.time.shape)
        share = steps[pulls[1:] & pulls[:-1]].sum() / steps.sum()
        if part is not None and share > _SOME:
            first = result.time[int(np.argmax(pulls))]
            yield Diagnostic(
                "R455",
                f"the contact of `{name}` pulls for {share:.0%} of the run, at first at "
                f"t = {first:.4g} s: `inContact` tells it, and the joint holds on all the same",
                part.span,
                Severity.NOTE,
                hint="press harder, as by a spring that is longer without load, or take "
                "`Contacts.CurveCurveContact`, whose curves may part",
            )


@once
def telling_joints(program: Program) -> tuple[str, ...]:
    """The components with both `inContact` and `f_N`."""
    names = {c.name for c in program.columns}
    told = (n.rpartition(".")[0] for n in names if n.endswith(".inContact"))
    return tuple(sorted(n for n in told if f"{n}.f_N" in names))
