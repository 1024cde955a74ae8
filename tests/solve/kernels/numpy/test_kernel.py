"""The NumPy back end's kernel: what it keeps to itself, and what it tells of failures."""

from __future__ import annotations

import math
from threading import Barrier, Thread, current_thread
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import PlanarcError
from planarc.solve.kernels.numpy import block, support

DENSE = """model Dense
  Real x[3](each start=1);
equation
  x[1]^3 + 2*x[2]^3 + 3*x[3]^3 + x[1]*x[2]*x[3] = 7 + time;
  3*x[1]^3 + x[2]^3 + 2*x[3]^3 - x[1]*x[2]*x[3] = 5 + time;
  2*x[1]^3 + 3*x[2]^3 + x[3]^3 + 2*x[1]*x[2]*x[3] = 8 + time;
end Dense;"""


def test_what_one_kernel_is_told_does_not_rule_another_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two threads: one solves few points, without LAPACK, while the other one solves with it."""
    model = planarc.load(DENSE, backend="numpy")
    kernels: dict[str, Any] = {name: model.compiled().load() for name in ("few", "many")}
    kernels["few"].expect_few_points()
    solver, both, used, flags = support._lapack(), Barrier(2), set(), []

    def lapack() -> Any:
        used.add(current_thread().name)
        return solver

    def solve() -> None:
        kernel = kernels[current_thread().name]
        kernel.parameters()
        for k in range(20):
            both.wait(timeout=300)
            flags.append(kernel.outputs(0.01 * k, ()))

    monkeypatch.setattr(support, "_lapack", lapack)
    threads = [Thread(target=solve, name=name) for name in kernels]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert flags == [0] * 40
    assert used == {"many"}
    assert list(kernels["few"].w) == pytest.approx(list(kernels["many"].w), rel=1e-12)


def test_a_line_without_an_equation_serves_the_next_one() -> None:
    """The root fails in a part of a formula that has a line of its own."""
    text = """model Root
      Real x(start=1, fixed=true), a, b;
    equation
      der(x) = -1;
      a = x + 1;
      b = sqrt(x - 2)*sin(sqrt(x - 2));
    end Root;"""
    with pytest.raises(PlanarcError) as caught:
        planarc.load(text, backend="numpy").simulate(1.0)
    assert "b = sqrt(x - 2.0)" in caught.value.diagnostics[0].message.replace(" 2)", " 2.0)")


def test_residuals_beyond_all_bounds_are_compared_quietly() -> None:
    """NumPy's numbers would warn whoever calls planarc from Python."""
    with np.errstate(all="raise"):
        assert block._norm([np.float64(1e308), np.float64(1.0)], [1e-10, 1.0]) == math.inf
        assert block._norm([np.float64(1.0)], [np.float64(0.0)]) == math.inf
