"""A program as LLVM text: the fast form.

In:   Program
Out:  one module with the functions

    pc_parameters, pc_levels, pc_rest, pc_discrete   i32 (frame, t)
    pc_initial, pc_zeros                             i32 (frame, t, results)

and the constant `pc_blocks`: how many blocks, then each block's record
(`planarc.ir.frame`). A function reads and writes the workspace, gives 0 or the flag
of a block that failed, and solves blocks with `pc_start`, `pc_step`, `pc_linear`
(`newton`) and `pc_direct` (`sparse`), which are the same for all models.

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

Long lists that repeat themselves, as those of equal parts do, are loops (`rolling`, `loops`).

The file is long because what writes a function knows of each value whether it stands in a register,
in the workspace, in the memory of loops or among the results.

Promises:  no address is in the text: the object code made of it can be kept on disk.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, partial
from itertools import chain, compress, groupby, pairwise
from typing import TYPE_CHECKING

from planarc.codegen.certain import all_lets
from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, table
from planarc.codegen.native.carried import (
    DECLARED,
    LEAST,
    MOST,
    MOST_SELDOM,
    Carrier,
    do_not_wait,
    step,
    vectors,
)
from planarc.codegen.native.columns import group_columns
from planarc.codegen.native.formulas import declarations, formula, real
from planarc.codegen.native.gauss import NOT_FINITE
from planarc.codegen.native.loops import Loops
from planarc.codegen.native.operations import operation_row, room
from planarc.codegen.native.packed import Rows
from planarc.codegen.native.reads import counted, reads_of
from planarc.codegen.native.rolling import (
    SHORTEST_SELDOM,
    Column,
    Roll,
    is_one,
    operations,
    roll,
    roll_gathered,
)
from planarc.codegen.native.shapes import Shapes, is_number
from planarc.codegen.native.sparse import operate, rows_by_slot
from planarc.codegen.native.spelled import is_spelled
from planarc.codegen.native.summing import Sums
from planarc.codegen.native.turning import (
    NUMBERS,
    angles,
    are_few,
    is_turn,
    turn,
)
from planarc.ir.expr import Expr, Op, text
from planarc.ir.frame import Frame, Mode, Number, Placement, place
from planarc.ir.program import BlockCode, Direct, Let, Program, Solve, Statement

if TYPE_CHECKING:
    from planarc.codegen.slopes import Slopes
    from planarc.ir.derivatives import Scope

#: Lines of a basic block: LLVM's quickest way takes time with the square of its length.
LONGEST_BLOCK = 200

#: Statements that run often are rows where all of them have so many operations: code runs quicker.
#: Those that run once a step are rows in smaller models, too.
LARGE, MEDIUM = 4000, 2000

_RUNTIME = """
declare void @pc_start(ptr, double, ptr)
declare void @pc_start_pair(ptr, double, ptr)
declare i32 @pc_step(ptr, ptr)
declare i32 @pc_pair(ptr, ptr)
declare i32 @pc_linear(ptr, ptr)
declare i32 @pc_linear_pair(ptr, ptr)
declare i32 @pc_direct(ptr, ptr, ptr, ptr)
declare void @pc_operate(ptr, ptr, ptr)
declare double @pc_past(ptr, i64, i64, double)
declare double @pc_external(i64, i64, i64, ptr)
"""


def ir(
    program: Program, small: bool = False, shared: Rows | None = None,
    carrier: Carrier | None = None,
) -> str:  # fmt: skip
    """The model's module as LLVM text; `small`: rather than quick; `shared`: where its loops put
    their rows, which have constants of their own without; `carrier`: of statements that are rows,
    too, which are code without, and where they run often also in small models."""
    placement = place(program)
    shapes = Shapes()
    reads = cache(partial(reads_of, program, shapes))
    slot = _slots(program)
    section = partial(_Section, program, placement, shapes, reads, slot, small=small, shared=shared)
    weight = 0 if carrier is None else _weight(program)
    seldom = partial(section, seldom=True, carrier=carrier)
    often, less = (
        partial(section, carrier=carrier if weight >= least else None) for least in (LARGE, MEDIUM)
    )
    if carrier is not None:
        carrier.hurries = weight >= MEDIUM
    below = [s for statements in program.levels[:-1] for s in statements]
    top = program.levels[-1] if program.levels else ()
    zeros = [r.zero for r in program.relations]
    functions = (
        seldom("pc_parameters").text(program.parameters),
        often("pc_levels").levels(below, top),
        less("pc_rest").text(program.rest),
        seldom("pc_initial", results=True).text(program.initial, program.initial_residuals),
        less("pc_zeros", results=True).text(
            program.roots, zeros, [r.certain for r in program.relations]
        ),
        section("pc_discrete", seldom=True).text(program.discrete),
        "" if carrier is None else carrier.text(),
    )
    head = declarations() + _RUNTIME
    return "\n".join((head, _records(placement), *functions))


def slopes_ir(
    program: Program, slopes: Slopes, scope: Scope, shared: Rows | None = None,
    carrier: Carrier | None = None,
) -> str:  # fmt: skip
    """The module of a program's derivatives: `pc_slopes_*` as `pc_initial`, and `pc_tape_*`
    (`planarc.ir.derivatives`); small and without the tape where rows are `shared`."""
    small = shared is not None
    tape = "" if small else table(f"pc_tape_{scope.value}", slopes.tape())
    lets, taken, results = slopes.named(program.table)
    shapes = Shapes()
    reads = cache(partial(counted, [*(let.value for let in lets), *taken], shapes))
    section = _Section(program, place(program), shapes, reads, _slots(program),
                       f"pc_slopes_{scope.value}", True, True, small, shared,
                       carrier=carrier)  # fmt: skip
    told = declarations() + _RUNTIME + ("" if carrier is None else DECLARED)
    return "\n".join((told, tape, section.coefficients(lets, taken, results)))


def _slots(program: Program) -> Callable[[Expr], int | None]:
    """The slot of a symbol; None where it has none."""
    return cache(lambda e: program.slots.get(text(e)))


def _weight(program: Program) -> int:
    """About the operations of what runs again and again."""
    lets = (let for statements in program.levels for let in all_lets(program, statements))
    return sum(map(operations, lets))


def _records(placement: Placement) -> str:
    numbers = [len(placement.records), *(n for r in placement.records for n in r)]
    return table("pc_blocks", numbers)


class _Section:
    """A function of the module."""

    def __init__(
        self, program: Program, placement: Placement, shapes: Shapes,
        reads: Callable[[], Counter[Expr]], slot: Callable[[Expr], int | None], name: str,
        results: bool = False, seldom: bool = False, small: bool = False,
        shared: Rows | None = None, carrier: Carrier | None = None,
    ) -> None:  # fmt: skip
        self._carrier = carrier
        self._tables: list[str] = []
        self._seldom, self._small = seldom, small
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

    def coefficients(
        self, lets: Sequence[Let], taken: Sequence[Expr], results: dict[Expr, int]
    ) -> str:
        """The coefficients of derivatives at the present point, as `results`: what statements set
        by this name, and trivial values. Where there are many of these, a loop gathers them."""
        c = self._code
        if self._carrier is None:
            self._results = results
        self._write(lets)
        self._collect([(i, e) for i, e in enumerate(taken) if e not in self._results])
        c.give(0)
        return self._text()

    def _collect(self, listed: Sequence[tuple[int, Expr]]) -> None:
        """Trivial values as results. Where there are many of these, a loop gathers them."""
        gathered = []
        for i, e in listed:
            place = self._source(e) if len(listed) >= SHORTEST_SELDOM else None
            if place is None:
                self._out.store(real(self._code, self._value(e)), i)
                self._break()
            else:
                gathered.append((i, place))
        if gathered:
            self._gather(gathered, self._out)

    def _source(self, e: Expr) -> int | None:
        """Where a trivial value stands, times 4; 2 more in the memory of loops, 1 more for its
        negative. None: in a register."""
        negative = int(e.op is Op.NEG)
        e = e.args[0] if negative else e
        if is_number(e) and e not in self._loops.places:
            self._loops.hold((e,))
            self._loops.memory.store(e.data, self._loops.places[e])
        if e in self._loops.places and e not in self._values:
            return 4 * self._loops.places[e] + 2 + negative
        slot = None if e in self._values else self._slot(e)
        return None if slot is None else 4 * slot + negative

    def _gather(self, told: Sequence[tuple[int, int]], out: Value) -> None:
        """Results and the sources of their values: how far behind the last one each stands, and one
        behind the other, by memories, their places: such numbers pack well."""
        c, loops = self._code, self._loops
        value, last = c.variable(0.0), c.variable(0, INT)
        homes = (self._w, loops.memory)
        at = [c.variable(0, INT) for _ in homes]
        rows = [
            loops.row([place >> 2 for _, place in told if (place & 2) // 2 == k])
            for k in range(len(homes))
        ]
        with loops.run(len(told)):
            where = last.get() + loops.word(
                [b - a for a, b in pairwise((0, *(i for i, _ in told)))]
            )
            last.set(where)
            kind = loops.word([place & 3 for _, place in told])
            for k, home in enumerate(homes):
                with c.when((kind / 2).equals(k)):
                    value.set(home.load(REAL, rows[k].load(INT, at[k].get())))
                    at[k].set(at[k].get() + 1)
            with c.when((kind - kind / 2 * 2).equals(1)):
                value.set(-value.get())
            out.store(value.get(), where)

    def levels(self, below: Iterable[Statement], top: Iterable[Statement]) -> str:
        """May end before the top level."""
        c = self._code
        self._write(below)
        mode = self._frame.load(POINTER, Frame.NUMBERS).load(INT, Number.MODE)
        with c.when(mode.equals(Mode.BELOW), leaves=True):
            c.give(0)
        return self.text(top)

    def text(
        self,
        statements: Iterable[Statement],
        results: Sequence[Expr] = (),
        certain: Sequence[bool] = (),
    ) -> str:
        """The function; it fails where a result that is `certain` is not a number."""
        c = self._code
        self._write(statements)
        if self._carrier is not None:
            self._collect([*enumerate(results)])
            self._fail_where_unknown(certain)
            c.give(0)
            return self._text()
        for i, e in enumerate(results):
            c.arguments[2].store(real(c, self._leaf(e)), i)
        for e in compress(results, certain):
            with c.when(real(c, self._leaf(e)).is_nan(), leaves=True):
                c.give(-1)
        c.give(0)
        return self._text()

    def _fail_where_unknown(self, certain: Sequence[bool]) -> None:
        """Leave where a result that is `certain` is not a number."""
        c = self._code
        if not any(certain):
            return
        with self._loops.run(len(certain)):
            fails = self._out.load(REAL, self._loops.time).is_nan()
            if not all(certain):
                fails = fails & self._loops.word([int(x) for x in certain]).equals(1)
            with c.when(fails, leaves=True):
                c.give(-1)

    def _text(self) -> str:
        """The function and its constants, when all is written."""
        if self._carrier is not None:
            self._carrier.room = max(self._carrier.room, self._loops.room)
        return "".join((self._loops.text(), *self._tables, self._code.text()))

    def _write(self, statements: Iterable[Statement], straight: bool = False) -> None:
        """`straight`: without loops."""
        listed = tuple(statements)
        for turned, group in groupby(listed, self._is_turned):
            self._write_group(tuple(group), straight or turned)

    def _write_group(self, listed: Sequence[Statement], straight: bool) -> None:
        rolled = listed if straight else self._rolled(listed)
        for carried, found in groupby(rolled, self._is_carried):
            group = tuple(found)
            if not (carried and self._carry(group)):
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

    def _is_carried(self, s: Statement | Roll) -> bool:
        """Whether it can be part of a row of operations on vectors."""
        if self._carrier is None or not isinstance(s, Let | Roll):
            return False
        lets, columns = ((s,), ((s.target,),)) if isinstance(s, Let) else (s.body, s.targets)
        if not is_spelled(lets) or len(columns[0]) > (MOST_SELDOM if self._seldom else MOST):
            return False
        if self._out is not self._area and any(c[0] in self._results for c in columns):
            return False
        return isinstance(s, Let) or do_not_wait(s, self._kept_at)

    def _carry(self, listed: Sequence[Statement | Roll]) -> bool:
        """Write what calls for a row, where that takes less than its code; whether it does."""
        carrier, loops = self._carrier, self._loops
        assert carrier is not None
        parts = [part for s in listed for part in vectors(s)]
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
        *told, count = carrier.carry(steps, carrier.memory + loops.first_free)
        loops.free(count)
        numbers = [self._code.constant(n, INT) for n in told]
        self._code.run("pc_carry", self._frame, self._time, *numbers)
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

    # Values

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
        return formula(self._code, e, self._leaf)

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
            self._turned[angle] = known = x.text, turn(self._code, self._turns[angle], x)
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

    # Blocks

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
        self._call(name, self._record(block))
        self._read_tears(code)
        self._write(code.body)

    def _is_pair(self, code: BlockCode) -> bool:
        """Whether functions of their own solve for its unknowns, where code may take room."""
        return not self._small and len(code.residuals) == 2

    def _solve_direct(self, block: int, code: BlockCode, direct: Direct) -> None:
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
        assert code.tangent is not None
        c, n, groups = self._code, len(code.tears), group_columns(code.tangent)
        matrix = self._area.at(self._placement.jacobian(block))
        count = max(groups.of) + 1
        with self._loops.run(count):
            due = [c.select(self._loops.time.equals(g), 1.0, 0.0) for g in range(count)]
            for seed, group in zip(code.tangent.seeds, groups.of, strict=True):
                self._values[seed] = due[group]
            with self._in_code():
                self._write(code.tangent.body)
            for i, (entry, columns) in enumerate(
                zip(code.tangent.entries, groups.columns, strict=True)
            ):
                pointer, index = self._loops.at(matrix, [i * n + j for j in columns])
                pointer.store(real(c, self._value(entry)), index)
