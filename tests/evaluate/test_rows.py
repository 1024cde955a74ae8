"""Values over many rows: numbers where nothing changes, arrays elsewhere, nan without a value."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st

from planarc.evaluate.rows import RowValues
from planarc.evaluate.value import apply_function, evaluate
from planarc.ir.closing import close
from planarc.ir.expr import Expr, Exprs

ROWS = np.array([0.5, 1.0, 2.0])


def values(x: Expr, number: float = 3.0) -> RowValues:
    return RowValues(lambda e: ROWS if e is x else number)


def test_what_never_changes_is_a_number() -> None:
    t = Exprs()
    x, p = t.symbol("x"), t.symbol("p")
    value = values(x)
    for e in (t.add(p, t.one), t.div(p, t.const(2)), t.pow(p, p), t.call("sqrt", p)):
        assert isinstance(value(e), float)
        assert value(e) == evaluate(e, lambda _: 3.0)
    assert isinstance(value(t.mul(p, x)), np.ndarray)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_without_a_value_there_is_nan() -> None:
    t = Exprs()
    x, p = t.symbol("x"), t.symbol("p")
    value = values(x, -1.0)
    assert math.isnan(value(t.call("sqrt", p)))
    assert math.isnan(value(t.call("mod", p, t.zero)))
    assert value(t.div(p, t.zero)) == -math.inf
    assert np.isnan(value(t.call("log", t.mul(p, x)))).all()
    chosen = t.if_(t.less(x, t.one), t.call("sqrt", t.sub(x, t.one)), x)
    assert np.array_equal(value(chosen), [math.nan, 1.0, 2.0], equal_nan=True)


def test_shared_nodes_are_evaluated_once() -> None:
    t = Exprs()
    x = t.symbol("x")
    asked: list[Expr] = []

    def leaf(e: Expr) -> np.ndarray:
        asked.append(e)
        return ROWS

    value = RowValues(leaf)
    shared = t.call("sin", x)
    assert np.array_equal(value(t.add(shared, x)), np.sin(ROWS) + ROWS)
    assert np.array_equal(value(t.mul(shared, shared)), np.sin(ROWS) ** 2)
    assert asked == [x]


def test_a_power_without_a_real_value_is_refused() -> None:
    t = Exprs()
    e = t.pow(t.symbol("p"), t.const(0.5))
    with pytest.raises(ValueError, match="power of a negative number"):
        evaluate(e, lambda _: -2.0)


@drawn(st.lists(st.floats(-3, 3) | st.just(math.nan), min_size=1, max_size=8))
def test_rows_take_the_turns_of_loops_together(xs: list[float]) -> None:
    """As often as each of them does alone; from 2 on there is no end, below -2 no number."""
    t = Exprs()
    x, s, n = t.symbol("x"), t.symbol("s"), t.symbol("n")
    limit = t.call("sqrt", t.add(x, t.const(2.0)))
    goes_on = t.less(t.mul(t.const(0.01), limit), t.call("abs", s))
    following = (t.mul(s, t.div(x, t.const(2.0))), t.add(n, t.one))
    loop, given = close("f", (s, n), goes_on, following)
    args = (x, t.zero, *given)
    values = RowValues(lambda _: np.array(xs))
    with np.errstate(invalid="ignore"):
        found = [values(t.loop(loop, i, args)) for i in range(3)]
        alone = [[evaluate(t.loop(loop, i, args), lambda _, v=v: v, _careful) for v in xs]
                 for i in range(3)]  # fmt: skip
    assert np.array(found) == pytest.approx(np.array(alone), nan_ok=True)


def _careful(e: Expr, arguments: Sequence[float]) -> float:
    """The value of a function, nan where it has none."""
    try:
        return float(apply_function(e, arguments))
    except ValueError:
        return math.nan
