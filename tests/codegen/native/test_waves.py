"""Sine and cosine without a library, against many digits."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from pathlib import Path

import mpmath
import numpy as np
import pytest

import planarc
from planarc.codegen.native import machine
from planarc.codegen.native.assembly import Code, Value, function
from planarc.codegen.native.waves import EXACT, FARTHEST, call_waves, waves_text
from planarc.solve.kernels.native.kernel import NativeKernel
from tests.codegen.native.engine import compiled

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"
Both = Callable[[float], list[float]]

#: Units in the last place that a result may be off.
_OFF = 0.8


@function("void waves(ptr out, double x)")
def _waves(c: Code, out: Value, x: Value) -> None:
    sine, cosine = call_waves(c, x)
    out.store(sine)
    out.store(cosine, 1)
    c.give()


@pytest.fixture(scope="module")
def both() -> Both:
    engine = compiled(waves_text(), _waves())
    shape = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double)
    call, out = shape(engine.get_function_address("waves")), np.zeros(2)

    def find(x: float, engine: object = engine) -> list[float]:
        call(out.ctypes.data, x)
        return [*map(float, out)]

    return find


def _off(found: float, wanted: mpmath.mpf) -> float:
    return float(abs(found - wanted) / math.ulp(float(wanted)))


def _angles() -> list[float]:
    made = np.random.default_rng(1)
    quarters = np.concatenate([np.arange(-40, 41), made.integers(-600_000, 600_000, 400)])
    at = quarters * (math.pi / 2)
    found = [made.uniform(-s, s, 1500) for s in (1.0, 10.0, 1e3, EXACT)]
    found += [at, np.nextafter(at, 9e9), at + math.pi / 4, at + 1e-9 * made.normal(size=at.size)]
    return [x for x in np.concatenate(found).tolist() if abs(x) < EXACT]


def test_both_are_exact_but_for_rounding(both: Both) -> None:
    with mpmath.workdps(50):
        worst = 0.0
        for x in _angles():
            sine, cosine = both(x)
            worst = max(worst, _off(sine, mpmath.sin(x)), _off(cosine, mpmath.cos(x)))
    assert worst < _OFF


def test_far_angles_are_exact_beside_their_own_rounding(both: Both) -> None:
    made = np.random.default_rng(2)
    for size in np.geomspace(EXACT, 0.99 * FARTHEST, 500):
        x = size * made.choice((-1.0, 1.0)) * made.uniform(0.5, 1.0)
        wanted = math.sin(x), math.cos(x)
        assert both(x) == pytest.approx(wanted, rel=0, abs=1e-5 * math.ulp(x))


@pytest.mark.parametrize("x", (math.nan, math.inf, -math.inf, FARTHEST, -1e300))
def test_what_has_no_digits_behind_its_point_has_none(both: Both, x: float) -> None:
    assert all(map(math.isnan, both(x)))


def test_zero(both: Both) -> None:
    assert both(0.0) == both(-0.0) == [0.0, 1.0]


def test_a_four_bar_runs_alike_on_processors_that_call_the_library(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = planarc.load(FOUR_BAR).program
    found = []
    for fuses in (machine.fuses(), False):
        monkeypatch.setattr(machine, "fuses", lambda fuses=fuses: fuses)
        machine._runtime.cache_clear()
        monkeypatch.setattr(machine, "_kept", lambda what, make: make())
        kernel = NativeKernel(program, machine.compile_object(program))
        kernel.parameters()
        assert kernel.outputs(0.0, [1.0, 4.0]) == 0
        found.append(kernel.w.tolist())
    machine._runtime.cache_clear()
    assert found[0] == pytest.approx(found[1], rel=1e-12, abs=1e-12)
