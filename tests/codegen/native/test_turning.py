"""Sines and cosines turned on, in machine code."""

from __future__ import annotations

import ctypes
import math

import llvmlite.binding as llvm
import numpy as np
import pytest

from planarc.codegen.native import turning
from planarc.codegen.native.assembly import Code, Value, function
from tests.codegen.native.test_waves import HEAD


@function("i32 turned(ptr memory, double x)")
def _turned(c: Code, memory: Value, x: Value, fused: bool) -> None:
    turning.turn(c, memory, x, fused)
    c.give(0)


@pytest.mark.parametrize("fused", (False, True))
@pytest.mark.parametrize("first", (0.0, 1.0, -2.5, 1e3))
def test_sine_and_cosine_are_those_of_the_angle(first: float, fused: bool) -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    names = ("sin", "cos")
    text = "".join(f"declare double @{name}(double)\n" for name in names)
    text += HEAD + _turned(fused)
    machine = llvm.Target.from_default_triple().create_target_machine(opt=1, jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    engine.finalize_object()
    shape = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)
    turned = shape(engine.get_function_address("turned"))
    memory, x = np.full(turning.NUMBERS, math.nan), first
    for way in (0.0, 0.9 * turning.NEAR, -1e-9, 0.0, 3.0, turning.NEAR / 2, 2 * turning.NEAR):
        x += way
        turned(memory.ctypes.data, x)
        wanted = x, math.sin(x), math.cos(x)
        assert memory == pytest.approx(wanted, rel=0, abs=4e-16)
        assert memory[turning.ANGLE] == x
