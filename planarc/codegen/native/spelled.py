"""Statements as whole numbers that one function carries out: a third of what their code takes.

In:   statements that run seldom, and where their values are
Out:  a row of numbers (`packed.Rows`); the function that carries such rows out

    x := a*b + c        read a, read b, MUL, read c, ADD, set x

Each operation takes its numbers from a stack and leaves its result there. The operations of a row
stand first, then the places that they read and set, each by its distance from the last one in the
same memory. Both are sums of all up to there, which `packed` stores as what is told here.

    pc_carry_out(frame, t, results, memory, first, count)

carries out `count` operations, which begin at the number `first` of the shared rows.

Promises:  operations and their order are those of `formulas`: values are equal to the last bit.
           Truths are 1.0 and 0.0.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum, auto
from itertools import accumulate
from typing import TypeAlias

from planarc.codegen.certain import unconditional
from planarc.codegen.native.assembly import INT, POINTER, REAL, SELDOM, Code, Operator, Value, table
from planarc.codegen.native.formulas import (
    BINARY,
    COMPARED,
    TRUTHS,
    bit,
    call_function,
    is_doubtful,
    real,
    whole_power,
)
from planarc.codegen.native.packed import Rows
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.frame import Frame
from planarc.ir.program import Let
from planarc.runtime import elementary


class Home(IntEnum):
    """Memories."""

    WORKSPACE = 0
    MEMORY = auto()  # of temporaries
    RESULTS = auto()
    CONSTANTS = auto()


class Kind(IntEnum):
    """Operations besides those of `Op`, which have their numbers there."""

    READ = len(Op)  # from each of `Home`
    SET = READ + len(Home)
    UNORDERED = SET + len(Home)  # whether one of two is not a number
    DOUBT = auto()  # not a number where the second one is true, else the first
    DUPLICATE = auto()
    SUBTRACT = auto()
    CALL = auto()  # the elementary functions from here, in the order of their table


_BINARY: dict[int, Operator] = {int(op): compute for op, compute in BINARY.items()} | {
    Op.ADD: Value.__add__,
    Kind.SUBTRACT: Value.__sub__,
    Op.MUL: Value.__mul__,
}
_TAKEN: dict[int, int] = {Op.TIME: 0, Op.NEG: 1, Op.NOT: 1, Op.IF: 3, Kind.DUPLICATE: 1}
_FUNCTIONS = {name: Kind.CALL + i for i, name in enumerate(elementary.TABLE)}
_NAMES = {number: name for name, number in _FUNCTIONS.items()}
#: What it takes to be spelled: neither calls back nor the past.
_SPELLED = frozenset(Op) - {Op.APPLY, Op.PAST}

#: What stands in a formula so often on average is not computed again in each place.
_REPEATED = 4

Place = tuple[Home, int]
#: An operation, a number or what is to be spelled.
Part: TypeAlias = int | float | Expr


def is_spelled(lets: Sequence[Let]) -> bool:
    """Whether statements can be, and in about as many operations as they have: what a formula has
    in several places is computed in each of them."""
    for let in lets:
        nodes = postorder((let.value,))
        sizes: dict[Expr, int] = {}
        for e in nodes:
            if e.op not in _SPELLED:
                return False
            sizes[e] = 1 + sum(sizes[a] for a in e.args)
        if sizes[let.value] > _REPEATED * len(nodes):
            return False
    return True


class Speller:
    """The rows of a library, and what carries them out. Lists whose statements are equal `most`
    times and more take less room as loops, where each library has rows of its own."""

    def __init__(self, rows: Rows, most: float = 8) -> None:
        self.rows, self.most = rows, most
        self._used: set[int] = set()
        self._constants: dict[int, int] = {}  # by their bits
        self._deepest = 0

    def spell(self, lets: Sequence[Let], place: Callable[[Expr], Place]) -> tuple[int, int]:
        """Where the row of these statements begins, and how many operations it has."""
        operations: list[int] = []
        places: list[int] = []
        last = [0] * len(Home)

        def use(first: int, home: Home, index: int) -> None:
            operations.append(first + home)
            places.append(index - last[home])
            last[home] = index

        for let in lets:
            for part in _in_order(let.value):
                if isinstance(part, int):
                    operations.append(part)
                elif isinstance(part, float) or part.is_const:
                    value = part if isinstance(part, float) else float(part.data)
                    use(Kind.READ, Home.CONSTANTS, self._constant(value))
                else:
                    use(Kind.READ, *place(part))
            use(Kind.SET, *place(let.target))
        self._used.update(operations)
        self._deepest = max(self._deepest, _depth(operations))
        return self.rows.place((*accumulate(operations), *accumulate(places))), len(operations)

    def _constant(self, value: float) -> int:
        (bits,) = struct.unpack("<q", struct.pack("<d", value))
        return self._constants.setdefault(bits, len(self._constants))

    def text(self) -> str:
        """The function and its constants; nothing where nothing was spelled."""
        if not self._used:
            return ""
        return table(_CONSTANTS, self._constants) + self._carry_out()

    def _carry_out(self) -> str:
        c = Code("pc_carry_out", "void", _ARGUMENTS)
        frame, t, results, memory, first, count = c.arguments
        operations = frame.load(POINTER, self.rows.word).at(first)
        places = operations.at(count)
        memories = (
            frame.load(POINTER, Frame.W),
            memory,
            results,
            Value(c, POINTER, f"@{_CONSTANTS}"),
        )
        cursors = [c.variable(0, INT) for _ in memories]
        stack, top = c.place(REAL, self._deepest), c.variable(0, INT)
        last, told, at = (c.variable(0, INT) for _ in range(3))

        def do(kind: int) -> None:
            n = top.get() - _taken(kind)
            numbers = [stack.load(REAL, n + i) for i in range(_taken(kind))]
            if Kind.READ <= kind < Kind.UNORDERED:
                home = (kind - Kind.READ) % len(Home)
                place = places.load(INT, at.get())
                cursors[home].set(cursors[home].get() + place - told.get())
                told.set(place)
                at.set(at.get() + 1)
                if kind >= Kind.SET:
                    memories[home].store(numbers[0], cursors[home].get())
                    top.set(n)
                    return
                numbers = [memories[home].load(REAL, cursors[home].get())]
            for value in _values(c, kind, numbers, t):
                stack.store(real(c, value), n)
                n = n + 1
            top.set(n)

        with c.loop(count) as i:
            operation = operations.load(INT, i)
            kind = operation - last.get()
            last.set(operation)
            _choose(c, kind, sorted(self._used), do)
        c.give()
        return c.text(SELDOM)


DECLARED = "declare void @pc_carry_out(ptr, double, ptr, ptr, i64, i64)\n"
_CONSTANTS = "pc_constants"
_ARGUMENTS = ((POINTER, "frame"), (REAL, "t"), (POINTER, "results"), (POINTER, "memory"),
              (INT, "first"), (INT, "count"))  # fmt: skip


def _in_order(root: Expr) -> Iterator[Part]:
    """Leaves and operations, as the stack wants them."""
    stack: list[Part] = [root]
    truths = [e for e in postorder((root,)) if e.op in TRUTHS and is_doubtful(e)]
    certain = unconditional(root) if truths else ()
    for e in truths:
        if e in certain:
            asked = e.args if e.op in COMPARED else e.args[:1] * 2
            stack += (*asked, Kind.UNORDERED, Kind.DOUBT)
    stack.reverse()
    while stack:
        part = stack.pop()
        if isinstance(part, Expr) and (part.args or part.op is Op.TIME):
            stack.extend(reversed(_parts(part)))
        else:
            yield part


def _choose(c: Code, kind: Value, known: Sequence[int], do: Callable[[int], None]) -> None:
    """Do what a kind asks for, which is one of those known."""
    if len(known) == 1:
        do(known[0])
        return
    half = len(known) // 2
    low, high, behind = c.label(), c.label(), c.label()
    c.branch(kind < known[half], low, high)
    for label, part in ((low, known[:half]), (high, known[half:])):
        c.begin(label)
        _choose(c, kind, part, do)
        c.jump(behind)
    c.begin(behind)


def _taken(kind: int) -> int:
    """How many numbers an operation takes from the stack."""
    if kind >= Kind.CALL:
        return elementary.TABLE[_NAMES[kind]].arity
    if Kind.READ <= kind < Kind.UNORDERED:
        return int(kind >= Kind.SET)
    return _TAKEN.get(kind, 2)


def _left(kind: int) -> int:
    """How many it leaves there."""
    if Kind.SET <= kind < Kind.UNORDERED:
        return 0
    return 2 if kind == Kind.DUPLICATE else 1


def _values(c: Code, kind: int, numbers: list[Value], t: Value) -> Iterator[Value]:
    """What an operation makes of its numbers."""
    if kind >= Kind.CALL:
        yield call_function(c, _NAMES[kind], numbers)
    elif kind in _BINARY:
        yield _BINARY[kind](*numbers)
    elif kind in (Op.AND, Op.OR):
        a, b = (bit(c, x) for x in numbers)
        yield a & b if kind == Op.AND else a | b
    elif kind == Kind.UNORDERED:
        a, b = numbers
        yield c.emit("i1", f"fcmp uno double {a.text}, {b.text}")
    elif kind == Kind.DOUBT:
        yield c.select(bit(c, numbers[1]), math.nan, numbers[0])
    elif kind == Op.IF:
        yield c.select(bit(c, numbers[0]), *numbers[1:])
    elif kind == Op.NOT:
        yield ~bit(c, numbers[0])
    elif kind == Op.NEG:
        yield -numbers[0]
    elif kind == Op.POW:
        yield c.call(REAL, "pow", *numbers)
    elif kind == Op.TIME:
        yield t
    else:  # what is read once, or twice from the stack
        yield from numbers * _left(kind)


def _parts(e: Expr) -> list[Part]:
    """Arguments and operations, one behind the other."""
    args = list(e.args)
    match e.op:
        case Op.ADD:
            if args[0].op is Op.NEG:
                args[:2] = args[1::-1]
            found: list[Part] = [args[0]]
            for term in args[1:]:
                negative = term.op is Op.NEG
                found += (term.args[0] if negative else term, Kind.SUBTRACT if negative else Op.ADD)
            return found
        case Op.MUL:
            return [args[0], *(part for factor in args[1:] for part in (factor, Op.MUL))]
        case Op.POW if n := whole_power(args[1]):
            product = _product(args[0], abs(n))
            return product if n > 0 else [1.0, *product, Op.DIV]
        case Op.POW:
            return [*args, Op.POW]
        case Op.CALL:
            return [*args, _FUNCTIONS[e.data]]
    return [*args, int(e.op)]


def _product(x: Expr, n: int) -> list[Part]:
    """x^n by squaring, as `formulas` writes it."""
    if n == 1:
        return [x]
    if n % 2:
        return [*_product(x, n - 1), x, Op.MUL]
    return [*_product(x, n // 2), Kind.DUPLICATE, Op.MUL]


def _depth(operations: Sequence[int]) -> int:
    return max(accumulate(_left(kind) - _taken(kind) for kind in operations))
