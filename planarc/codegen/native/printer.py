"""A program as LLVM text: the fast form.

In:   Program
Out:  one module with the functions

    pc_parameters, pc_levels, pc_rest, pc_discrete   i32 (frame, t)
    pc_initial, pc_zeros                             i32 (frame, t, results)

and the constant `pc_blocks`: how many blocks, then each block's record
(`planarc.ir.frame`). A function reads and writes the workspace, gives 0 or the flag
of a block that failed. `statements` writes what stands in it, `blocks` what solves equations.

Long lists that repeat themselves, as those of equal parts do, are loops (`rolling`, `loops`).

Promises:  no address is in the text: the object code made of it can be kept on disk.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import cache, partial
from itertools import compress, pairwise
from typing import TYPE_CHECKING

from planarc.codegen.certain import all_lets
from planarc.codegen.native.assembly import INT, POINTER, REAL, Value, table
from planarc.codegen.native.blocks import Blocks
from planarc.codegen.native.formulas import declarations, real
from planarc.codegen.native.packed import Rows
from planarc.codegen.native.reads import counted, reads_of
from planarc.codegen.native.rolling import SHORTEST_SELDOM, operations
from planarc.codegen.native.shapes import Shapes, is_number
from planarc.codegen.native.waves import DECLARED as WAVES
from planarc.ir.expr import Expr, Op, text
from planarc.ir.frame import Frame, Mode, Number, Placement, place
from planarc.ir.program import Let, Program, Statement

if TYPE_CHECKING:
    from planarc.codegen.native.carried import Carrier
    from planarc.codegen.slopes import Slopes
    from planarc.ir.derivatives import Scope

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
#: Functions that not every runtime has.
_ALONE = {"pc_linear_top": "declare i32 @pc_linear_top(ptr, ptr)\n", "pc_waves": WAVES}


def ir(
    program: Program, small: bool = False, shared: Rows | None = None,
    carrier: Carrier | None = None, alone: Collection[str] = (),
) -> str:  # fmt: skip
    """The model's module as LLVM text; `small`: rather than quick; `shared`: where its loops put
    their rows, which have constants of their own without; `carrier`: of statements that are rows,
    too, which are code without, and where they run often also in small models; its functions are
    not here. `alone`: functions that this process's runtime has besides, and may be called."""
    placement = place(program)
    shapes = Shapes()
    reads = cache(partial(reads_of, program, shapes))
    slot = _slots(program)
    section = partial(
        _Function, program, placement, shapes, reads, slot, small=small, shared=shared
    )
    heavy = 0 if carrier is None else weight(program)
    seldom = partial(section, seldom=True, carrier=carrier)
    often, less = (
        partial(section, alone=alone, carrier=carrier if heavy >= least else None)
        for least in (LARGE, MEDIUM)
    )
    if carrier is not None:
        carrier.hurries = heavy >= MEDIUM
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
    )
    head = declarations() + _RUNTIME + "".join(map(_ALONE.__getitem__, alone))
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
    section = _Function(program, place(program), shapes, reads, _slots(program),
                       f"pc_slopes_{scope.value}", True, True, small, shared,
                       carrier=carrier)  # fmt: skip
    told = declarations() + _RUNTIME
    if carrier is not None:
        from planarc.codegen.native.carried import DECLARED

        told += DECLARED
    return "\n".join((told, tape, section.coefficients(lets, taken, results)))


def _slots(program: Program) -> Callable[[Expr], int | None]:
    """The slot of a symbol; None where it has none."""
    return cache(lambda e: program.slots.get(text(e)))


def weight(program: Program) -> int:
    """About the operations of what runs again and again."""
    lets = (let for statements in program.levels for let in all_lets(program, statements))
    return sum(map(operations, lets))


def _records(placement: Placement) -> str:
    numbers = [len(placement.records), *(n for r in placement.records for n in r)]
    return table("pc_blocks", numbers)


class _Function(Blocks):
    """A function of the module, with what it gives."""

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
