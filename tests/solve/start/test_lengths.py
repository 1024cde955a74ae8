"""Fixed lengths and tips: what is held at the start follows from positions, wherever it is
computed."""

from __future__ import annotations

import math
from typing import Any

import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request


def started(text: str) -> Any:
    compiled = compiler.compile_model(Request(text=text), Backend.NUMPY)
    result = compiler.run(compiled, RunOptions(stop=0.0, backend=Backend.NUMPY))
    assert result.ended is None
    return result


def test_a_chain_of_masses_starts_from_the_lengths_of_its_springs() -> None:
    """The lengths are computed with the velocities (damped) and with the forces (bare)."""
    result = started(
        """
model Chain
  Real a, va, b, vb;
  Real bare(start = 0.5, fixed = true) = a;
  Real damped(start = 2, fixed = true);
  Real rate(start = -1, fixed = true);
  Real fa, fb;
  Real start_of_a(start = 3, fixed = true) = va;
equation
  va = der(a);
  vb = der(b);
  damped = 2*b - a;
  rate = der(damped);
  fa = 100*(bare - 0.4);
  fb = 50*(damped - 1) + 2*rate;
  der(va) = fb - fa;
  2*der(vb) = -fb;
end Chain;
"""
    )
    assert result["a"][0] == pytest.approx(0.5, abs=1e-12)
    assert result["b"][0] == pytest.approx(1.25, abs=1e-12)
    assert result["va"][0] == pytest.approx(3.0, abs=1e-12)
    assert result["vb"][0] == pytest.approx(1.0, abs=1e-12)
    assert result["fa"][0] == pytest.approx(10.0, abs=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_a_double_pendulum_starts_with_its_tip_where_it_was_fixed(side: int) -> None:
    """Both solutions of the two angles; the written guess of the second says which."""
    result = started(
        f"""
model Tip
  parameter Real r = 0.5, g = 9.81;
  Real p(stateSelect = StateSelect.prefer), q(stateSelect = StateSelect.prefer,
    start = {side * 1.5});
  Real u, w;
  Real x(start = 0.7, fixed = true), y(start = 0.3, fixed = true);
  Real vx(start = 0, fixed = true), vy(start = 0, fixed = true);
equation
  u = der(p);
  w = der(q);
  x = r*cos(p) + r*cos(p + q);
  y = r*sin(p) + r*sin(p + q);
  vx = der(x);
  vy = der(y);
  der(u) = -g*cos(p);
  der(w) = -g*cos(p + q) - w;
end Tip;
"""
    )
    # Law of cosines in the triangle of both rods and the line to the tip.
    q = side * math.acos((0.7**2 + 0.3**2 - 2 * 0.5**2) / (2 * 0.5**2))
    p = math.atan2(0.3, 0.7) - q / 2
    assert result["q"][0] == pytest.approx(q, abs=1e-10)
    assert result["p"][0] == pytest.approx(p, abs=1e-10)
    assert result["x"][0] == pytest.approx(0.7, abs=1e-12)
    assert result["u"][0] == pytest.approx(0, abs=1e-12)
