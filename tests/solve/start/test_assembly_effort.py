"""A loop that cannot close is told after few tries."""

from __future__ import annotations

import pytest

import planarc
from planarc.solve.start import newton

#: Searches for a position.
MOST = 24

SHORT = """model Short
  import PlanarMultiBody.*;
  inner World world;
  Parts.Fixed right(r={3, 0});
  Joints.Revolute a(phi(start=1.2, fixed=true), w(start=3, fixed=true)), b, c, d;
  Parts.BodyShape crank(r={0.15, 0}, m=0.5, I=0.002);
  Parts.BodyShape coupler(r={0.45, 0}, m=1, I=0.02);
  Parts.BodyShape rocker(r={0.35, 0}, m=0.8, I=0.01);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, coupler.frame_a);
  connect(coupler.frame_b, c.frame_a);
  connect(c.frame_b, rocker.frame_b);
  connect(right.frame_b, d.frame_a);
  connect(d.frame_b, rocker.frame_a);
end Short;
"""


def test_searches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a look at whether it closes with nothing held there were more than twice as many."""
    searches, solve = [0], newton.solve

    def counted(*args: object) -> newton.Root:
        searches[0] += 1
        return solve(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(newton, "solve", counted)
    with pytest.raises(planarc.PlanarcError, match=r"together 0\.95 m"):
        planarc.load(SHORT).simulate(0.0)
    assert searches[0] <= MOST, searches
