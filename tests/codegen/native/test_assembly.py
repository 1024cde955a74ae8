"""LLVM written with operators computes what the operators say."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from typing import Any

import pytest

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from tests.codegen.native.engine import compiled


def called(text: str, name: str, result: Any, *arguments: Any) -> Callable[..., Any]:
    engine = compiled(text)
    call = ctypes.CFUNCTYPE(result, *arguments)(engine.get_function_address(name))
    call.engine = engine  # type: ignore[attr-defined]
    return call


@function("void pc_subtract(ptr a, ptr b, double factor, i64 count)")
def _subtract(c: Code, a: Value, b: Value, factor: Value, count: Value) -> None:
    c.subtract(a, b, factor, count)
    c.give()


@pytest.mark.parametrize("count", range(10))
def test_rows_are_subtracted_whatever_their_length(count: int) -> None:
    """Four at a time, and the rest one by one."""
    pointer = ctypes.POINTER(ctypes.c_double)
    shape = (pointer, pointer, ctypes.c_double, ctypes.c_int64)
    call = called(_subtract(), "pc_subtract", None, *shape)
    a = (ctypes.c_double * 10)(*(10.0 + i for i in range(10)))
    b = (ctypes.c_double * 10)(*(1.0 + i for i in range(10)))
    call(a, b, 2.0, count)
    assert list(a) == [10.0 + i - (2.0 * (1.0 + i) if i < count else 0.0) for i in range(10)]


@function("i64 pc_steps(double most)")
def _steps(c: Code, most: Value) -> None:
    """The first i with i^2 > most, of 0 to 99."""
    done, found = c.label(), c.variable(100, INT)
    with c.loop(100) as i:
        x = c.real(i)
        found.set(i)
        c.leave(x * x > most, done)
    c.enter(done)
    c.give(found.get())


@pytest.mark.parametrize(("most", "wanted"), [(-1.0, 0), (0.0, 1), (50.0, 8), (1e9, 99)])
def test_a_loop_is_left_where_a_condition_holds(most: float, wanted: int) -> None:
    assert called(_steps(), "pc_steps", ctypes.c_int64, ctypes.c_double)(most) == wanted


def test_values_are_numbered_in_the_order_of_their_lines() -> None:
    """Places and variables, which stand elsewhere than they are used, have names."""
    for text in (_steps(), _subtract()):
        numbers = [int(n) for n in re.findall(r"%(\d+) = ", text)]
        assert numbers and numbers == sorted(numbers)
        assert all(" = alloca " in line for line in re.findall(r"%v.* = .*", text))


@function("double pc_formula(double x, double y)")
def _formula(c: Code, x: Value, y: Value) -> None:
    with c.when(x > y, leaves=True):
        c.give(c.sum([x, -y, -(x * y)]), REAL)
    c.give(c.select(x.equals(y), 0.5, (1.0 - x) / (y + 2.0)), REAL)


@pytest.mark.parametrize(("x", "y"), [(3.0, 1.5), (1.5, 3.0), (2.0, 2.0)])
def test_formulas_and_branches(x: float, y: float) -> None:
    wanted = x - y - x * y if x > y else 0.5 if x == y else (1 - x) / (y + 2)
    call = called(_formula(), "pc_formula", *[ctypes.c_double] * 3)
    assert call(x, y) == wanted
