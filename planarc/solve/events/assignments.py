"""Assignments of a when-clause's branch, as one piece of code where there are many to do.

In:   the actions of a branch, and the reader of the workspace
Out:  slots set, and the first action that has no value, if any

An array that is set at an index that varies is as many assignments as it has elements, of
which each pass of every event does all: code for the whole branch does them some fifty times
as fast as its expressions one by one, and is made once it pays.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct

from planarc.evaluate.tape import Assigning, prepare_assignments
from planarc.ir.dae import Action, SetDiscrete
from planarc.ir.expr import Expr
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.solve.messages.text import OFTEN, Reader


class Branch(Struct):
    """The assignments of a branch."""

    actions: tuple[SetDiscrete, ...]
    targets: tuple[int, ...]  # the slots that they set
    others: tuple[Action, ...]  # what the branch does beside
    done: int = 0  # assignments done so far, until there is code
    code: Assigning | None = None


class Assignments:
    """The assignments of a run's branches."""

    def __init__(self, program: Program, kernel: Kernel, reader: Reader) -> None:
        self._w, self._read = kernel.w, reader
        self._branches = _branches(program)

    def do(self, actions: Sequence[Action], kept: dict[int, int]) -> SetDiscrete | None:
        """Assign, and take what is assigned out of `kept`; gives an action without value."""
        branch = self._branches[id(actions)]
        branch.done += len(branch.actions)
        if branch.code is None and branch.done > OFTEN:
            branch.code = prepare_assignments(_pairs(branch), self._read.slot)
        if branch.code is not None:
            failed = branch.code(self._w, self._read.t)
        else:
            failed = self._one_by_one(branch)
        if failed >= 0:
            return branch.actions[failed]
        for slot in branch.targets:
            kept.pop(slot, None)
        return None

    def others(self, actions: Sequence[Action]) -> tuple[Action, ...]:
        """The actions of a branch that are no assignments."""
        return self._branches[id(actions)].others

    def _one_by_one(self, branch: Branch) -> int:
        for i, (slot, value) in enumerate(_pairs(branch)):
            try:
                self._w[slot] = float(self._read(value))
            except (ArithmeticError, ValueError):
                return i
        return -1


def _pairs(branch: Branch) -> list[tuple[int, Expr]]:
    return [(slot, a.value) for slot, a in zip(branch.targets, branch.actions, strict=True)]


@once
def _branches(program: Program) -> dict[int, Branch]:
    """The branches of a program by identity: it keeps them."""
    found = {}
    for when in program.whens:
        for *_, actions in when.branches:
            set_ = tuple(a for a in actions if isinstance(a, SetDiscrete))
            targets = tuple(program.slots[a.name] for a in set_)
            others = tuple(a for a in actions if not isinstance(a, SetDiscrete))
            found[id(actions)] = Branch(set_, targets, others)
    return found
