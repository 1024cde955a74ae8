"""Conditions of when-clauses that are true at the start and stay so: the clauses never act.

In:   Program, the kernel after the start and after each event
Out:  a warning R449 for the first clause of the user's own

Example: `when hinge.phi < 1 then` with `phi(start=0.5)`, of a pendulum that never reaches 1.
"""

from __future__ import annotations

import re

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.places import is_own
from planarc.ir.program import Program, WhenCode
from planarc.solve.events.whens import edge_conditions, initial_conditions


class AlreadyTrue:
    """The clauses whose condition has been true since the start."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self._program, self._kernel = program, kernel
        self._waiting: list[tuple[int, WhenCode]] = []

    def begin(self) -> None:
        w = self._kernel.w
        self._waiting = [pair for pair in _own_clauses(self._program) if w[pair[0]] != 0]

    def note(self) -> None:
        """After an event: what is false now may become true."""
        if self._waiting:
            w = self._kernel.w
            self._waiting = [pair for pair in self._waiting if w[pair[0]] != 0]

    def judge(self) -> tuple[Diagnostic, ...]:
        """The warning at the end of a run."""
        if not self._waiting:
            return ()
        _, when = self._waiting[0]
        found = re.match(r"when\s+(.*?)\s+then\b", when.span.text, re.S)
        condition = " ".join(found[1].split()) if found else "its condition"
        return (
            Diagnostic(
                "R449",
                f"`when {condition}` never acts: that is true at the start already, and stays true",
                when.span,
                Severity.WARNING,
                hint="a `when` acts at the instant at which its condition becomes true: turn the "
                f"relation round, or write `when {{initial(), {condition}}}` to act at the start",
            ),
        )


@once
def _own_clauses(program: Program) -> tuple[tuple[int, WhenCode], ...]:
    """The user's own clauses with the slots of their first conditions, but for those that the start
    or a clock makes true."""
    if not program.whens:
        return ()
    others = initial_conditions(program) | edge_conditions(program)
    own = (when for when in program.whens if is_own(program, when.span))
    return tuple((w.branches[0][0], w) for w in own if w.branches[0][0] not in others)
