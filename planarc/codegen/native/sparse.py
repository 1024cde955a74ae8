"""A block's sparse equations in LLVM, as `planarc.ir.sparse` tells them.

    pc_direct(frame, record, rows, sizes) -> flag    all unknowns of a linear block

The operations have put the tears into the workspace. Where residuals are too large, or the matrix
is asked for, they are found with pivoting. Unknowns and values of the `rows` are told by their
slots, `sizes` are those of the unknowns, by their slots, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from planarc.codegen.native.assembly import BIT, FLAG, INT, REAL, Code, Negative, Value, function
from planarc.codegen.native.flags import DONE
from planarc.codegen.native.newton import Block
from planarc.ir.expr import Expr, Op, text
from planarc.ir.frame import Mode, Number
from planarc.ir.newton import FITS
from planarc.ir.program import Direct
from planarc.ir.sparse import Head, constant_name, operations_of, read_rows


def operate(
    direct: Direct, value: Callable[[Expr], Value], pause: Callable[[], None]
) -> list[Value]:
    """The tears by the operations, from the values; with a `pause` before each."""
    numbers: list[Value | None] = [None] * len(direct.values)

    def number(i: int) -> Value:
        found = numbers[i]
        if found is None:  # a value that is read for the first time
            found = numbers[i] = value(direct.values[i])
        return found

    for a, negative, factors in operations_of(direct):
        pause()
        if not factors:
            assert a is not None
            numbers.append(1.0 / number(a))
            continue
        found = [*map(number, factors)]
        product = found[0].code.product(found)
        term = Negative(product) if negative else product
        numbers.append(term.kept() if a is None else product.code.sum([number(a), term]))
    return [-number(ref >> 1) if ref & 1 else number(ref >> 1) for ref in direct.tears]


def value_slots(direct: Direct, slots: Mapping[str, int]) -> list[int]:
    """Where the values stand."""
    names = (constant_name(e) if e.op is Op.CONST else text(e) for e in direct.values)
    return [slots[name] for name in names]


def rows_by_slot(direct: Direct, slots: Mapping[str, int]) -> Iterator[int]:
    """How many rows, and how many of them give an unknown; then of each row the slots of its
    constant and of this unknown, how many entries, and their slots."""
    rows, n = read_rows(direct.rows), direct.rows[Head.TEARS]
    unknowns = [slots[text(u)] for u in direct.unknowns]
    values = value_slots(direct, slots)
    yield from (len(rows), len(rows) - n)
    for own, (constant, entries) in zip(unknowns[n:] + n * [0], rows, strict=True):
        yield from (values[constant], own, len(entries))
        for j, value in entries:
            yield from (unknowns[j], values[value])


@function("i32 pc_direct(ptr frame, ptr record, ptr rows, ptr sizes)")
def direct_function(c: Code, frame: Value, record: Value, rows: Value, sizes: Value) -> None:
    b = Block(frame, record)
    fits = c.variable(~b.numbers.load(INT, Number.MODE).equals(Mode.MATRICES), BIT)
    with c.loop(b.n) as j:
        sizes.store(c.absolute(b.x(j).load(REAL)), b.slots.load(INT, j))
    with _residuals(c, b, rows, sizes) as (_, rest, size):
        fits.set(fits.get() & (c.absolute(rest) <= size * FITS))
    with c.when(~fits.get()):
        _dense(c, b, rows, sizes)
        flag = c.call(FLAG, "pc_linear", frame, record)
        with c.when(flag < 0, leaves=True):
            c.give(flag)
        with _residuals(c, b, rows, sizes):
            pass
    c.give(DONE)


@contextmanager
def _residuals(
    c: Code, b: Block, rows: Value, sizes: Value, constants: Value | float = 1.0
) -> Iterator[tuple[Value, Value, Value]]:
    """All unknowns from the tears. What stands inside is done for each residual: its number, what
    is left, and the size of its terms; constants count so many times."""
    way = c.variable(2, INT)

    def take() -> Value:
        at = way.get()
        way.set(at + 1)
        return rows.load(INT, at)

    inner = rows.load(INT, 1)
    total, size = c.variable(0.0), c.variable(0.0)
    with c.loop(rows.load(INT)) as i:
        first = b.w.load(REAL, take()) * constants
        own = take()
        total.set(0.0)
        size.set(c.absolute(first))
        with c.loop(take()):
            unknown = take()
            slope = b.w.load(REAL, take())
            total.set(total.get() + slope * b.w.load(REAL, unknown))
            size.set(size.get() + c.absolute(slope) * sizes.load(REAL, unknown))
        total.set(first + total.get())
        with c.when(i < inner):
            b.w.store(total.get(), own)
            sizes.store(size.get(), own)
        with c.when(i >= inner):
            yield i - inner, total.get(), size.get()


def _dense(c: Code, b: Block, rows: Value, sizes: Value) -> None:
    """The residuals where all tears are zero, and their matrix column by column."""
    with c.loop(b.n + 1) as k:
        last = k.equals(b.n)
        with c.loop(b.n) as j:
            b.x(j).store(c.select(j.equals(k), 1.0, 0.0))
        with _residuals(c, b, rows, sizes, c.select(last, 1.0, 0.0)) as (i, rest, _):
            with c.when(last):
                b.residuals.store(rest, i)
            with c.when(~last):
                b.jacobian.store(rest, i * b.n + k)
