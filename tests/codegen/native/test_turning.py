"""Sines and cosines turned on, in machine code."""

from __future__ import annotations

import ctypes
import math

import numpy as np
import pytest

from planarc.codegen.native import turning
from planarc.codegen.native.assembly import Code, Value, function
from planarc.codegen.native.waves import waves_text
from tests.codegen.native.engine import compiled


@function("i32 turned(ptr memory, double x)")
def _turned(c: Code, memory: Value, x: Value, fused: bool) -> None:
    turning.turn(c, memory, x, fused)
    c.give(0)


@pytest.mark.parametrize("fused", (False, True))
@pytest.mark.parametrize("first", (0.0, 1.0, -2.5, 1e3))
def test_sine_and_cosine_are_those_of_the_angle(first: float, fused: bool) -> None:
    declared = (f"declare double @{name}(double)\n" for name in ("sin", "cos"))
    engine = compiled(*declared, waves_text(), _turned(fused))
    shape = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)
    turned = shape(engine.get_function_address("turned"))
    memory, x = np.full(turning.NUMBERS, math.nan), first
    for way in (0.0, 0.9 * turning.NEAR, -1e-9, 0.0, 3.0, turning.NEAR / 2, 2 * turning.NEAR):
        x += way
        turned(memory.ctypes.data, x)
        wanted = x, math.sin(x), math.cos(x)
        assert memory == pytest.approx(wanted, rel=0, abs=4e-16)
        assert memory[turning.ANGLE] == x
