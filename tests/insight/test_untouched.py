"""A contact is told that never comes near, and none that comes near or touches."""

from __future__ import annotations

import pytest

import planarc

#: A ball on a rod of 0.5 m, or at its pivot, over a floor.
CLAPPER = """model M
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute pivot(phi(start=-0.3, fixed=true), w(fixed=true));
  Parts.BodyShape rod(r={0.5, 0}, m=2, I=0.04);
  Parts.Fixed floor(r={0, -DEPTH});
  Contacts.Contact strike(redeclare Contacts.Circle contour1(R=0.04),
    redeclare Contacts.HalfPlane contour2, e=0.5);
equation
  connect(world.frame_b, pivot.frame_a);
  connect(pivot.frame_b, rod.frame_a);
  connect(rod.frame_END, strike.frame_a);
  connect(floor.frame_b, strike.frame_b);
end M;
"""


def told(end: str, depth: float, stop: float = 2.0) -> list[str]:
    text = CLAPPER.replace("END", end).replace("DEPTH", repr(depth))
    return [w.message for w in planarc.load(text).simulate(stop).warnings if w.code == "R457"]


def test_a_ball_at_the_pivot_is_told_with_its_gap() -> None:
    (message,) = told("a", 0.54)
    assert "`strike` do not come near each other: their gap is 0.5 m at least, and 0.5" in message


@pytest.mark.parametrize(
    ("end", "depth", "stop"),
    [("b", 0.45, 2.0), ("b", 0.6, 2.0), ("a", 0.54, 0.0)],  # it strikes; comes near; has no time
)
def test_what_comes_near_is_not_told(end: str, depth: float, stop: float) -> None:
    assert told(end, depth, stop) == []


def test_a_floor_far_below_is_told() -> None:
    """The ball falls by 0.35 m over a floor of 2 m."""
    assert len(told("b", 2.0)) == 1


def test_contours_that_touch_at_the_start_are_not_told() -> None:
    """The balls stand side by side, but for rounding, and the last one leaves with the blow."""
    text = """model Row
  import PlanarMultiBody.*;
  inner World world(gravityType=Types.GravityTypes.NoGravity);
  Joints.Prismatic p[3](s(start={0, 0.4, 0.6000000000000001}, each fixed=true),
    v(start={0, 2, 0}, each fixed=true));
  Parts.Body b[3](each m=1);
  Contacts.Contact c(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=0.1), e=1);
equation
  for i in 1:3 loop
    connect(world.frame_b, p[i].frame_a);
    connect(p[i].frame_b, b[i].frame_a);
  end for;
  connect(b[2].frame_a, c.frame_a);
  connect(b[3].frame_a, c.frame_b);
end Row;
"""
    run = planarc.load(text).simulate(0.5)
    assert 0 < run["c.gap[1]"].min() < 1e-9
    assert run["b[3].v[1]"][-1] == pytest.approx(2)
    assert not [w for w in run.warnings if w.code == "R457"]
