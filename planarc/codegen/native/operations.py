"""The operations of an eliminated block as a table that one function carries out.

In:   Direct
Out:  a row of whole numbers (`packed.Rows`); the function that carries such rows out

    values, operations, tears: how many of each
    the slots of the values
    of each operation a, then of each b, then of each c, for a + b*c
    the slots of the tears, then of each its number

Numbers stand one behind the other in memory: first the values, then what operations give. An
operation tells each of its own by how far that stands before its result, twice that for b, and one
more where its product is subtracted; nothing is added to where a is 0, and c is 1 where it is 0. Of
an inverse, 1/a, c is -1. So equal links of a mechanism give equal numbers, which pack well. The
operations of tears are told as in `ir.sparse`.

    pc_operate(w, row, memory)

Operations that wait for as many others stand together, by their kinds: each of them is ready
before the next one asks for it, and what a processor expects of it comes true.

Promises:  values are equal to the last bit to those of the operations in their own order: nothing
           is added by -0.0, which leaves every number as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from planarc.codegen.native.assembly import BIT, INT, REAL, Code, Value, function
from planarc.codegen.native.sparse import value_slots
from planarc.ir.expr import text
from planarc.ir.program import Direct
from planarc.ir.sparse import operations_of

#: Indices of a, b and c, or what stands in their place; whether the product is subtracted.
_Operation: TypeAlias = "tuple[int, int, int, bool]"

_NOTHING, _INVERSE = -1, -2


def room(direct: Direct) -> int:
    """How many numbers stand in memory at once."""
    return len(direct.values) + len(direct.operations)


def operation_row(direct: Direct, slots: Mapping[str, int]) -> Iterator[int]:
    """The row of a block."""
    count = len(direct.values)
    listed, moved = _by_depth([*_operations(direct)], count)
    yield from (count, len(listed), len(direct.tears))
    yield from value_slots(direct, slots)
    for which in range(3):
        for at, operation in enumerate(listed, count):
            a, b, c, negative = operation
            if which == 1:
                yield 2 * (at - b) + negative if c != _INVERSE else 0
            elif which == 2:
                yield -1 if c == _INVERSE else 0 if c == _NOTHING else at - c
            else:
                yield 0 if a == _NOTHING else at - a
    yield from (slots[text(tear)] for tear in direct.unknowns[: len(direct.tears)])
    for ref in direct.tears:
        number = ref >> 1
        yield 2 * (number if number < count else moved[number - count]) + (ref & 1)


def _operations(direct: Direct) -> Iterator[_Operation]:
    for a, negative, factors in operations_of(direct):
        first = _NOTHING if a is None else a
        if not factors:
            yield first, _NOTHING, _INVERSE, False
        else:
            b, *rest = factors
            yield first, b, rest[0] if rest else _NOTHING, negative


def _by_depth(listed: Sequence[_Operation], count: int) -> tuple[list[_Operation], dict[int, int]]:
    """The operations in the order told above; where each number stands then."""
    depths: list[int] = []
    for a, b, c, _ in listed:
        known = (depths[i - count] for i in (a, b, c) if i >= count)
        depths.append(1 + max(known, default=-1))

    def rank(i: int) -> tuple[object, ...]:
        a, b, c, negative = listed[i]
        return depths[i], c == _INVERSE, a == _NOTHING, c == _NOTHING, negative, (
            a >= count, b >= count, c >= count), i  # fmt: skip

    order = sorted(range(len(listed)), key=rank)
    moved = {i: at for at, i in enumerate(order, count)}

    def place(i: int) -> int:
        return i if i < count else moved[i - count]

    found = [
        (place(a), place(b), place(c), negative)
        for a, b, c, negative in map(listed.__getitem__, order)
    ]
    return found, moved


@function("void pc_operate(ptr w, ptr row, ptr memory)")
def operate_function(c: Code, w: Value, row: Value, memory: Value) -> None:
    count, operations, tears = (row.load(INT, i) for i in range(3))
    slots = row.at(3)
    with c.loop(count) as i:
        memory.store(w.load(REAL, slots.load(INT, i)), i)
    first = slots.at(count)
    second = first.at(operations)
    third = second.at(operations)
    out = memory.at(count)
    with c.loop(operations) as i:
        to = out.at(i)
        back, other = first.load(INT, i), third.load(INT, i)
        inverse, behind = c.label(), c.label()
        product = c.label()
        a = _before(c, to, back, -0.0)
        c.branch(other < 0, inverse, product)
        c.begin(inverse)
        to.store(c.constant(1.0, REAL) / a)
        c.jump(behind)
        c.begin(product)
        told = second.load(INT, i)
        b = to.load(REAL, _half(c, told).negative())
        term = b * _before(c, to, other, 1.0)
        to.store(c.select(_is_odd(c, told), a - term, a + term))
        c.jump(behind)
        c.begin(behind)
    places = third.at(operations)
    with c.loop(tears) as i:
        ref = places.at(tears).load(INT, i)
        value = memory.load(REAL, _half(c, ref))
        w.store(c.select(_is_odd(c, ref), -value, value), places.load(INT, i))
    c.give()


def _before(c: Code, to: Value, distance: Value, otherwise: float) -> Value:
    """The number that far before."""
    found = to.load(REAL, distance.negative())
    return c.select(distance.equals(0), otherwise, found)


def _half(c: Code, number: Value) -> Value:
    return c.emit(INT, f"ashr i64 {number.text}, 1")


def _is_odd(c: Code, number: Value) -> Value:
    return c.emit(BIT, f"trunc i64 {number.text} to i1")
