"""Loops of expressions and back, and their values against the same turns in Python."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.evaluate.rows import RowValues
from planarc.evaluate.value import evaluate
from planarc.ir.calculus import partial
from planarc.ir.closing import close, opened, symbols_of
from planarc.ir.expr import Expr, Exprs, Op, text
from planarc.ir.loop import LOST, MOST_TURNS, Loop
from planarc.ir.store import dumps, loads


def series(t: Exprs, first: Expr, factor: Expr) -> tuple[Loop, tuple[Expr, ...]]:
    """`while abs(d) > 1e-12 loop s := s + d; d := d*factor; end while;`"""
    s, d = t.symbol("s"), t.symbol("d")
    goes_on = t.less(t.const(1e-12), t.call("abs", d))
    loop, given = close("f", (s, d), goes_on, (t.add(s, d), t.mul(d, factor)))
    return loop, (t.zero, first, *given)


def value(e: Expr, x: float) -> float:
    return float(evaluate(e, lambda _: x))


def test_what_turns_do_not_change_is_given() -> None:
    t = Exprs()
    x = t.symbol("x")
    loop, args = series(t, t.one, t.call("exp", t.call("sin", x)))
    assert (loop.carried, loop.given) == (2, 1)
    assert [text(a) for a in args] == ["0", "1", "exp(sin(x))"]


def test_a_loop_is_the_sum_of_its_series() -> None:
    t = Exprs()
    loop, args = series(t, t.one, t.symbol("x"))
    for x in (0.0, 0.3, -0.9):
        assert value(t.loop(loop, 0, args), x) == pytest.approx(1 / (1 - x), rel=1e-11)
        assert value(t.loop(loop, loop.ended, args), x) == 1


def test_its_derivatives_are_those_of_the_sum() -> None:
    t = Exprs()
    x = t.symbol("x")
    by = partial(t, x)
    loop, args = series(t, t.one, x)
    first = by(t.loop(loop, 0, args))
    second = by(first)
    for number in (0.3, -0.5):
        assert value(first, number) == pytest.approx(1 / (1 - number) ** 2, rel=1e-9)
        assert value(second, number) == pytest.approx(2 / (1 - number) ** 3, rel=1e-8)


def test_loops_without_end_have_no_values_and_say_why() -> None:
    t = Exprs()
    y = t.symbol("y")
    loop, _ = close("f", (y,), t.less(y, t.const(5.0)), (y,))
    for first, told in ((7.0, 1), (0.0, 0), (math.nan, LOST)):
        args = (t.const(first),)
        assert value(t.loop(loop, loop.ended, args), 0) == told
        assert math.isnan(value(t.loop(loop, 0, args), 0)) == (told != 1)
    assert MOST_TURNS < 10**7  # which takes Python a second


def test_equal_loops_of_other_tables_are_equal() -> None:
    one, other = Exprs(), Exprs()
    other.symbol("something else")
    assert (
        series(one, one.one, one.symbol("x"))[0] == series(other, other.one, other.symbol("y"))[0]
    )
    y = one.symbol("y")
    loops = {close("f", (y,), one.true, (c,))[0] for c in (one.true, one.one, one.zero)}
    assert len(loops) == 3
    zeros = {close("f", (y,), one.true, (one.const(c),))[0] for c in (0.0, -0.0, math.nan)}
    assert len(zeros) == 3


def test_loops_are_stored() -> None:
    t = Exprs()
    loop, args = series(t, t.one, t.symbol("x"))
    e = partial(t, t.symbol("x"))(t.loop(loop, 0, args))
    table, read = loads(dumps((t, e), t))
    assert value(read, 0.3) == value(e, 0.3)
    assert text(read) == text(e)
    assert {n.data for n in table.all if n.op is Op.LOOP} == {
        n.data for n in t.all if n.op is Op.LOOP and n.args and n.data[0].carried > 2
    }


numbers = st.floats(-3, 3).map(lambda x: round(x, 3))


@given(
    st.lists(numbers, min_size=2, max_size=2),
    st.lists(st.lists(numbers, min_size=3, max_size=3), min_size=2, max_size=2),
    numbers,
    st.integers(0, 12),
)
def test_linear_turns(
    first: Sequence[float], rows: Sequence[Sequence[float]], x: float, turns: int
) -> None:
    """As many turns as a counter says of v := A*v + x*b."""
    t = Exprs()
    v, n, outer = (t.symbol("v1"), t.symbol("v2")), t.symbol("n"), t.symbol("x")
    following = [
        t.add(*(t.mul(t.const(a), s) for a, s in zip(row, (*v, outer), strict=True)))
        for row in rows
    ]
    goes_on = t.less(n, t.const(float(turns)))
    loop, given = close("f", (*v, n), goes_on, (*following, t.add(n, t.one)))
    args = (*map(t.const, first), t.zero, *given)
    expected = list(first)
    for _ in range(turns):
        expected = [r[0] * expected[0] + r[1] * expected[1] + r[2] * x for r in rows]
    found = [value(t.loop(loop, i, args), x) for i in range(3)]
    size = 1 + max(map(abs, expected))
    assert found == pytest.approx([*expected, turns], rel=1e-9, abs=1e-9 * size)
    if turns:
        slope = partial(t, outer)(t.loop(loop, 0, args))
        change = [0.0, 0.0]
        for _ in range(turns):
            change = [r[0] * change[0] + r[1] * change[1] + r[2] for r in rows]
        assert value(slope, x) == pytest.approx(
            change[0], rel=1e-9, abs=1e-9 * (1 + abs(change[1]))
        )


def test_a_loop_opens_to_what_it_was_closed_from() -> None:
    t = Exprs()
    loop, _ = series(t, t.one, t.symbol("x"))
    condition, following = opened(t, loop, symbols_of(t, loop))
    assert text(condition) == "1e-12 < abs($turn1)"
    assert [text(e) for e in following] == ["$turn0 + $turn1", "$turn1*$turn2"]


def test_truths_are_carried_beside_derivatives() -> None:
    """The square root by Newton's method, which ends where a truth says so; in rows, too."""
    t = Exprs()
    x, found, c = t.symbol("x"), t.symbol("found"), t.symbol("c")
    better = t.mul(t.const(0.5), t.add(x, t.div(c, x)))
    miss = t.call("abs", t.sub(t.mul(better, better), c))
    loop, given = close("f", (x, found), t.not_(found), (better, t.less(miss, t.const(1e-13))))
    slope = partial(t, c)(t.loop(loop, 0, (t.one, t.false, *given)))
    numbers = np.array([2.0, 3.0])
    assert RowValues(lambda _: numbers)(slope) == pytest.approx(0.5 / np.sqrt(numbers))
    assert value(slope, 2.0) == pytest.approx(0.5 / math.sqrt(2.0))
