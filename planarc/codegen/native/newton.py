"""Newton's method for one block, in LLVM.

The rule is `planarc.ir.newton`, the memory `planarc.ir.frame`; compare with
`solve.kernels.numpy.block`, which says the same in Python.

    pc_start(frame, t, record)         the tears' first values into w
    pc_step(frame, record) -> flag     better tears from residuals and Jacobian
    pc_linear(frame, record) -> flag   tears of a linear block, from its residuals at zero
    pc_linear_top(frame, record) -> flag   the same, for most of those of the top
    pc_open(frame, record) -> flag     the same where a modal block is singular

Elimination is `gauss`.
"""

from __future__ import annotations

from collections.abc import Callable

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.flags import DONE, MORE, TOP, UNSOLVED
from planarc.codegen.native.gauss import in_order
from planarc.ir.frame import ARRAYS, COUNT, FACTOR, NORM, TINY, Frame, Number, Record
from planarc.ir.newton import (
    AGREES,
    BENT,
    DEPENDENT,
    FAR,
    HALVINGS,
    NEARLY,
    NOTHING,
    QUADRATIC,
    STEPS_BELOW,
    STEPS_TOP,
)


def newton_functions() -> tuple[str, ...]:
    return _start(), _step(), _linear(), _open()


def open_frame(frame: Value) -> tuple[Value, Value, Value, Value]:
    """w, numbers, accepted, area."""
    w, numbers, accepted, area = (
        frame.load(POINTER, i) for i in (Frame.W, Frame.NUMBERS, Frame.ACCEPTED, Frame.AREA)
    )
    return w, numbers, accepted, area


class Block:
    """A block's numbers and arrays, by the names of `numpy_block`."""

    def __init__(self, frame: Value, record: Value) -> None:
        self.w, self.numbers, self.accepted, area = open_frame(frame)
        self.index = record.load(INT, Record.INDEX)
        self.n = record.load(INT, Record.TEARS)
        self.m = record.load(INT, Record.RESIDUALS)
        self.below = record.load(INT, Record.BELOW).equals(1)
        self.modal = record.load(INT, Record.MODAL).equals(1)
        self.total = record.load(INT, Record.TOTAL)
        self.first = record.load(INT, Record.ACCEPTED)
        self.solved = self.numbers.at(record.load(INT, Record.SOLVED))
        self.slots = record.at(Record.SLOTS)
        self.state = area.at(record.load(INT, Record.AREA))
        self.residuals = self.state.at(ARRAYS)
        self.jacobian = self.residuals.at(self.m)
        self.change = self.jacobian.at(self.m * self.n)
        self.sizes = self.change.at(self.m)
        self.order = self.sizes.at(self.m)
        self.before = self.order.at(self.m * 3)
        self.origin = self.before.at(self.n)
        self.matrix = area.at(record.load(INT, Record.SHARED))

    def x(self, tear: Value | int) -> Value:
        """The slot of the value of a tear."""
        return self.w.at(self.slots.load(INT, tear))


@function("void pc_start(ptr frame, double t, ptr record)")
def _start(c: Code, frame: Value, t: Value, record: Value) -> None:
    b = Block(frame, record)
    b.state.store(0.0, COUNT)
    b.state.store(0.0, TINY)
    mode = b.numbers.load(INT, Number.MODE)
    with c.when(~b.below, leaves=True):
        with c.loop(b.n) as i:
            b.x(i).store(b.accepted.load(REAL, b.first + i))
        c.give()
    with c.when(mode > 0, leaves=True):
        c.give()
    h = t - b.accepted.load(REAL, b.total * 3)
    half = h * h * 0.5
    with c.loop(b.m) as k:
        start(c, b, b.solved.load(INT, k), h, half)
    c.give()


def start(c: Code, b: Block, i: Value, h: Value, half: Value) -> None:
    """The value with which an unknown of a block below the top starts."""
    value = b.accepted.at(b.first + i)
    velocity = value.load(REAL, b.total)
    acceleration = value.load(REAL, b.total * 2)
    accepted, bend = value.load(REAL), half * acceleration
    size = c.absolute(accepted)
    most = c.select(size > 1.0, size, 1.0) * BENT
    x = accepted + h * velocity + c.select(c.absolute(bend) > most, 0.0, bend)
    b.x(i).store(x)
    b.origin.store(x, i)


@function("i32 pc_step(ptr frame, ptr record)")
def _step(c: Code, frame: Value, record: Value) -> None:
    b = Block(frame, record)
    with c.when(b.below & (b.numbers.load(INT, Number.MODE) > 0), leaves=True):
        c.give(DONE)

    def position(k: Value) -> Value:
        """The k-th unknown's position among the tears."""
        return c.select(b.below, b.solved.load(INT, k), k)

    count = b.state.load(REAL, COUNT)
    with c.when(count > 0.0):
        _halve_if_worse(c, b, position)
    _eliminate(c, b, position, frame, record, ended=lambda: _finish(c, b))
    size = c.variable(0.0)
    with c.loop(b.m) as k:
        i = position(k)
        place = b.x(i)
        x = place.load(REAL)
        d = b.change.load(REAL, k)
        moved = x - d
        b.before.store(x, i)
        place.store(moved)
        relative = c.absolute(d) / c.largest(c.absolute(moved), 1.0)
        size.set(c.largest(size.get(), relative))
    with c.when(~(size.get() < 1e300), leaves=True):
        fail(c, b)
    b.state.store(count + 1.0, COUNT)
    b.state.store(1.0, FACTOR)
    limit = c.select(b.below, float(STEPS_BELOW), float(STEPS_TOP))
    exhausted = count + 1.0 >= limit
    small = size.get() < QUADRATIC
    b.state.store(c.select(small, 1.0, 0.0), TINY)
    with c.when(small):
        last = _is_last(c, b, position)
        with c.when(last | exhausted, leaves=True):
            _finish(c, b)
    with c.when(exhausted, leaves=True):
        fail(c, b)
    b.state.store(_norm(c, b), NORM)
    c.give(MORE)


def _is_last(c: Code, b: Block, position: Callable[[Value], Value]) -> Value:
    """Whether a small step is so beside each unknown, or beside the terms of each equation."""
    last = c.variable(1, INT)
    with c.loop(b.m) as k:
        i = position(k)
        d = c.absolute(b.change.load(REAL, k))
        beside = d > c.absolute(b.x(i).load(REAL)) * QUADRATIC
        with c.when(beside & (d > NOTHING)), c.loop(b.m) as r:
            row = b.jacobian.at(r * b.n)
            most = c.variable(0.0)
            with c.loop(b.n) as j:
                term = c.absolute(row.load(REAL, j) * b.x(j).load(REAL))
                most.set(c.largest(most.get(), term))
            with c.when(c.absolute(row.load(REAL, i)) * d > most.get() * QUADRATIC):
                last.set(c.constant(0, INT))
    return last.get().equals(1)


@function("i32 pc_linear(ptr frame, ptr record)")
def _linear(c: Code, frame: Value, record: Value) -> None:
    """residual(x) = residual(0) + J*x: the unknowns at once, the states as given."""
    b = Block(frame, record)
    mode = b.numbers.load(INT, Number.MODE)
    with c.when(b.below):
        with c.when(mode.equals(0)), c.loop(b.m) as k:
            b.x(b.solved.load(INT, k)).store(0.0)
        with c.loop(b.m) as i:
            total = c.variable(b.residuals.load(REAL, i))
            row = b.jacobian.at(i * b.n)
            with c.loop(b.n) as j:
                total.set(total.get() + row.load(REAL, j) * b.x(j).load(REAL))
            b.residuals.store(total.get(), i)
    with c.when(b.below & (mode > 0), leaves=True):
        c.give(DONE)

    def position(k: Value) -> Value:
        return c.select(b.below, b.solved.load(INT, k), k)

    _eliminate(c, b, position, frame, record)
    with c.when(b.below):
        _note_dead_point(c, b)
    with c.loop(b.m) as k:
        b.x(position(k)).store(c.constant(0.0, REAL) - b.change.load(REAL, k))
    c.give(DONE)


def _note_dead_point(c: Code, b: Block) -> None:
    """Tell of rows that are small beside others: their equations hardly say how a loop goes on."""
    least, most = c.variable(1e300), c.variable(0.0)
    with c.loop(b.m) as i:
        size = b.sizes.load(REAL, i)
        least.set(c.select(size < least.get(), size, least.get()))
        most.set(c.select(size > most.get(), size, most.get()))
    with c.when(least.get() < most.get() * NEARLY):
        b.numbers.store(c.constant(1, INT), Number.NEAR)


@function("i32 pc_linear_top(ptr frame, ptr record)")
def linear_top_function(c: Code, frame: Value, record: Value) -> None:
    """As `pc_linear`, to the same bits, for a block of the top with `TOP` unknowns: in the order of
    the last time, and in registers from its matrix to its unknowns."""
    b = Block(frame, record)
    for n in TOP:
        with c.when(b.n.equals(n), leaves=True):
            order = [b.order.load(INT, k) for k in range(n)]
            starts = [b.jacobian.at(i * n) for i in order]
            rows = [[row.load(REAL, j) for j in range(n)] for row in starts]
            found, _, fits = in_order(c, rows, [b.residuals.load(REAL, i) for i in order], order)
            with c.when(~fits, leaves=True):
                c.give(c.call(FLAG, "pc_linear", frame, record))
            for k, value in enumerate(found):
                b.x(k).store(0.0 - value)
            c.give(DONE)
    c.give(c.call(FLAG, "pc_linear", frame, record))


def _eliminate(
    c: Code,
    b: Block,
    position: Callable[[Value], Value],
    frame: Value,
    record: Value,
    ended: Callable[[], None] | None = None,
) -> None:
    """The change from Jacobian and residuals; where there is none, the function ends, after a
    small step or in the top without residuals with success."""
    given = (b.jacobian, b.residuals, b.change, b.sizes, b.order)
    columns = (b.solved, record.load(INT, Record.BELOW))
    flag = c.variable(c.call(FLAG, "pc_again", *given, *columns, b.m, b.n), FLAG)
    with c.when(~flag.get().equals(MORE)):
        right = b.matrix.at(b.m * b.m)
        with c.loop(b.m) as i:
            right.store(b.residuals.load(REAL, i), i)
            with c.loop(b.m) as k:
                b.matrix.store(b.jacobian.load(REAL, i * b.n + position(k)), i * b.m + k)
        found = c.call(FLAG, "pc_solve", b.matrix, right, *given[2:], b.m)
        flag.set(found)
        with c.when(found.equals(UNSOLVED) & b.modal):
            flag.set(c.call(FLAG, "pc_open", frame, record))
    if ended is not None:
        with (
            c.when(flag.get().equals(UNSOLVED)),
            c.when(_is_small(b) | _is_met(c, b), leaves=True),
        ):
            ended()
    with c.when(flag.get() < 0, leaves=True):
        b.numbers.store(b.index, Number.FAILED)
        c.give(flag.get())


def _is_small(b: Block) -> Value:
    """Whether the last step was."""
    return b.state.load(REAL, TINY) > 0.0


def _is_met(c: Code, b: Block) -> Value:
    """Whether nothing is left of a block of the top, and that is enough."""
    most = c.variable(0.0)
    with c.loop(b.m) as i:
        most.set(c.largest(most.get(), c.absolute(b.residuals.load(REAL, i))))
    content = b.numbers.load(INT, Number.CONTENT).equals(1)
    return most.get().equals(0.0) & content & ~b.below


def fail(c: Code, b: Block) -> None:
    b.numbers.store(b.index, Number.FAILED)
    c.give(UNSOLVED)


def _norm(c: Code, b: Block) -> Value:
    """The largest residual, each relative to the size of its row."""
    norm = c.variable(0.0)
    with c.loop(b.m) as i:
        r = c.absolute(b.residuals.load(REAL, i)) / b.sizes.load(REAL, i)
        norm.set(c.largest(norm.get(), r))
    return norm.get()


def _halve_if_worse(c: Code, b: Block, position: Callable[[Value], Value]) -> None:
    norm = _norm(c, b)
    worse = ~((norm < b.state.load(REAL, NORM)) | norm.equals(0.0))
    with c.when(worse, leaves=True):
        factor = b.state.load(REAL, FACTOR) * 0.5
        b.state.store(factor, FACTOR)
        with c.when(factor < 0.5**HALVINGS, leaves=True):
            with c.when(b.state.load(REAL, TINY).equals(0.0), leaves=True):
                fail(c, b)
            with c.loop(b.m) as k:  # nothing is left but rounding
                b.x(position(k)).store(b.before.load(REAL, position(k)))
            _finish(c, b)
        with c.loop(b.m) as k:
            i = position(k)
            b.x(i).store(b.before.load(REAL, i) - factor * b.change.load(REAL, k))
        c.give(MORE)


def _finish(c: Code, b: Block) -> None:
    """Converged; below the top only when not far from where it started."""
    far = c.variable(0, INT)
    with c.when(b.below), c.loop(b.m) as k:
        i = b.solved.load(INT, k)
        origin = b.origin.load(REAL, i)
        moved = c.absolute(b.x(i).load(REAL) - origin)
        limit = c.largest(c.absolute(origin), c.constant(1.0, REAL)) * FAR
        with c.when(moved > limit):
            far.set(c.constant(1, INT))
    with c.when(far.get().equals(1), leaves=True):
        fail(c, b)
    c.give(DONE)


@function("i32 pc_open(ptr frame, ptr record)", seldom=True)
def _open(c: Code, frame: Value, record: Value) -> None:
    """See `solve.kernels.singular`. The rule of a modal block that is singular: unknowns
    that its equations leave open keep their accepted values (of a nonlinear one: their
    present values)."""
    b = Block(frame, record)
    a, m, x = b.matrix, b.m, b.change
    r = a.at(m * m)
    kept, used = b.before, b.origin  # of a block in the top these are free here
    linear = record.load(INT, Record.LINEAR).equals(1)
    with c.loop(m) as i:
        largest = c.variable(0.0)
        with c.loop(m) as k:
            entry = b.jacobian.load(REAL, i * b.n + k)
            a.store(entry, i * m + k)
            largest.set(c.largest(largest.get(), c.absolute(entry)))
        b.sizes.store(c.select(largest.get() > 0.0, largest.get(), 1.0), i)
        r.store(b.residuals.load(REAL, i), i)
        accepted = b.accepted.load(REAL, b.first + i).negative()
        kept.store(c.select(linear, accepted, 0.0), i)
        used.store(0.0, i)
        x.store(-1.0, i)  # the row that gives each unknown
    with c.loop(m):
        most = c.variable(DEPENDENT)
        best, column = c.variable(c.constant(-1, INT), INT), c.variable(c.constant(-1, INT), INT)
        with (
            c.loop(m) as i,
            c.when(used.load(REAL, i).equals(0.0)),
            c.loop(m) as j,
            c.when(x.load(REAL, j) < 0.0),
        ):
            pivot = c.absolute(a.load(REAL, i * m + j)) / b.sizes.load(REAL, i)
            with c.when(pivot > most.get()):
                most.set(pivot)
                best.set(i)
                column.set(j)
        with c.when(best.get() >= 0):
            p, q = best.get(), column.get()
            used.store(1.0, p)
            x.store(c.real(p), q)
            pivot_row = a.at(p * m)
            inverse = 1.0 / pivot_row.load(REAL, q)
            with c.loop(m) as i, c.when(~i.equals(p)):
                factor = a.load(REAL, i * m + q) * inverse
                with c.when(~factor.equals(0.0)):
                    c.subtract(a.at(i * m), pivot_row, factor, m)
                    r.store(r.load(REAL, i) - factor * r.load(REAL, p), i)
    with (
        c.loop(m) as k,
        c.when(x.load(REAL, k) < 0.0),
        c.loop(m) as i,
        c.when(used.load(REAL, i) > 0.0),
    ):
        r.store(r.load(REAL, i) - a.load(REAL, i * m + k) * kept.load(REAL, k), i)
    most = c.variable(1.0)
    with c.loop(m) as j:
        row = x.load(REAL, j)
        with c.when(row < 0.0):
            x.store(kept.load(REAL, j), j)
        with c.when(row >= 0.0):
            i = c.whole(row)
            x.store(r.load(REAL, i) / a.load(REAL, i * m + j), j)
        most.set(c.largest(most.get(), c.absolute(x.load(REAL, j))))
    with c.loop(m) as i, c.when(used.load(REAL, i).equals(0.0)):
        limit = b.sizes.load(REAL, i) * most.get() * AGREES
        with c.when(~(c.absolute(r.load(REAL, i)) <= limit), leaves=True):
            c.give(UNSOLVED)
    b.numbers.store(b.index, Number.OPEN)
    c.give(MORE)
