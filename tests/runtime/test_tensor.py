"""The functions that build arrays give what NumPy gives, on whatever they are handed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc.flatten.values.compute import Numbers, nested, tensor_of
from planarc.ir.expr import Exprs
from planarc.runtime import tensor
from planarc.runtime.tensor import TooLarge, each

A = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
S = np.array([[1.0, 2.0], [7.0, 3.0]])
U, V = np.array([1.0, 2.0, 4.0]), np.array([3.0, 5.0, 8.0])

CASES: list[tuple[str, tuple[Any, ...], Any]] = [
    ("zeros", (2, 3), np.zeros((2, 3))),
    ("ones", (2,), np.ones(2)),
    ("fill", (7.0, 2, 2), np.full((2, 2), 7.0)),
    ("identity", (3,), np.eye(3)),
    ("diagonal", (U,), np.diag(U)),
    ("linspace", (2.0, 3.0, 5), np.linspace(2, 3, 5)),
    ("transpose", (A,), A.T),
    ("cross", (U, V), np.cross(U, V)),
    ("skew", (U,), np.cross(np.eye(3), U)),
    ("outerProduct", (U, V), np.outer(U, V)),
    ("symmetric", (S,), np.array([[1.0, 2.0], [2.0, 3.0]])),
    ("scalar", (np.array([[5.0]]),), np.array(5.0)),
    ("vector", (A[:1],), A[0]),
    ("matrix", (U,), U.reshape(3, 1)),
    ("cat", (1, A, A[:1]), np.concatenate([A, A[:1]])),
    ("cat", (2, A, A[:, :1]), np.concatenate([A, A[:, :1]], axis=1)),
]


def given(argument: Any) -> Any:
    return tensor_of(argument.tolist()) if isinstance(argument, np.ndarray) else argument


@pytest.mark.parametrize(("name", "arguments", "wanted"), CASES, ids=lambda x: str(x)[:12])
def test_numbers_and_expressions(name: str, arguments: tuple[Any, ...], wanted: Any) -> None:
    values = [given(a) for a in arguments]
    assert np.array_equal(nested(tensor.apply(Numbers, name, int, values)), wanted)
    table = Exprs()
    counts = range(len(values))[tensor.COUNTS.get(name, slice(0, 0))]
    lifted = [v if k in counts else each(table.const, v) for k, v in enumerate(values)]
    found = tensor.apply(table, name, int, lifted)
    assert np.array_equal(nested(each(lambda e: e.data, found)), wanted)


def test_every_function_has_a_case() -> None:
    assert {name for name, _, _ in CASES} == tensor.FUNCTIONS.keys()


def test_arrays_without_entries() -> None:
    table = tensor_of([], (0, 2))
    assert tensor.transpose(Numbers, table).shape == (2, 0)
    assert tensor.product(Numbers, tensor.transpose(Numbers, table), table).items == (0,) * 4


def test_what_is_too_large_is_not_begun() -> None:
    with pytest.raises(TooLarge):
        tensor.identity(Numbers, 1_000_000)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("scalar", (U,)),
        ("vector", (A,)),
        ("matrix", (A.reshape(1, 2, 3),)),
        ("symmetric", (A,)),
        ("cross", (np.array([1.0, 2.0, 3.0, 4.0]), U)),
        ("cat", (2, A, S[:1])),
    ],
)
def test_sizes_that_do_not_fit_a_function(name: str, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(ValueError):
        tensor.apply(Numbers, name, int, [given(a) for a in arguments])


def test_arrays_of_as_many_entries_need_not_be_alike() -> None:
    with pytest.raises(ValueError):
        each(max, given(A), given(A.T))
    assert each(max, tensor_of([], (0, 2)), tensor_of([])).items == ()
