"""Array operators and built-in functions agree with NumPy, entry by entry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import NOWHERE
from planarc.ir.expr import Exprs
from planarc.lower import builtins
from planarc.lower.operators import binary
from planarc.lower.scope import Model, Scope
from planarc.lower.values import Value, exprs
from planarc.runtime.tensor import Tensor, shape_of

numbers = st.integers(-5, 5).map(float)


def scope() -> Scope:
    return Scope(Model(Exprs(), {}))


def lifted(at: Scope, array: NDArray[np.float64]) -> Value:
    """A NumPy array (or number) as a value."""
    items = tuple(at.table.const(float(x)) for x in array.flat)
    return Tensor(array.shape, items) if array.shape else items[0]


def lowered(value: Value) -> NDArray[np.float64]:
    return np.array([e.data for e in exprs(value)], dtype=float).reshape(shape_of(value))


def arrays(*shape: int) -> st.SearchStrategy[NDArray[np.float64]]:
    size = int(np.prod(shape))
    return st.lists(numbers, min_size=size, max_size=size).map(
        lambda xs: np.array(xs, dtype=float).reshape(shape)
    )


@given(arrays(3), arrays(3))
def test_vectors(a: NDArray[np.float64], b: NDArray[np.float64]) -> None:
    at = scope()
    x, y = lifted(at, a), lifted(at, b)
    assert np.array_equal(lowered(binary(at, "+", x, y, NOWHERE)), a + b)
    assert np.array_equal(lowered(binary(at, ".*", x, y, NOWHERE)), a * b)
    assert lowered(binary(at, "*", x, y, NOWHERE)) == a @ b
    assert np.array_equal(lowered(builtins.call(at, "cross", (x, y), NOWHERE)), np.cross(a, b))
    assert np.array_equal(
        lowered(builtins.call(at, "outerProduct", (x, y), NOWHERE)), np.outer(a, b)
    )
    turned = binary(at, "*", builtins.call(at, "skew", (x,), NOWHERE), y, NOWHERE)
    assert np.array_equal(lowered(turned), np.cross(a, b))


@given(arrays(2, 3), arrays(3, 2), arrays(2), arrays(3))
def test_matrices(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    left: NDArray[np.float64],
    right: NDArray[np.float64],
) -> None:
    at = scope()
    m, n = lifted(at, a), lifted(at, b)
    assert np.array_equal(lowered(binary(at, "*", m, n, NOWHERE)), a @ b)
    assert np.array_equal(lowered(binary(at, "*", lifted(at, left), m, NOWHERE)), left @ a)
    assert np.array_equal(lowered(binary(at, "*", m, lifted(at, right), NOWHERE)), a @ right)
    assert np.array_equal(lowered(builtins.call(at, "transpose", (m,), NOWHERE)), a.T)
    assert lowered(builtins.call(at, "sum", (m,), NOWHERE)) == a.sum()
    assert lowered(builtins.call(at, "max", (m,), NOWHERE)) == a.max()


@given(arrays(2, 2), st.integers(0, 4))
def test_power_of_a_matrix(a: NDArray[np.float64], n: int) -> None:
    at = scope()
    value = binary(at, "^", lifted(at, a), at.table.const(n), NOWHERE)
    assert np.array_equal(lowered(value), np.linalg.matrix_power(a, n))


@given(arrays(2, 3), arrays(2, 3))
def test_cat(a: NDArray[np.float64], b: NDArray[np.float64]) -> None:
    at = scope()
    for axis in (1, 2):
        value = builtins.call(
            at, "cat", (at.table.const(axis), lifted(at, a), lifted(at, b)), NOWHERE
        )
        assert np.array_equal(lowered(value), np.concatenate([a, b], axis - 1))


def test_constructors() -> None:
    at = scope()
    two, three = at.table.const(2), at.table.const(3)
    assert np.array_equal(lowered(builtins.call(at, "identity", (three,), NOWHERE)), np.eye(3))
    assert np.array_equal(
        lowered(builtins.call(at, "ones", (two, three), NOWHERE)), np.ones((2, 3))
    )
    points = builtins.call(at, "linspace", (two, three, at.table.const(5)), NOWHERE)
    assert np.array_equal(lowered(points), np.linspace(2, 3, 5))
    empty = builtins.call(at, "zeros", (at.table.const(0), two), NOWHERE)
    assert shape_of(empty) == (0, 2)
    assert lowered(builtins.call(at, "sum", (empty,), NOWHERE)) == 0


def test_division_by_the_number_zero_is_an_error() -> None:
    at = scope()
    with pytest.raises(PlanarcError, match="division by zero"):
        binary(at, "/", at.table.time, at.table.zero, NOWHERE)


def test_equal_relations_share_one_event() -> None:
    at = scope()
    t = at.table
    at.model.parameters.add("p")
    x, p = t.symbol("x"), t.symbol("p")
    first = binary(at, "<", x, p, NOWHERE)
    assert first is binary(at, ">", p, x, NOWHERE)
    assert first is not binary(at, "<=", x, p, NOWHERE)
    assert len(at.model.relations) == 2
    assert binary(at.without_events(), "<", x, p, NOWHERE) is t.less(x, p)
    assert binary(at, "<", p, t.const(2), NOWHERE) is t.less(p, t.const(2.0))


def test_relations_of_time_alone_are_time_events() -> None:
    at = scope()
    t = at.table
    binary(at, ">=", t.time, t.const(1.5), NOWHERE)
    binary(at, ">=", t.symbol("x"), t.time, NOWHERE)
    assert [r.time_only for r in at.model.relations] == [True, False]
