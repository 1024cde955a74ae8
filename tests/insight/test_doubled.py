"""A contact that is twice there is told, and none that has other contours or another place."""

from __future__ import annotations

import pytest

import planarc

BALLS = """model Balls
  import PlanarMultiBody.*;
  parameter Real ra=0.1, rb=RB;
  inner World world;
  Parts.Body one(m=1, I=0.1, r(start={0,0.5}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact a(redeclare Contacts.Circle contour1(R=ra),
    redeclare Contacts.HalfPlane contour2);
  Contacts.Contact b(redeclare Contacts.Circle contour1(R=rb),
    redeclare Contacts.HalfPlane contour2);
  Parts.Fixed low(r={0,PLACE});
equation
  connect(one.frame_a, a.frame_a);
  connect(one.frame_a, b.frame_a);
  connect(world.frame_b, a.frame_b);
  connect(FLOOR.frame_b, b.frame_b);
end Balls;
"""


@pytest.mark.parametrize(
    ("radius", "floor", "count"), [(0.1, "world", 1), (0.2, "world", 0), (0.1, "low", 0)]
)
def test_it_is_told_where_nothing_differs(radius: float, floor: str, count: int) -> None:
    text = BALLS.replace("RB", repr(radius)).replace("FLOOR", floor).replace("PLACE", "-0.1")
    warnings = planarc.load(text).warnings
    assert sum("is the same contact" in w.message for w in warnings) == count
