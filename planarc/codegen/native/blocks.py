"""Blocks of equations in a function of the model's module, as LLVM text.

In:   blocks, in the order in which the function solves them
Out:  the lines that solve them with `pc_start`, `pc_step`, `pc_linear` (`newton`) and `pc_direct`
      (`sparse`), which are the same for all models

Example, a block of one tear, compare with the NumPy text:

      call void @pc_start(ptr %frame, double %t, ptr %record)
    again:
      %done = phi i1 [false, %before], [%finished, %step]
      (inner unknowns)
      br i1 %done, label %behind, label %work
    work:
      (residuals and Jacobian into the area)
      %flag = call i32 @pc_step(ptr %frame, ptr %record)
      ...
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Value, table
from planarc.codegen.native.flags import NOT_FINITE, TOP
from planarc.codegen.native.formulas import real
from planarc.codegen.native.statements import Statements
from planarc.codegen.native.turning import NUMBERS, angles, are_few
from planarc.ir.expr import Expr
from planarc.ir.program import BlockCode, Direct, Let, Solve, Statement, Tangent

if TYPE_CHECKING:
    from planarc.codegen.native.columns import Groups


class Blocks(Statements):
    """A function of the module."""

    def _solve(self, statement: Solve) -> None:
        code = self._program.blocks[statement.block]
        if not code.residuals:  # its tears are states, and in the workspace
            self._write(code.body)
            return
        if code.direct is not None:
            self._solve_direct(statement.block, code, code.direct)
        elif code.linear:
            self._solve_linear(statement.block, code)
        else:
            self._solve_nonlinear(statement.block, code)

    def _solve_linear(self, block: int, code: BlockCode) -> None:
        self._work(block, code)
        name = "pc_linear_pair" if self._is_pair(code) else "pc_linear"
        if not code.height and len(code.residuals) in TOP and "pc_linear_top" in self._alone:
            name = "pc_linear_top"
        self._call(name, self._record(block))
        self._read_tears(code)
        self._write(code.body)

    def _is_pair(self, code: BlockCode) -> bool:
        """Whether functions of their own solve for its unknowns, where code may take room."""
        return not self._small and len(code.residuals) == 2

    def _solve_direct(self, block: int, code: BlockCode, direct: Direct) -> None:
        from planarc.codegen.native.operations import operation_row, room
        from planarc.codegen.native.sparse import rows_by_slot

        loops, told = self._loops, (*rows_by_slot(direct, self._program.slots),)
        if self._carrier is not None and loops.has_free(room(direct)):
            operations = loops.row((*operation_row(direct, self._program.slots),))
            self._code.run("pc_operate", self._w, operations, loops.free(room(direct)))
            rows = loops.row(told)
        else:
            self._operate(code, direct)
            self._tables.append(table(f"pc_rows_{block}", told))
            rows = Value(self._code, POINTER, f"@pc_rows_{block}")
        self._call("pc_direct", self._record(block), rows, self._area.at(self._placement.sizes))
        known = set(direct.unknowns)  # in the workspace now
        self._write(let for let in code.body if let.target not in known)

    def _operate(self, code: BlockCode, direct: Direct) -> None:
        from planarc.codegen.native.sparse import operate

        for tear, value in zip(code.tears, operate(direct, self._value, self._break), strict=True):
            slot = self._slot(tear)
            assert slot is not None
            self._w.store(value, slot)

    def _call(self, function: str, *arguments: Value) -> None:
        """Leave where a function that solves a block fails."""
        c = self._code
        behind, failed = c.label(), c.label()
        flag = c.call(FLAG, function, self._frame, *arguments)
        c.branch(flag < 0, failed, behind)
        self._end(flag, failed, behind)

    def _end(self, flag: Value, failed: str, behind: str) -> None:
        """Leave with what a failure means, or go on behind the block."""
        c = self._code
        c.begin(failed)
        not_finite = flag.equals(NOT_FINITE)
        c.give(c.select(not_finite, c.constant(-1, FLAG), c.constant(1, FLAG)))
        c.begin(behind)

    def _read_tears(self, code: BlockCode) -> None:
        """Take the tears from the workspace."""
        for tear in code.tears:
            slot = self._slot(tear)
            assert slot is not None
            self._values[tear] = self._w.load(REAL, slot)

    @contextmanager
    def _in_code(self) -> Iterator[None]:
        """What is written here is no row: it runs again and again."""
        carrier, self._carrier = self._carrier, None
        yield
        self._carrier = carrier

    def _begin_turns(self, code: BlockCode) -> None:
        """Make room for the angles of a block, of which nothing is known yet."""
        for angle in angles(code):
            if angle not in self._turns:
                self._turns[angle] = memory = self._code.place(REAL, NUMBERS)
                for place in range(NUMBERS):
                    memory.store(math.nan, place)

    def _solve_nonlinear(self, block: int, code: BlockCode) -> None:
        c = self._code
        again, work, behind, failed = c.label(), c.label(), c.label(), c.label()
        before = c.label()
        record = self._record(block)
        if not self._small:
            self._begin_turns(code)
        pair = self._is_pair(code)
        c.run("pc_start_pair" if pair else "pc_start", self._frame, self._time, record)
        c.enter(before)
        c.enter(again)
        self._turned.clear()  # a step before may have turned them
        finished, step = c.register(), c.label()
        done = c.register()
        c.line(f"{done} = phi i1 [ false, %{before} ], [ {finished}, %{step} ]")
        self._read_tears(code)
        with self._in_code():
            self._write(code.body[: code.inner])
        c.line(f"br i1 {done}, label %{behind}, label %{work}")
        c.begin(work)
        with self._in_code():
            self._work(block, code)
        flag = c.call(FLAG, "pc_pair" if pair else "pc_step", self._frame, record)
        c.branch(flag < 0, failed, step)
        c.begin(step)
        c.line(f"{finished} = icmp eq i32 {flag.text}, 1")
        c.jump(again)
        self._end(flag, failed, behind)
        if not are_few(self._program):  # so that what stands behind may become loops
            self._turns.clear()

    def _record(self, block: int) -> Value:
        first = 1 + sum(len(r) for r in self._placement.records[:block])
        return Value(self._code, POINTER, "@pc_blocks").at(first)

    def _work(self, block: int, code: BlockCode) -> None:
        """Residuals and Jacobian into the area; what is set here is not known behind."""
        n, matrix = len(code.tears), self._placement.jacobian(block)
        found = dict(enumerate(code.residuals, self._placement.residuals(block)))
        found |= {matrix + i * n + j: value for i, j, value in code.jacobian}
        with self._aside():
            self._write_into(self._area, (*code.body[code.inner :], *code.jacobian_body), found)
            if code.tangent is not None:
                self._columns(block, code)

    def _write_into(
        self, out: Value, statements: Sequence[Statement], found: Mapping[int, Expr]
    ) -> None:
        """Statements, then values by their places in an array; where code shall be small, these are
        statements, too, of which equal ones become loops."""
        if not self._small:
            self._write(statements)
            for at, e in found.items():
                out.store(real(self._code, self._value(e)), at)
            return
        symbol, before = self._program.table.symbol, (self._results, self._out)
        lets = {symbol(f"$out({at})"): Let(symbol(f"$out({at})"), e) for at, e in found.items()}
        self._results, self._out = dict(zip(lets, found, strict=True)), out
        self._write((*statements, *lets.values()))
        self._results, self._out = before

    def _columns(self, block: int, code: BlockCode) -> None:
        """The Jacobian, some columns at a time. Entries that are always zero are so from the
        start."""
        from planarc.codegen.native.columns import group_columns

        assert code.tangent is not None
        c, n, groups = self._code, len(code.tears), group_columns(code.tangent)
        matrix = self._area.at(self._placement.jacobian(block))
        count = max(groups.of) + 1
        if self._carrier is not None:
            self._columns_carried(matrix, code.tangent, groups)
            return
        with self._loops.run(count):
            due = [c.select(self._loops.time.equals(g), 1.0, 0.0) for g in range(count)]
            for seed, group in zip(code.tangent.seeds, groups.of, strict=True):
                self._values[seed] = due[group]
            self._write(code.tangent.body)
            for i, (entry, columns) in enumerate(
                zip(code.tangent.entries, groups.columns, strict=True)
            ):
                pointer, index = self._loops.at(matrix, [i * n + j for j in columns])
                pointer.store(real(c, self._value(entry)), index)

    def _columns_carried(self, matrix: Value, tangent: Tangent, groups: Groups) -> None:
        """The same where statements are rows: seeds and entries are loops."""
        loops, n, symbol = self._loops, len(tangent.entries), self._program.table.symbol
        lets = [Let(symbol(f"$entry({i})"), e) for i, e in enumerate(tangent.entries)]
        entries, seeds = (self._begun(e) for e in ([let.target for let in lets], tangent.seeds))
        with loops.run(n):
            seeds.store(0.0, loops.time)
        columns = [
            [j for j, g in enumerate(groups.of) if g == k] for k in range(max(groups.of) + 1)
        ]
        longest = max(map(len, columns))

        def move(value: float) -> None:
            """The seeds of a group; the last one again, where others have more."""
            row = loops.rows([[*own, *own[-1:] * (longest - len(own))] for own in columns])
            with loops.run(longest):
                seeds.store(value, row.load(INT, loops.time))

        with loops.run(len(columns)):
            group = loops.time
            move(1.0)
            with self._in_code():
                self._write((*tangent.body, *lets))
            for let in lets:
                self._store((let.target,))
                self._values.pop(let.target, None)
            with loops.run(n):
                place = loops.rows(groups.columns).load(INT, group)
                matrix.at(loops.time * n).store(entries.load(REAL, loops.time), place)
            move(0.0)

    def _begun(self, temporaries: Sequence[Expr]) -> Value:
        """Where temporaries that have no place yet stand in memory, one behind the other."""
        self._loops.hold(temporaries)
        return self._loops.memory.at(self._loops.places[temporaries[0]])
