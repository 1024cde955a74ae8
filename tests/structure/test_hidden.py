"""Constraints that cancelling terms hide from matching."""

from __future__ import annotations

import math

import pytest

import planarc

BRANCHES = """
model M
  connector Pin
    Real v;
    flow Real i;
  end Pin;
  model Store
    Pin p, n;
    Real v(start=0), i;
    parameter Real c = 1;
  equation
    v = p.v - n.v;
    i = p.i;
    p.i + n.i = 0;
    c*der(v) = i;
  end Store;
  model Load
    Pin p, n;
    parameter Real r = 1;
  equation
    p.v - n.v = r*p.i;
    p.i + n.i = 0;
  end Load;
  model Source
    Pin p, n;
  equation
    p.v - n.v = 2;
    p.i + n.i = 0;
  end Source;
  model Ground
    Pin p;
  equation
    p.v = 0;
  end Ground;
  Ground ground;
  Source source;
  Load inner_(r=1), outer_(r=3);
  Store a(c=1), b(c=2), c(c=5);
equation
  connect(ground.p, source.n);
  connect(source.p, inner_.p);
  connect(inner_.n, a.p);
  connect(a.n, outer_.p);
  connect(outer_.n, ground.p);
  CONNECTIONS
end M;
"""
TURNED = "connect(b.n, a.p); connect(b.p, a.n); connect(c.p, a.p); connect(c.n, a.n);"
IN_A_RING = "connect(b.p, a.p); connect(b.n, c.p); connect(c.n, a.n);"


@pytest.mark.parametrize(
    ("connections", "capacity", "signs"),
    [(TURNED, 8.0, (1, -1, 1)), (IN_A_RING, 1 + 10 / 7, (1, 5 / 7, 2 / 7))],
)
def test_stores_in_parallel_share_one_state_however_they_are_turned(
    connections: str, capacity: float, signs: tuple[float, ...]
) -> None:
    model = planarc.load(BRANCHES.replace("CONNECTIONS", connections), backend="numpy")
    result = model.simulate(10, tolerance=1e-9)
    assert len(result.states[0].states) == 1 or connections is IN_A_RING
    expected = 2 * (1 - math.exp(-10 / (4 * capacity)))
    for name, share in zip("abc", signs, strict=True):
        assert result[f"{name}.v"][-1] == pytest.approx(share * expected, rel=1e-6)


def test_equations_without_a_hidden_constraint_stay_as_they_are() -> None:
    """The angle between two springs is determined by both; the text tells where it stands."""
    model = planarc.load(
        """
model M
  Real x(start=1, fixed=true), v(start=0, fixed=true), middle, a, b;
equation
  v = der(x);
  a = middle - x;
  b = 3 - middle;
  2*a = b;
  der(v) = a;
end M;""",
        backend="numpy",
    )
    result = model.simulate(1, tolerance=1e-9)
    assert result["middle"][0] == pytest.approx((3 + 2) / 3)
