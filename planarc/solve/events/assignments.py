"""Assignments of a when-clause's branch, as one piece of code where there are many to do.

In:   the actions of a branch, and the reader of the workspace
Out:  slots set, and the first action that has no value, if any

An array that is set at an index that varies is as many assignments as it has elements, of
which each pass of every event does all: code for the whole branch does them some fifty times
as fast as a walk through its expressions, and is made once it pays. Passes of one instant mostly
read the same values: then what they set is put back as it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from msgspec import Struct

from planarc.evaluate.tape import Assigning, prepare_assignments
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Action, SetDiscrete
from planarc.ir.expr import Expr, Op
from planarc.ir.kernel import FEW, Kernel
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.solve.messages.text import OFTEN, Reader


class Branch(Struct):
    """The assignments of a branch."""

    actions: tuple[SetDiscrete, ...]
    targets: tuple[int, ...]  # the slots that they set
    others: tuple[Action, ...]  # what the branch does beside
    passes: int = 0  # so far, until there is code
    code: Assigning | None = None


class _Last(Struct):
    """What a branch did last: where its values stand, those that it read, and those that it set."""

    read: Any
    set_: Any
    seen: tuple[float, bytes] | None = None
    values: Any = None


class Assignments:
    """The assignments of a run's branches."""

    def __init__(self, program: Program, kernel: Kernel, reader: Reader) -> None:
        self._w: Any = kernel.w
        self._read = reader
        self._branches = _branches(program)
        self._last: dict[int, _Last] = {}

    def do(self, actions: Sequence[Action]) -> SetDiscrete | None:
        """Assign; gives an action without value."""
        branch = self._branches[id(actions)]
        branch.passes += 1
        if branch.code is None and branch.passes > OFTEN:
            branch.code = prepare_assignments(_pairs(branch), self._read.slot)
        if branch.code is not None:
            failed = self._by_code(branch, branch.code)
        else:
            failed = self._one_by_one(branch)
        return branch.actions[failed] if failed >= 0 else None

    def targets(self, actions: Sequence[Action]) -> tuple[int, ...]:
        """The slots that a branch sets."""
        return self._branches[id(actions)].targets

    def others(self, actions: Sequence[Action]) -> tuple[Action, ...]:
        """The actions of a branch that are no assignments."""
        return self._branches[id(actions)].others

    def _by_code(self, branch: Branch, code: Assigning) -> int:
        w, t = self._w, self._read.t
        if len(branch.targets) <= FEW or isinstance(w, list):
            return code(w, t)
        last = self._last.get(id(branch))
        if last is None:
            import numpy as np

            read, set_ = (np.array([*s], np.intp) for s in (code.reads, branch.targets))
            last = self._last[id(branch)] = _Last(read, set_)
        seen = t, w.take(last.read).tobytes()
        if seen == last.seen:
            w[last.set_] = last.values
            return -1
        failed = code(w, t)
        if failed < 0:
            last.seen, last.values = seen, w.take(last.set_)
        return failed

    def _one_by_one(self, branch: Branch) -> int:
        values: dict[Expr, Any] = {}  # of expressions, as long as nothing that they read is set
        read: set[int] = set()

        def leaf(e: Expr) -> float:
            if e.op is not Op.TIME:
                read.add(self._read.slot(e))
            return self._read.leaf(e)

        for i, (slot, value) in enumerate(_pairs(branch)):
            try:
                self._w[slot] = float(evaluate(value, leaf, values=values))
            except (ArithmeticError, ValueError):
                return i
            if slot in read:
                values.clear()
                read.clear()
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
