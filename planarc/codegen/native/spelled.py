"""Formulas as operations that take their numbers from a stack and leave their results there.

In:   a formula
Out:  its leaves and operations, one behind the other; what each operation makes of its numbers

    a*b + c        a, b, MUL, c, ADD

Promises:  operations and their order are those of `formulas`: values are equal to the last bit.
           Truths are 1.0 and 0.0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum, auto
from typing import TypeAlias

from planarc.codegen.certain import unconditional
from planarc.codegen.native.assembly import REAL, Code, Operator, Value
from planarc.codegen.native.formulas import (
    BINARY,
    COMPARED,
    TRUTHS,
    bit,
    call_function,
    is_doubtful,
    whole_power,
)
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.program import Let
from planarc.runtime import elementary


class Kind(IntEnum):
    """Operations besides those of `Op`, which have their numbers there."""

    UNORDERED = len(Op)  # whether one of two is not a number
    DOUBT = auto()  # not a number where the second one is true, else the first
    DUPLICATE = auto()
    SUBTRACT = auto()
    MULTIPLY_ADD = auto()  # a + b*c, of `carried` alone
    MULTIPLY_SUBTRACT = auto()  # a - b*c
    UNORDERED_DOUBT = auto()  # not a number where one of b and c is none, else a
    CALL = auto()  # the elementary functions from here, in the order of their table


_BINARY: dict[int, Operator] = {int(op): compute for op, compute in BINARY.items()} | {
    Op.ADD: Value.__add__,
    Kind.SUBTRACT: Value.__sub__,
    Op.MUL: Value.__mul__,
}
_TAKEN: dict[int, int] = {Op.TIME: 0, Op.NEG: 1, Op.NOT: 1, Op.IF: 3, Kind.DUPLICATE: 1,
                           Kind.MULTIPLY_ADD: 3, Kind.MULTIPLY_SUBTRACT: 3,
                           Kind.UNORDERED_DOUBT: 3}  # fmt: skip
_FUNCTIONS = {name: Kind.CALL + i for i, name in enumerate(elementary.TABLE)}
_NAMES = {number: name for name, number in _FUNCTIONS.items()}
#: What it takes to be spelled: neither calls back nor the past, nor loops.
_SPELLED = frozenset(Op) - {Op.APPLY, Op.PAST, Op.LOOP}

#: What stands in a formula so often on average is not computed again in each place.
_REPEATED = 4

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


def in_order(root: Expr) -> Iterator[Part]:
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


def choose(c: Code, kind: Value, known: Sequence[int], do: Callable[[int], None]) -> None:
    """Do what a kind asks for, which is one of those known."""
    if len(known) == 1:
        do(known[0])
        return
    half = len(known) // 2
    low, high, behind = c.label(), c.label(), c.label()
    c.branch(kind < known[half], low, high)
    for label, part in ((low, known[:half]), (high, known[half:])):
        c.begin(label)
        choose(c, kind, part, do)
        c.jump(behind)
    c.begin(behind)


def taken(kind: int) -> int:
    """How many numbers an operation takes from the stack."""
    if kind >= Kind.CALL:
        return elementary.TABLE[_NAMES[kind]].arity
    return _TAKEN.get(kind, 2)


def compute(c: Code, kind: int, numbers: list[Value], t: Value) -> Value:
    """What an operation makes of its numbers."""
    if kind >= Kind.CALL:
        return call_function(c, _NAMES[kind], numbers)
    if kind in _BINARY:
        return _BINARY[kind](*numbers)
    if kind == Kind.MULTIPLY_ADD:
        return numbers[0] + numbers[1] * numbers[2]
    if kind == Kind.MULTIPLY_SUBTRACT:
        return numbers[0] - numbers[1] * numbers[2]
    if kind == Kind.UNORDERED_DOUBT:
        unordered = c.emit("i1", f"fcmp uno double {numbers[1].text}, {numbers[2].text}")
        return c.select(unordered, math.nan, numbers[0])
    if kind in (Op.AND, Op.OR):
        a, b = (bit(c, x) for x in numbers)
        return a & b if kind == Op.AND else a | b
    if kind == Kind.UNORDERED:
        a, b = numbers
        return c.emit("i1", f"fcmp uno double {a.text}, {b.text}")
    if kind == Kind.DOUBT:
        return c.select(bit(c, numbers[1]), math.nan, numbers[0])
    if kind == Op.IF:
        return c.select(bit(c, numbers[0]), *numbers[1:])
    if kind == Op.NOT:
        return ~bit(c, numbers[0])
    if kind == Op.NEG:
        return -numbers[0]
    if kind == Op.POW:
        return c.call(REAL, "pow", *numbers)
    if kind == Op.TIME:
        return t
    return numbers[0]


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
