"""Assignments of when-clauses in LLVM: those of an array as loops.

An array that is set at an index that varies is as many assignments as it has elements:

    buf[1] := if k == 1 then u else pre(buf[1])         for t in 0, 1, ..:
    buf[2] := if k == 2 then u else pre(buf[2])   ->        buf[t] := if k == (1, 2, ..)[t] ...

Each is done in its turn and sees what those before it have set. A branch that is long even so, as
one that transforms a whole record of samples, is left to a run in Python (`long_branches`).

Reference: `solve.events.assignments`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value
from planarc.codegen.native.formulas import formula, real
from planarc.codegen.native.loops import Loops
from planarc.codegen.native.rolling import Column, Roll, is_one, operations, roll
from planarc.codegen.native.shapes import is_number
from planarc.instance.clauses import reader, slot_of
from planarc.instance.plan import Own
from planarc.instance.settling import ACTED
from planarc.ir.dae import Action, Assertion, Reinit, SetDiscrete
from planarc.ir.expr import Expr
from planarc.ir.frame import Frame
from planarc.ir.once import once
from planarc.ir.program import Let, Program, Statement

#: A branch is long that has more operations once it is rolled, or so many before.
MOST, MOST_ROLLED = 4000, 500_000


@once
def long_branches(program: Program) -> frozenset[tuple[int, int]]:
    """The branches for which code would not pay, as numbers of clauses and branches from 1 on."""
    return frozenset(
        (k, number)
        for k, when in enumerate(program.whens)
        for number, (*_, branch) in enumerate(when.branches, 1)
        if _is_long(program, branch)
    )


def _is_long(program: Program, branch: Sequence[Action]) -> bool:
    assigned = [a for a in branch if isinstance(a, SetDiscrete)]
    others = [Let(e, e) for a in branch if not isinstance(a, SetDiscrete) for e in _read(a)]
    lets, total = _lets(program, assigned), 0
    for let in (*lets, *others):
        total += operations(let)
        if total > MOST_ROLLED:
            return True
    if total <= MOST:
        return False
    written = (s.body if isinstance(s, Roll) else (s,) for s in (*_rolled(lets), *others))
    return sum(operations(s) for body in written for s in body if isinstance(s, Let)) > MOST


def _read(action: Action) -> tuple[Expr, ...]:
    if isinstance(action, SetDiscrete | Reinit):
        return (action.value,)
    return (action.condition,) if isinstance(action, Assertion) else ()


def _lets(program: Program, assignments: Iterable[SetDiscrete]) -> list[Let]:
    return [Let(program.table.symbol(a.name), a.value) for a in assignments]


def _rolled(lets: Sequence[Let]) -> Sequence[Statement | Roll]:
    return roll(lets, lambda e: 0, seldom=True)


class Assignments:
    """What a function of an instance and a time assigns."""

    def __init__(self, program: Program, c: Code) -> None:
        self._program, self._code = program, c
        self._m, self._t = c.arguments
        self._w = self._m.load(POINTER, Frame.W)
        self._leaf = reader(program, self._w, self._t)
        self._loops = Loops(c, "px_assign")

    def write(self, assignments: Mapping[int, SetDiscrete], number: Mapping[int, int]) -> None:
        """Those of a branch, by their places among all actions. What has no value ends the
        function, and says the action's number, where it has one."""
        numbers = [number.get(place, 0) for place in assignments]
        at = 0
        for s in _rolled(_lets(self._program, assignments.values())):
            if isinstance(s, Roll):
                count = len(s.statements)
                self._roll(s, numbers[at : at + count])
                at += count
            else:
                assert isinstance(s, Let)
                value = real(self._code, formula(self._code, s.value, self._leaf))
                if numbers[at]:
                    self._end(value.is_nan(), self._code.constant(numbers[at], INT))
                self._w.store(value, self._slot(s.target))
                at += 1

    def copy(self, slots: Sequence[int], sources: Sequence[int]) -> None:
        """Give slots the values of others."""
        with self._loops.run(len(slots)):
            value = self._load(sources)
            pointer, index = self._loops.at(self._w, slots)
            pointer.store(value, index)

    def text(self) -> str:
        """The constants, when all is written."""
        return self._loops.text()

    def _roll(self, run: Roll, numbers: Sequence[int]) -> None:
        c, loops, length = self._code, self._loops, len(run.body)
        with loops.run(len(run.targets[0])):
            for k, (let, target, columns) in enumerate(
                zip(run.body, run.targets, run.leaves, strict=True)
            ):
                varied = {column[0]: column for column in columns if not is_one(column)}
                value = real(c, formula(c, let.value, partial(self._due, varied), varied))
                own = numbers[k::length]
                if any(own):
                    told = loops.word(own)
                    self._end(value.is_nan() & ~told.equals(0), told)
                pointer, index = loops.at(self._w, [self._slot(e) for e in target])
                pointer.store(value, index)

    def _end(self, condition: Value, number: Value) -> None:
        with self._code.when(condition, leaves=True):
            self._m.store(number, Own.ENDED)
            self._code.give(ACTED)

    def _due(self, columns: Mapping[Expr, Column], e: Expr) -> Value:
        """A leaf in a loop: `e` the first time, then the others of its column."""
        column = columns.get(e)
        if column is None:
            return self._leaf(e)
        if is_number(e):
            return self._loops.number([n.data for n in column])
        return self._load([self._slot(other) for other in column])

    def _load(self, slots: Sequence[int]) -> Value:
        pointer, index = self._loops.at(self._w, slots)
        return pointer.load(REAL, index)

    def _slot(self, e: Expr) -> int:
        return slot_of(self._program, e)
