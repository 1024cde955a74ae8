"""Statements of a function of the model's module, as LLVM text.

In:   statements, and what the function's module shares
Out:  the lines of the function: straight, as loops (`rolling`), or as rows that are carried out
      (`carried`)

Of each value it is known whether it stands in a register, in the workspace, in the memory of loops
or among the results.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import chain, groupby
from typing import TYPE_CHECKING

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value
from planarc.codegen.native.formulas import formula, real
from planarc.codegen.native.loops import Loops
from planarc.codegen.native.packed import Rows
from planarc.codegen.native.rolling import Column, Roll, is_one, operations, roll, roll_gathered
from planarc.codegen.native.shapes import Shapes, is_number
from planarc.codegen.native.summing import Sums
from planarc.codegen.native.turning import is_turn, turn
from planarc.ir.expr import Expr, Op
from planarc.ir.frame import Frame, Placement
from planarc.ir.program import Let, Program, Solve, Statement

if TYPE_CHECKING:
    from planarc.codegen.native.carried import Carrier
    from planarc.codegen.native.parting import Vector

#: Lines of a basic block: LLVM's quickest way takes time with the square of its length.
LONGEST_BLOCK = 200


class Statements(ABC):
    """A function of the module, without the blocks that are solved in it."""

    def __init__(
        self, program: Program, placement: Placement, shapes: Shapes,
        reads: Callable[[], Counter[Expr]], slot: Callable[[Expr], int | None], name: str,
        results: bool = False, seldom: bool = False, small: bool = False,
        shared: Rows | None = None, carrier: Carrier | None = None, alone: Collection[str] = (),
    ) -> None:  # fmt: skip
        self._carrier = carrier
        self._tables: list[str] = []
        self._seldom, self._small, self._alone = seldom, small, alone
        self._program, self._shapes, self._reads = program, shapes, reads
        self._placement = placement
        arguments = [(POINTER, "frame"), (REAL, "t")]
        if results:
            arguments.append((POINTER, "results"))
        self._code = c = Code(name, FLAG, arguments)
        self._frame, self._time = c.arguments[:2]
        self._w = self._frame.load(POINTER, Frame.W)
        self._area = self._frame.load(POINTER, Frame.AREA)
        self._values: dict[Expr, Value] = {}
        memory = None if carrier is None else self._w.at(carrier.memory)
        self._loops = Loops(c, name, shared, memory)
        self._slot = slot
        self._next_break = LONGEST_BLOCK
        self._results: dict[Expr, int] = {}  # what is a result and nothing else
        self._out = c.arguments[-1]  # where results stand
        self._turns: dict[Expr, Value] = {}  # the memory of each angle that is turned
        #: The register whose angle it holds here, and the sine and cosine.
        self._turned: dict[Expr, tuple[str, dict[str, Value]]] = {}

    def _write(self, statements: Iterable[Statement], straight: bool = False) -> None:
        """`straight`: without loops."""
        listed = tuple(statements)
        for turned, group in groupby(listed, self._is_turned):
            self._write_group(tuple(group), straight or turned)

    @abstractmethod
    def _solve(self, statement: Solve) -> None:
        """A block of equations."""

    def _write_group(self, listed: Sequence[Statement], straight: bool) -> None:
        rolled = listed if straight else self._rolled(listed)
        told = ((s, self._vectors(s)) for s in rolled)
        for carried, found in groupby(told, lambda told: told[1] is not None):
            group, parts = zip(*found, strict=True)
            if not (carried and self._carry([*chain.from_iterable(parts)])):
                self._write_each(group)

    def _write_each(self, listed: Sequence[Statement | Roll]) -> None:
        for s in listed:
            if isinstance(s, Let):
                self._let(s)
            elif isinstance(s, Roll):
                if self._loops.has_room(s.targets):
                    self._roll(s)
                else:
                    self._write(s.statements, straight=True)
            else:
                self._solve(s)

    def _rolled(self, statements: Sequence[Statement]) -> Sequence[Statement | Roll]:
        def place(e: Expr) -> Expr | int:
            slot = self._slot(e)
            return e if slot is None else slot

        if self._small:
            sums = Sums(self._program.table, self._loops.kept)
            return roll_gathered(statements, self._memory, place, self._shapes, sums)
        return roll(statements, self._memory, self._seldom, self._shapes)

    def _memory(self, e: Expr) -> int:
        """Tells memories apart."""
        return 2 if e in self._results else int(self._slot(e) is not None)

    def _vectors(self, s: Statement | Roll) -> list[Vector] | None:
        """It as operations on vectors; None where it cannot be part of a row of these."""
        if self._carrier is None or not isinstance(s, Let | Roll):
            return None
        from planarc.codegen.native.carried import MOST, MOST_SELDOM
        from planarc.codegen.native.parting import vectors
        from planarc.codegen.native.spelled import is_spelled

        lets, columns = ((s,), ((s.target,),)) if isinstance(s, Let) else (s.body, s.targets)
        if not is_spelled(lets) or len(columns[0]) > (MOST_SELDOM if self._seldom else MOST):
            return None
        if self._out is not self._area and any(c[0] in self._results for c in columns):
            return None
        return vectors(s, self._kept_at)

    def _carry(self, parts: Sequence[Vector]) -> bool:
        """Write what calls for a row, where that takes less than its code; whether it does."""
        from planarc.codegen.native.carried import LEAST, step

        carrier, loops = self._carrier, self._loops
        assert carrier is not None
        if sum(operations(let) for let, *_ in parts) < LEAST:
            return False
        if not loops.has_room([target for _, target, _ in parts]):
            return False
        for _, target, leaves in parts:
            for column in leaves:
                self._store(column)
            for e in target:
                self._values.pop(e, None)
            if target[0] not in self._results and self._slot(target[0]) is None:
                loops.hold(target)
        steps = [step(*part, self._spot) for part in parts]
        *told, room = carrier.carry(steps, carrier.memory + loops.first_free)
        loops.free(room)
        first, count = (self._code.constant(n, INT) for n in told)
        if carrier.joins:
            first = first + loops.told()
        self._code.run("pc_carry", self._frame, self._time, first, count)
        return True

    def _kept_at(self, e: Expr) -> Hashable:
        slot = self._slot(e)
        return self._loops.kept.get(e, e) if slot is None else slot

    def _spot(self, e: Expr) -> int:
        """Where a value stands, reckoned from the workspace."""
        assert self._carrier is not None
        if e.is_const:
            return self._carrier.constant(float(e.data))
        if e in self._results:
            return self._carrier.area + self._results[e]
        slot = self._slot(e)
        return self._carrier.memory + self._loops.places[e] if slot is None else slot

    def _leaf(self, e: Expr) -> Value:
        """A value from the register that this function set, else from the workspace."""
        if e.op is Op.TIME:
            return self._time
        found = self._values.get(e)
        if found is not None:
            return found
        if e in self._loops.places:
            return self._loops.memory.load(REAL, self._loops.places[e])
        slot = self._slot(e)
        assert slot is not None, f"`{e}` has no value here"
        return self._w.load(REAL, slot)

    def _value(self, e: Expr) -> Value:
        return self._leaf(e) if e.op is Op.SYMBOL else formula(self._code, e, self._leaf)

    def _let(self, let: Let) -> None:
        self._break()
        value = self._turn(let.value) if self._is_turned(let) else self._value(let.value)
        if let.target in self._results:
            self._out.store(real(self._code, value), self._results[let.target])
            return
        slot = self._slot(let.target)
        self._values[let.target] = value
        if slot is not None:
            self._w.store(real(self._code, value), slot)

    def _is_turned(self, s: Statement) -> bool:
        return isinstance(s, Let) and is_turn(s.value) and s.value.args[0] in self._turns

    def _turn(self, e: Expr) -> Value:
        """Sine or cosine of an angle that Newton's method moves."""
        angle = e.args[0]
        x, known = self._leaf(angle), self._turned.get(angle)
        if known is None or known[0] != x.text:
            both = turn(self._code, self._turns[angle], x, "pc_waves" in self._alone)
            self._turned[angle] = known = x.text, both
        return known[1][e.data]

    @contextmanager
    def _aside(self) -> Iterator[None]:
        """What is set here is not known behind."""
        values, turned = dict(self._values), dict(self._turned)
        yield
        self._values = values
        self._turned = {e: x for e, x in turned.items() if self._turned.get(e) is x}

    def _roll(self, run: Roll) -> None:
        """A loop. What its group set before is in registers; all else that differs from time to
        time is read from memory, and nothing that it sets is in a register behind it."""
        c, loops = self._code, self._loops
        for e in chain.from_iterable(run.targets):
            self._values.pop(e, None)
        set_before = {column: i for i, column in enumerate(run.targets)}
        inside: Counter[Column] = Counter()
        for i, columns in enumerate(run.leaves):
            for column in columns:
                if set_before.get(column, i) < i:
                    inside[column] += 1
                elif not is_one(column):
                    self._store(column)
        kept = {column for column in run.targets if self._is_read(column, inside[column])}
        for column in run.targets:
            if column in kept and column[0] not in self._results and self._slot(column[0]) is None:
                loops.hold(column)
        own: dict[Column, Value] = {}
        with loops.run(len(run.targets[0])):
            for let, target, columns in zip(run.body, run.targets, run.leaves, strict=True):
                self._break()
                varied = {column[0]: column for column in columns if not is_one(column)}
                own[target] = value = formula(c, let.value, partial(self._due, varied, own), varied)
                if target in kept:
                    pointer, index = self._place(target)
                    pointer.store(real(c, value), index)

    def _is_read(self, column: Column, inside: int) -> bool:
        """Whether anything reads it but the group itself, so often each time."""
        if column[0] in self._results or self._slot(column[0]) is not None:
            return True
        reads = self._reads()
        return any(reads[e] > inside or e not in reads for e in column)

    def _store(self, column: Iterable[Expr]) -> None:
        """Temporaries that are in registers into memory, for a loop that reads them."""
        for e in column:
            if e in self._values and self._slot(e) is None:
                self._loops.hold((e,))
                place = self._loops.places[e]
                self._loops.memory.store(real(self._code, self._values[e]), place)

    def _due(self, columns: dict[Expr, Column], own: dict[Column, Value], e: Expr) -> Value:
        """A leaf in a loop: `e` the first time, then the others of its column."""
        column = columns.get(e)
        if column is None:
            return self._leaf(e)
        if column in own:
            return own[column]
        if is_number(e):
            return self._loops.number([n.data for n in column])
        pointer, index = self._place(column)
        return pointer.load(REAL, index)

    def _place(self, column: Column) -> tuple[Value, int]:
        loops, slots = self._loops, [self._slot(e) for e in column]
        if column[0] in self._results:
            return loops.at(self._out, [self._results[e] for e in column])
        found = [s for s in slots if s is not None]
        if found:
            return loops.at(self._w, found)
        return loops.at(loops.memory, [loops.places[e] for e in column])

    def _break(self) -> None:
        if len(self._code.lines) > self._next_break:
            self._code.break_block()
            self._next_break = len(self._code.lines) + LONGEST_BLOCK

    def _text(self) -> str:
        """The function and its constants, when all is written."""
        if self._carrier is not None:
            self._carrier.room = max(self._carrier.room, self._loops.room)
        return "".join((self._loops.text(), *self._tables, self._code.text()))
