"""Looks at the choice of states, in machine code."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.core.options import RunOptions
from planarc.solve.kernels.native.kernel import NativeKernel
from planarc.solve.simulate import simulate

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize("stop", (0.0, 0.3, 0.7))
@pytest.mark.parametrize("name", ("four_bar", "crank_slider"))
def test_two_rows_tell_as_much_by_determinants(name: str, stop: float) -> None:
    compiled = planarc.load(EXAMPLES / f"{name}.pmo").compiled()
    kernel = compiled.load()
    assert isinstance(kernel, NativeKernel)
    simulate(compiled.program, kernel, RunOptions(stop=stop, intervals=1))
    where = kernel.addresses(0)
    blocks = [
        i for i, b in enumerate(compiled.program.blocks) if b.height and len(b.residuals) == 2
    ]
    assert blocks
    shape = ctypes.CFUNCTYPE(
        ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p
    )
    found = []
    for function in ("pc_look", "pc_watch"):
        look = shape(kernel._engine.address(function))
        places = np.array([where.records[i] for i in blocks], dtype=np.int64)
        scales = np.zeros(sum(len(compiled.program.blocks[i].tears) for i in blocks))
        worst = look(where.context, places.ctypes.data, len(blocks), scales.ctypes.data)
        found.append((worst, *scales))
    assert found[0][0] > 0
    assert found[1] == pytest.approx(found[0], rel=1e-12)
