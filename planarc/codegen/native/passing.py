"""Passing derivatives on along a tape, in LLVM: the same for every model.

    pc_ranges(passing)                        where they differ from zero, once a choice of seeds
    pc_pass(passing, t) -> flag               the motions of all nodes, at the present point
    pc_gather(passing, nodes, count, out)     motions of some nodes, a row each
    pc_cv_jacobian                            the Jacobian as CVODE calls it

See `planarc.ir.derivatives`; `codegen.slopes` tells the method. A row of motions has a
column for each seed; the columns that are not zero lie within a range, so that of a long
chain only the half that moves is computed. A group that solves is passed
twice: with its tears at rest and, beside it, with each of them moving by one, which gives
the matrix and right sides of a linear system; then with the motions of the tears.

Flags are 0, or 1 where a group's matrix is singular or a derivative is not finite. Then
`pc_cv_jacobian` takes differences (`runtime`).
"""

from __future__ import annotations

from planarc.codegen.native.assembly import (
    FLAG,
    INT,
    POINTER,
    REAL,
    Code,
    Value,
    Variable,
    function,
)
from planarc.codegen.native.elimination import eliminate_function
from planarc.ir.derivatives import CHUNK, Group, Head, Passing
from planarc.ir.frame import Frame, Number

_DECLARED = """
declare double @llvm.fabs.f64(double)
declare i32 @pc_rhs(ptr, double, ptr, ptr)
declare i32 @pc_cv_differences(double, ptr, ptr, ptr, ptr, ptr, ptr, ptr)
"""
#: Number of columns that are passed on along all rows before the next ones, so that they
#: stay in the processor's memory.
PANEL = 32
_WIDE = "<4 x double>"


def passing_text() -> str:
    """The whole module."""
    return _DECLARED + "\n".join((*passing_functions(), _gather(), _cv_jacobian()))


def passing_functions() -> tuple[str, ...]:
    """What passes motions on, without what reads them."""
    return _ranges(), _rows(), eliminate_function(), _pass()


class _Tape:
    """The pointers of a tape and of what is passed on along it."""

    def __init__(self, passing: Value) -> None:
        def pointer(which: Passing) -> Value:
            return passing.load(POINTER, which)

        self.numbers = pointer(Passing.TAPE)
        self.values, self.columns = pointer(Passing.VALUES), pointer(Passing.COLUMNS)
        self.motions, self.ranges = pointer(Passing.MOTIONS), pointer(Passing.RANGES)
        self.local, self.scratch = pointer(Passing.LOCAL), pointer(Passing.SCRATCH)
        self.width = passing.load(INT, Passing.WIDTH)
        self.stride = passing.load(INT, Passing.STRIDE)

    def count(self, head: Head) -> Value:
        return self.numbers.load(INT, head)

    def list(self, head: Head) -> Value:
        return self.numbers.at(self.count(head))

    def motion(self, node: Value) -> Value:
        return self.motions.at(node * self.width)

    def range(self, node: Value) -> tuple[Value, Value]:
        return self.ranges.load(INT, node * 2), self.ranges.load(INT, node * 2 + 1)

    def set_range(self, node: Value, low: Value, high: Value) -> None:
        self.ranges.store(low, node * 2)
        self.ranges.store(high, node * 2 + 1)

    def beside(self, node: Value) -> Value:
        return self.local.at(node * self.stride)


class _Union:
    """The smallest range that holds all that are given; empty ones do not count."""

    def __init__(self, c: Code, width: Value) -> None:
        self._code = c
        self._low, self._high = c.variable(width, INT), c.variable(0, INT)

    def take(self, low: Value, high: Value) -> None:
        a, b = self._low.get(), self._high.get()
        self._low.set(self._code.select(low < a, low, a))
        self._high.set(self._code.select(high > b, high, b))

    def get(self) -> tuple[Value, Value]:
        return self._low.get(), self._high.get()


@function("void pc_ranges(ptr passing)")
def _ranges(c: Code, passing: Value) -> None:
    """The rows in which motions may differ from zero, by what is told to move alone."""
    tape = _Tape(passing)
    starts, targets = tape.list(Head.STARTS), tape.list(Head.TARGETS)
    sources, groups = tape.list(Head.SOURCES), tape.list(Head.TABLE)

    def rows(first: Value, stop: Value) -> None:
        with c.loop(stop, first) as row:
            union = _Union(c, tape.width)
            with c.loop(starts.load(INT, row + 1), starts.load(INT, row)) as e:
                union.take(*tape.range(sources.load(INT, e)))
            tape.set_range(targets.load(INT, row), *union.get())

    with c.loop(tape.count(Head.NODES)) as node:
        column = tape.columns.load(INT, node)
        tape.set_range(node, tape.width, c.constant(0, INT))
        with c.when(column >= 0):
            low = column / CHUNK * CHUNK
            tape.set_range(node, low, low + CHUNK)
    with c.loop(tape.count(Head.GROUPS)) as i:
        group = _Group(tape, groups.at(i * len(Group)))
        rows(group.first, group.stop)
        union = _Union(c, tape.width)
        with c.loop(group.residuals) as k:
            union.take(*tape.range(group.members.load(INT, group.tears + k)))
        with c.when(group.residuals > 0):
            with c.loop(group.tears) as k:
                node = group.members.load(INT, k)
                with c.when(tape.columns.load(INT, node) < 0):
                    tape.set_range(node, *union.get())
            rows(group.first, group.inner)
    c.give()


class _Group:
    """A record of the tape's table."""

    def __init__(self, tape: _Tape, record: Value) -> None:
        self.first, self.inner, self.stop = (
            record.load(INT, i) for i in (Group.FIRST, Group.INNER, Group.STOP)
        )
        self.tears = record.load(INT, Group.TEARS)
        self.residuals = record.load(INT, Group.RESIDUALS)
        self.members = tape.numbers.at(record.load(INT, Group.LIST))


class _Sum:
    """`CHUNK` columns of a sum of rows, in registers."""

    def __init__(self, c: Code) -> None:
        self._code = c
        zero = Value(c, _WIDE, "zeroinitializer")
        self._parts = [Variable(c, zero) for _ in range(CHUNK // 4)]

    def add(self, factor: Value, row: Value) -> None:
        c = self._code
        one = c.emit(_WIDE, f"insertelement {_WIDE} poison, double {factor.text}, i64 0")
        four = c.emit(
            _WIDE, f"shufflevector {_WIDE} {one.text}, {_WIDE} poison, <4 x i32> zeroinitializer"
        )
        for i, part in enumerate(self._parts):
            x = c.emit(_WIDE, f"load {_WIDE}, ptr {row.at(4 * i).text}, align 8")
            product = c.emit(_WIDE, f"fmul contract {_WIDE} {four.text}, {x.text}")
            sum = f"fadd contract {_WIDE} {part.get().text}, {product.text}"
            part.set(c.emit(_WIDE, sum))

    def store(self, row: Value) -> None:
        for i, part in enumerate(self._parts):
            place = row.at(4 * i).text
            self._code.line(f"store {_WIDE} {part.get().text}, ptr {place}, align 8")


@function("void pc_rows(ptr passing, i64 first, i64 stop, i64 group, i64 tears)")
def _rows(c: Code, passing: Value, first: Value, stop: Value, group: Value, tears: Value) -> None:
    """Rows `first` to `stop`; of group >= 0 the motions beside them too, of so many tears.

    What a range leaves out stays zero in memory, so that chunks need no care.
    """
    tape = _Tape(passing)
    starts, targets = tape.list(Head.STARTS), tape.list(Head.TARGETS)
    sources, owners = tape.list(Head.SOURCES), tape.list(Head.OWNERS)
    solves = group >= 0
    chunks = (tears + (CHUNK - 1)) / CHUNK
    with c.loop((tape.width + (PANEL - 1)) / PANEL) as panel, c.loop(stop, first) as row:
        target = targets.load(INT, row)
        begin, end = starts.load(INT, row), starts.load(INT, row + 1)
        low, high = tape.range(target)
        left, right = panel * PANEL, panel * PANEL + PANEL
        low, high = c.select(low < left, left, low), c.select(high > right, right, high)
        motion = tape.motion(target)
        with c.loop(high / CHUNK, low / CHUNK) as chunk:
            total, at = _Sum(c), chunk * CHUNK
            with c.loop(end, begin) as e:
                source = tape.motion(sources.load(INT, e))
                total.add(tape.values.load(REAL, e), source.at(at))
            total.store(motion.at(at))
    with c.when(solves), c.loop(stop, first) as row:
        target = targets.load(INT, row)
        begin, end = starts.load(INT, row), starts.load(INT, row + 1)
        with c.loop(chunks) as chunk:
            total, at = _Sum(c), chunk * CHUNK
            with c.loop(end, begin) as e:
                source = sources.load(INT, e)
                with c.when(owners.load(INT, source).equals(group)):
                    total.add(tape.values.load(REAL, e), tape.beside(source).at(at))
            total.store(tape.beside(target).at(at))
    c.give()


@function("i32 pc_pass(ptr passing, double t)")
def _pass(c: Code, passing: Value, t: Value) -> None:
    tape = _Tape(passing)
    compute, frame = passing.load(POINTER, Passing.COEFFICIENTS), passing.load(POINTER)
    with c.when(~compute.call(FLAG, frame, t, tape.values).equals(0), leaves=True):
        c.give(1)
    groups = tape.list(Head.TABLE)
    with c.loop(tape.count(Head.GROUPS)) as number:
        _group(c, passing, tape, number, _Group(tape, groups.at(number * len(Group))))
    c.give(0)


def _group(c: Code, passing: Value, tape: _Tape, number: Value, group: _Group) -> None:
    unknowns = c.variable(0, INT)
    with c.when(group.residuals > 0), c.loop(group.tears) as i:
        node = group.members.load(INT, i)
        beside = tape.beside(node)
        with c.loop(tape.stride) as j:
            beside.store(0.0, j)
        with c.when((tape.columns.load(INT, node) < 0) & (unknowns.get() < group.residuals)):
            beside.store(1.0, unknowns.get())
            unknowns.set(unknowns.get() + 1)
            motion, (low, high) = tape.motion(node), tape.range(node)
            with c.loop(high, low) as j:
                motion.store(0.0, j)
    m = unknowns.get()
    solves = m > 0

    def rows(until: Value, which: Value) -> None:
        c.run("pc_rows", passing, group.first, until, which, m)

    rows(group.stop, c.select(solves, number, c.constant(-1, INT)))
    with c.when(solves):
        with c.when(~m.equals(group.residuals), leaves=True):
            c.give(1)
        right = tape.scratch.at(m * m)
        union = _Union(c, tape.width)
        with c.loop(m) as i:
            node = group.members.load(INT, group.tears + i)
            union.take(*tape.range(node))
            beside = tape.beside(node)
            with c.loop(m) as j:
                tape.scratch.store(beside.load(REAL, j), i * m + j)
            row, motion = right.at(i * tape.width), tape.motion(node)
            with c.loop(tape.width) as j:
                row.store(0.0, j)
            low, high = tape.range(node)
            with c.loop(high, low) as j:
                row.store(motion.load(REAL, j), j)
        low, high = union.get()
        count = c.select(low < high, high - low, c.constant(0, INT))
        sizes = right.at(m * tape.width)
        flag = c.call(
            FLAG, "pc_eliminate", tape.scratch, right.at(low), sizes, m, count, tape.width
        )
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        k = c.variable(0, INT)
        with c.loop(group.tears) as i:
            node = group.members.load(INT, i)
            with c.when(tape.columns.load(INT, node) < 0):
                row, motion = right.at(k.get() * tape.width), tape.motion(node)
                with c.loop(high, low) as j:
                    motion.store(row.load(REAL, j).negative(), j)
                k.set(k.get() + 1)
        rows(group.inner, c.constant(-1, INT))


@function("i32 pc_gather(ptr passing, ptr nodes, i64 count, ptr out)")
def _gather(c: Code, passing: Value, nodes: Value, count: Value, out: Value) -> None:
    """Zeros outside of ranges, and of nodes < 0, which do not move; the flag tells whether
    all are finite."""
    tape = _Tape(passing)
    total = c.variable(0.0)
    with c.loop(count) as i:
        node, row = nodes.load(INT, i), out.at(i * tape.width)
        with c.loop(tape.width) as j:
            row.store(0.0, j)
        with c.when(node >= 0):
            motion = tape.motion(node)
            low, high = tape.range(node)
            with c.loop(high, low) as j:
                value = motion.load(REAL, j)
                row.store(value, j)
                total.set(total.get() + value * 0.0)
    c.give(c.select(total.get().equals(0.0), c.constant(0, FLAG), c.constant(1, FLAG)))


@function("i32 pc_cv_jacobian(double t, ptr y, ptr f, ptr matrix, ptr frame, ptr a, ptr b, ptr c)")
def _cv_jacobian(
    c: Code, t: Value, y: Value, f: Value, matrix: Value, frame: Value, *room: Value
) -> None:
    """Column by column, from a point where blocks are solved once."""
    passing = frame.load(POINTER, Frame.PASSING)
    tape = _Tape(passing)
    vectors, out = (y, f), frame.load(POINTER, Frame.MATRIX).call(POINTER, matrix)
    y = frame.load(POINTER, Frame.VECTOR).call(POINTER, y)
    moved = passing.load(POINTER, Passing.MOVED)
    n = frame.load(POINTER, Frame.NUMBERS).load(INT, Number.STATES)
    flag = c.variable(c.call(FLAG, "pc_rhs", frame, t, y, moved), FLAG)
    with c.when(~flag.get().equals(0), leaves=True):
        c.give(1)
    flag.set(c.call(FLAG, "pc_pass", passing, t))
    rates = passing.load(POINTER, Passing.RATES)
    columns = passing.load(POINTER, Passing.STATE_COLUMNS)
    total = c.variable(0.0)
    with c.when(flag.get().equals(0)), c.loop(n) as i:
        with c.loop(n) as j:
            out.store(0.0, j * n + i)
        node = rates.load(INT, i)
        with c.when(node >= 0):
            motion = tape.motion(node)
            low, high = tape.range(node)
            with c.loop(n) as j:
                column = columns.load(INT, j)
                with c.when((column >= low) & (column < high)):
                    value = motion.load(REAL, column)
                    out.store(value, j * n + i)
                    total.set(total.get() + value * 0.0)
    with c.when(flag.get().equals(0) & total.get().equals(0.0), leaves=True):
        c.give(0)
    c.give(c.call(FLAG, "pc_cv_differences", t, *vectors, matrix, frame, *room))
