"""Statements as operations on vectors, which one function carries out: a third of their code, once.

In:   statements and loops (`rolling.Roll`), and where their values are
Out:  rows of whole numbers (`packed.Rows`); the functions that carry them out

    x := a*b + c                         MULTIPLY_ADD c a b -> x
    for t: y[t] := sin(z[t])*k[t]        SIN z -> within,  MULTIPLY within k -> y

Of a loop whose times do not wait for each other each operation is done for all times at once: what
there is to decide is decided once.

All values stand in one memory, by their places reckoned from the workspace: behind it lie the area
and the memory of loops, before it constants. What only a statement itself needs lies behind what is
held in that memory, one behind the other. A row tells

    how many operations and forms it has, and the place of what lies within statements
    where the places of each `Home` begin, behind the forms
    the forms: a column of kinds, one of times, and for the result and each operand one of `_code`
    the form of each operation; then the places, one `Home` behind the other: within statements, how
    far back

Places of one home grow evenly, so that they pack well. An instance tells all operations by their
addresses when it needs the first of them, each in as many words, and goes by these.

    pc_carry(frame, t, first, count)    carries out so many operations
    pc_tell(frame)                      tells them by addresses

Promises:  operations and their order in each value are those of `formulas`: values are equal to the
           last bit. Truths are 1.0 and 0.0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from enum import IntEnum, auto
from itertools import accumulate, chain
from typing import TypeAlias

from planarc.codegen.native.assembly import INT, POINTER, REAL, SELDOM, Code, Value
from planarc.codegen.native.formulas import real
from planarc.codegen.native.packed import Rows
from planarc.codegen.native.parting import vectors
from planarc.codegen.native.rolling import Column, Roll, roll_gathered
from planarc.codegen.native.spelled import Kind, choose, compute, in_order, taken
from planarc.core.data import Data
from planarc.ir.expr import Expr, Op
from planarc.ir.frame import Frame
from planarc.ir.program import Let

#: Loops that run more often are code; where that runs seldom, those that run more often than this.
MOST, MOST_SELDOM = 64, 1000
#: Fewer operations are code: to call the function costs as much.
LEAST = 40
#: Most operands, and words of an operation.
_OPERANDS = 3
_HEAD, _FORM = 8, 3 + _OPERANDS
#: Words of an operation where all is told by addresses.
_WORDS = 4 + 2 * _OPERANDS
_BITS = 3  # of a `Home`


class Home(IntEnum):
    """Where a place lies."""

    WITHIN = 0
    SLOT = auto()
    MEMORY = auto()
    CONSTANT = auto()
    NONE = auto()  # there is no operand; of a result: behind the others within


Places: TypeAlias = "tuple[int, ...]"
#: Places, or the number of an operation of the same statement.
Operand: TypeAlias = "Places | int"


class Step(Data):
    """A statement that is carried out for all times of a loop: what stands in the place of each
    leaf, time by time, and of the target."""

    value: Expr
    target: Places
    leaves: dict[Expr, Places]


class Carrier:
    """What is carried out, and what does it. `word`: of the frame, points to the operations;
    `memory` and `area` are the distances of these arrays from the workspace; `joins`: it will
    join another one (`join`), whose rows are told where its operations begin."""

    def __init__(self, word: int, memory: int, area: int, joins: bool = False) -> None:
        self.word, self.memory, self.area, self.joins = word, memory, area, joins
        self.hurries = False  # whether it runs often
        self.room = 0  # numbers of the memory in use at once
        self.constants: list[float] = []  # from place -1 down
        self._places: dict[str, int] = {}
        self._told: list[tuple[_Told, int]] = []  # and how many constants stand before its own
        self._count = 0  # of operations

    def constant(self, value: float) -> int:
        """Where it stands."""
        key = value.hex()
        if key not in self._places:
            self.constants.append(value)
            self._places[key] = -len(self.constants)
        return self._places[key]

    def carry(self, steps: Sequence[Step], within: int) -> tuple[int, int, int]:
        """The first of the operations of statements, and how many there are; how much room there
        must be within them, from a place on."""
        told = _Told(within, self.memory)
        for step in steps:
            told.add(step, self.constant)
        self._told.append((told, 0))
        first, self._count = self._count, self._count + told.count
        return first, told.count, told.cursor - within

    def join(self, other: Carrier) -> int:
        """Carry out what another one was told, too: the first of its operations."""
        before = len(self.constants)
        self.constants += other.constants
        self._told += [(told, before + shift) for told, shift in other._told]
        self.room = max(self.room, other.room)
        first, self._count = self._count, self._count + other._count
        return first

    def values(self, lets: Sequence[Let], slot: Callable[[Expr], int]) -> tuple[int, int]:
        """The first of the operations, and how many there are, that set `memory` from its first
        number on: to the values of statements that do not read each other."""
        places = {let.target: i for i, let in enumerate(lets)}

        def spot(e: Expr) -> int:
            if e.is_const:
                return self.constant(float(e.data))
            return self.memory + places[e] if e in places else slot(e)

        rolled = roll_gathered(lets, lambda e: int(e in places), lambda e: e)
        parts = [
            part
            for s in rolled
            for short in (s.statements if isinstance(s, Roll) and _is_long(s) else (s,))
            for part in vectors(short, lambda e: e) or ()
        ]
        *told, room = self.carry(
            [step(let, target, leaves, spot) for let, target, leaves in parts],
            self.memory + len(lets),
        )
        self.room = max(self.room, len(lets) + room)
        return told[0], told[1]

    @property
    def words(self) -> int:
        """What all operations take, told by addresses."""
        return self._count * _WORDS

    def text(self, rows: Rows) -> str:
        """The functions; nothing where nothing is carried out. What they read is put among rows."""
        if not self._told:
            return ""
        even = [rows.place(tuple(k * t for t in range(MOST_SELDOM))) for k in (_SAME, _EVEN)]
        placed = tuple(rows.place(tuple(told.words(rows, even, n))) for told, n in self._told)
        begins = rows.place(placed)
        used = {kind for told, _ in self._told for kind in told.kinds}
        told = _tell(self.word, rows.word, begins, len(placed))
        return told + _carry(self.word, sorted(used), self.hurries)


#: How far places lie behind the first one: all of them there, or one behind the other.
_SAME, _EVEN = 0, 1
#: The home of a first place, and how far the others lie behind it.
_Use: TypeAlias = "tuple[int | Places, Home]"
#: An operation's kind and times, its result and operands.
_Form: TypeAlias = "tuple[int, int, tuple[_Use, ...]]"


class _Told:
    """A row, before it is known where it stands; `memory` lies so far behind the workspace."""

    def __init__(self, within: int, memory: int) -> None:
        self._within, self._memory = within, memory
        self.cursor = within
        self._forms: list[_Form] = []  # of each operation
        self._places: dict[int, list[int]] = {home: [] for home in Home}

    @property
    def count(self) -> int:
        return len(self._forms)

    @property
    def kinds(self) -> set[int]:
        return {kind for kind, *_ in self._forms}

    def words(self, rows: Rows, even: Sequence[int], before: int) -> list[int]:
        """Its numbers; `even`: where `_SAME` and `_EVEN` distances stand among the rows; `before`:
        so many constants stand before its own."""

        def code(use: _Use) -> int:
            distances, home = use
            table = even[distances] if isinstance(distances, int) else rows.place(distances)
            return table << _BITS | home

        codes = {form: (*form[:2], *map(code, form[2])) for form in dict.fromkeys(self._forms)}
        known = {told: i for i, told in enumerate(sorted(codes.values()))}
        forms = [n for part in zip(*known, strict=True) for n in part]
        constants = {Home.CONSTANT: [place - before for place in self._places[Home.CONSTANT]]}
        streams = [[known[codes[f]] for f in self._forms], *(self._places | constants).values()]
        *begins, end = accumulate(map(len, streams[:-1]))
        head = (len(streams[0]), len(known), self._within, *begins, 0)
        # Where there is no operand something is read, too.
        read = sum(home == Home.NONE for *_, uses in self._forms for _, home in uses)
        return [*head, *forms, *chain(*streams), *[0] * (read - end)]

    def add(self, step: Step, constant: Callable[[float], int]) -> None:
        """`constant`: where a number stands."""
        times = len(step.target)
        listed = _fused(_listed(step, lambda number: (constant(number),) * times))
        found: dict[int, int] = {}  # where results stand
        last = len(listed) - 1
        for i, (number, kind, operands) in enumerate(listed):
            uses = [self._use(step.target) if i == last else (_EVEN, Home.NONE)]
            for operand in operands:
                if isinstance(operand, int):
                    self._places[Home.WITHIN].append(self.cursor - found[operand])
                    uses.append((_EVEN, Home.WITHIN))
                else:
                    uses.append(self._use(operand))
            uses += [(_SAME, Home.NONE)] * (1 + _OPERANDS - len(uses))
            self._forms.append((kind, times, tuple(uses)))
            if i != last:
                found[number] = self.cursor
                self.cursor += times

    def _use(self, places: Places) -> _Use:
        first = places[0]
        home = Home.SLOT if first < self._memory else Home.MEMORY
        home = Home.CONSTANT if first < 0 else home
        self._places[home].append(first)
        distances = tuple([p - first for p in places])
        if not any(distances):
            return _SAME, home
        return _EVEN if distances == tuple(range(len(distances))) else distances, home


#: The number of an operation, its kind, its operands.
_Operation: TypeAlias = "tuple[int, int, tuple[Operand, ...]]"


def _listed(step: Step, constant: Callable[[float], Places]) -> list[_Operation]:
    """The operations of a statement; what stands in several places is done once."""
    stack: list[Operand] = []
    known: dict[tuple[int, tuple[Operand, ...]], int] = {}
    for part in in_order(step.value):
        if isinstance(part, float):
            stack.append(constant(part))
        elif isinstance(part, Expr):
            stack.append(step.leaves.get(part) or constant(float(part.data)))
        elif part == Kind.DUPLICATE:
            stack.append(stack[-1])
        else:
            first = len(stack) - taken(part)
            operands = tuple(stack[first:])
            stack[first:] = [known.setdefault((part, operands), len(known))]
    (root,) = stack
    listed = [(number, kind, operands) for (kind, operands), number in known.items()]
    return (
        listed if isinstance(root, int) else [*listed, (len(listed), int(Kind.DUPLICATE), (root,))]
    )


def _fused(listed: Sequence[_Operation]) -> list[_Operation]:
    """Products that are added to something, or taken from it, once, and numbers that are looked at
    for one doubt: two operations in one."""
    uses = Counter(o for *_, operands in listed for o in operands if isinstance(o, int))
    once = {n: (kind, operands) for n, kind, operands in listed if uses[n] == 1}
    found: list[_Operation] = []
    gone: set[int] = set()

    def is_once(operand: Operand, kind: int) -> bool:
        return isinstance(operand, int) and operand in once and once[operand][0] == kind

    for number, kind, operands in listed:
        inner = _INNER.get(kind)
        if inner is not None:
            a, b = operands
            if kind == Op.ADD and not is_once(b, inner):
                a, b = b, a
            if isinstance(b, int) and is_once(b, inner):
                gone.add(b)
                kind, operands = _BOTH[kind], (a, *once[b][1])
        found.append((number, kind, operands))
    return [o for o in found if o[0] not in gone]


#: Operations whose last operand may come from another one, its kind, and both in one.
_INNER: dict[int, int] = {Op.ADD: Op.MUL, Kind.SUBTRACT: Op.MUL, Kind.DOUBT: Kind.UNORDERED}
_BOTH: dict[int, int] = {
    Op.ADD: Kind.MULTIPLY_ADD,
    Kind.SUBTRACT: Kind.MULTIPLY_SUBTRACT,
    Kind.DOUBT: Kind.UNORDERED_DOUBT,
}


def step(let: Let, target: Column, leaves: Sequence[Column], spot: Callable[[Expr], int]) -> Step:
    """A statement by the places of what it sets and reads."""
    found = {column[0]: tuple(map(spot, column)) for column in leaves}
    return Step(let.value, tuple(map(spot, target)), found)


def _is_long(run: Roll) -> bool:
    return len(run.targets[0]) > MOST_SELDOM


def _carry(word: int, kinds: Sequence[int], hurries: bool) -> str:
    c = Code("pc_carry", "void", _ARGUMENTS)
    frame, t, first, count = c.arguments
    listed = frame.load(POINTER, word).at(first * _WORDS)
    with c.when(listed.load(INT).equals(0)):
        c.run("pc_tell", frame)
    with c.loop(count) as i:
        operation = listed.at(i * _WORDS)
        kind, times = operation.load(INT), operation.load(INT, 1)
        to, where, *told = (operation.load(POINTER, k) for k in range(2, _WORDS))
        operands = tuple(zip(told[::2], told[1::2], strict=True))

        def do(
            kind: int, times: Value = times, to: Value = to, where: Value = where,
            operands: Sequence[tuple[Value, Value]] = operands,
        ) -> None:  # fmt: skip
            with c.loop(times) as j:
                numbers = [p.load(REAL, d.load(INT, j)) for p, d in operands[: taken(kind)]]
                value = compute(c, kind, numbers, t)
                to.store(real(c, value), where.load(INT, j))

        choose(c, kind, kinds, do)
    c.give()
    return c.text("" if hurries else SELDOM)


def _tell(word: int, shared: int, begins: int, count: int) -> str:
    """Tell all operations by the addresses of what they read and set, once for an instance."""
    c = Code("pc_tell", "void", ((POINTER, "frame"),))
    (frame,) = c.arguments
    w, rows = frame.load(POINTER, Frame.W), frame.load(POINTER, shared)
    out, places = c.variable(frame.load(POINTER, word), POINTER), c.place(INT, len(Home))
    with c.loop(count) as which:
        row = rows.at(rows.at(begins).load(INT, which))
        forms, cursor = row.load(INT, 1), c.variable(row.load(INT, 2), INT)
        table = row.at(_HEAD)
        first = table.at(forms * _FORM)
        for each in Home:
            places.store(row.load(INT, each + 3), int(each))
        with c.loop(row.load(INT)) as i:
            here, form, to = cursor.get(), table.at(first.load(INT, i)), out.get()
            times = form.at(forms).load(INT)
            to.store(form.load(INT))
            to.store(times, 1)
            with c.loop(_OPERANDS + 1) as k:
                code = form.at(forms * (k + 2)).load(INT)
                home = c.emit(INT, f"and i64 {code.text}, {(1 << _BITS) - 1}")
                at = places.load(INT, home)
                places.store(at + 1, home)
                place = first.load(INT, at)
                behind = home.equals(Home.NONE)
                begin = c.select(home.equals(Home.WITHIN), here - place, place)
                begin = c.select(behind, here, begin)
                to.at(k * 2).store(w.at(begin), 2)
                number = c.emit(INT, f"lshr i64 {code.text}, {_BITS}")
                to.at(k * 2).store(rows.at(number), 3)
                with c.when(behind & k.equals(0)):
                    cursor.set(here + times)
            out.set(to.at(_WORDS))
    c.give()
    return c.text(SELDOM)


_ARGUMENTS = ((POINTER, "frame"), (REAL, "t"), (INT, "first"), (INT, "count"))
DECLARED = "declare void @pc_carry(ptr, double, i64, i64)\n"
