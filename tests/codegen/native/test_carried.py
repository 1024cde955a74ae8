"""Statements that one function carries out: their values are those of their code, bit by bit."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from planarc.codegen.native.assembly import FLAG, POINTER, REAL, Code, Value
from planarc.codegen.native.carried import Carrier
from planarc.codegen.native.formulas import declarations, formula, real
from planarc.codegen.native.packed import Rows
from planarc.codegen.native.spelled import is_spelled
from planarc.ir.expr import Expr, Exprs
from planarc.ir.frame import Frame
from planarc.ir.program import Let
from planarc.runtime import elementary
from planarc.runtime.link import PLACES

pytest.importorskip("llvmlite")
if not PLACES:
    pytest.skip("code is placed by LLVM here", allow_module_level=True)

from planarc.codegen.native.machine import emit_object
from planarc.codegen.native.processor import target_machine
from planarc.runtime.link.memory import place

NAMES = ("time", "a", "b", "c", "$hidden")
ROWS, OPERATIONS = len(Frame), len(Frame) + 1
SPECIAL = (0.0, -0.0, 1.5, -2.25, 1e300, np.inf, -np.inf, np.nan)


def formulas(t: Exprs) -> list[Expr]:
    """At least one of each operation, and of each elementary function."""
    a, b, c, hidden = (t.symbol(name) for name in NAMES[1:])
    less, sum_ = t.less(a, b), t.add(a, b)
    powers = (t.const(n) for n in (2.0, 3.0, 7.0, 16.0, 17.0, -1.0, -3.0, 0.5))
    return [
        t.add(a, b, c),
        t.sub(a, t.mul(b, c)),
        t.add(t.neg(a), b, t.neg(c)),
        t.add(t.neg(a), t.neg(t.mul(b, c))),
        t.mul(t.const(3.0), a, t.neg(b), c),
        t.neg(sum_),
        t.div(a, t.add(b, c)),
        *(t.pow(sum_, power) for power in powers),
        t.pow(a, b),
        t.if_(less, a, t.mul(b, c)),
        t.if_(t.and_(less, t.not_(t.less_equal(b, c))), t.one, t.time),
        t.if_(t.or_(t.equal(a, b), t.less(c, t.one)), t.if_(t.less(a, c), a, b), c),
        t.if_(hidden, a, b),
        t.not_(hidden),
        less,
        t.true,
        *(t.call(name, *(a, b)[: row.arity]) for name, row in elementary.TABLE.items()),
        *(t.sub(t.mul(t.const(k + 0.5), a), t.mul(b, c)) for k in range(20)),  # a loop
    ]


def carried_out(points: np.ndarray, joined: bool) -> tuple[np.ndarray, np.ndarray]:
    """The values at each point, by their code and carried out."""
    t = Exprs()
    values = formulas(t)
    homes = {t.symbol(name): i for i, name in enumerate(NAMES)}
    lets = [Let(t.symbol(f"r{i}"), value) for i, value in enumerate(values)]
    assert is_spelled(lets)
    carrier, rows = Carrier(OPERATIONS, len(NAMES), 0), Rows(ROWS)
    if joined:  # what was told elsewhere, behind operations and constants of its own
        other = Carrier(OPERATIONS, len(NAMES), 0, joins=True)
        first, count = other.values(lets, homes.__getitem__)
        carrier.values([Let(t.symbol("q"), t.const(0.375))], homes.__getitem__)
        first += carrier.join(other)
    else:
        first, count = carrier.values(lets, homes.__getitem__)
    c = Code("pc_straight", FLAG, ((POINTER, "frame"), (REAL, "t"), (POINTER, "results")))
    w = c.arguments[0].load(POINTER, Frame.W)

    def leaf(e: Expr) -> Value:
        return c.arguments[1] if e is t.time else w.load(REAL, homes[e])

    for i, e in enumerate(values):
        c.arguments[2].store(real(c, formula(c, e, leaf)), i)
    c.give(0)
    text = declarations() + c.text() + carrier.text(rows)
    memory, addresses = place([emit_object(text, target_machine(1), ("pc_",))], {})
    numbers = np.array(rows.numbers, dtype=np.int64)
    operations = np.zeros(carrier.words, dtype=np.int64)
    constants = carrier.constants[::-1]
    found = np.empty((2, len(points), len(values)))
    for k, point in enumerate(points):
        held = np.concatenate((constants, point, np.full(carrier.room, np.nan)))
        w = held[len(constants) :]
        frame = np.zeros(OPERATIONS + 1, dtype=np.int64)
        frame[Frame.W], frame[ROWS] = w.ctypes.data, numbers.ctypes.data
        frame[OPERATIONS] = operations.ctypes.data
        operations[:] = 0  # they are told by addresses
        at = ctypes.c_void_p(frame.ctypes.data), ctypes.c_double(point[0])
        straight = ctypes.c_void_p(found[0, k].ctypes.data)
        ctypes.CFUNCTYPE(None)(addresses["pc_straight"])(*at, straight)
        for _ in range(2):  # once they are told, and again
            w[len(NAMES) :] = np.nan
            told = ctypes.c_int64(first), ctypes.c_int64(count)
            ctypes.CFUNCTYPE(None)(addresses["pc_carry"])(*at, *told)
            found[1, k] = w[len(NAMES) :][: len(values)]
    del memory  # not before
    return found[0], found[1]


@pytest.mark.parametrize("joined", [False, True])
def test_values_are_equal_to_the_last_bit(joined: bool) -> None:
    points = np.array([[2.5, a, b, c, h] for a in SPECIAL for b in SPECIAL for c in SPECIAL[2:]
                       for h in (0.0, 1.0, np.nan)])  # fmt: skip
    by_code, spelled = carried_out(points, joined)
    nan = np.isnan(by_code)
    assert np.array_equal(nan, np.isnan(spelled))
    assert np.array_equal(by_code[~nan].view(np.int64), spelled[~nan].view(np.int64))
    assert (~nan).any(axis=0).all() and nan.any()


def test_what_calls_back_or_looks_into_the_past_is_not_spelled() -> None:
    t = Exprs()
    x = t.symbol("x")
    assert is_spelled([Let(x, t.add(x, t.time))])
    assert not is_spelled([Let(x, t.add(x, t.past(0, t.time)))])


def test_what_stands_in_a_formula_again_and_again_is_not_spelled() -> None:
    """It would be computed a billion times."""
    t = Exprs()
    e = t.symbol("x")
    for _ in range(30):
        e = t.div(e, t.add(e, t.one))
    assert not is_spelled([Let(t.symbol("y"), e)])
