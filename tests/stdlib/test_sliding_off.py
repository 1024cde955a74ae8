"""A bar that rests on more points than it needs slides off at the limit of friction.

Its weight m*g rests on four points, and a force F = c*t pushes it: it sticks up to t0 = mu*m*g/c,
and is as fast as m*v = c*(t**2 - t0**2)/2 - mu*m*g*(t - t0) then.
"""

from __future__ import annotations

import pytest

import planarc

BAR = """model Bar
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body b(m=2, I=0.2, r(start={0, 0.1}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact c(redeclare Contacts.Point contour1(
    points={{-1, -0.1}, {-0.3, -0.1}, {0.3, -0.1}, {1, -0.1}}),
    redeclare Contacts.HalfPlane contour2, e=0, mu=0.3);
  Forces.WorldForce push;
equation
  connect(b.frame_a, c.frame_a);
  connect(world.frame_b, c.frame_b);
  connect(b.frame_a, push.frame_b);
  push.force = {5*time, 0};
end Bar;"""

WEIGHT, FORCE, STOP = 2 * 9.81, 5.0, 4.0


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10])
@pytest.mark.parametrize(
    "way", [{}, {"backend": "numpy"}, {"solver": "exported"}], ids=["native", "numpy", "exported"]
)
def test_a_bar_on_four_points_slides_at_the_limit(tolerance: float, way: dict[str, str]) -> None:
    options = {"solver": way["solver"]} if "solver" in way else {}
    model = planarc.load(BAR, backend=way.get("backend"))
    run = model.simulate(STOP, tolerance=tolerance, **options)
    begin = 0.3 * WEIGHT / FORCE
    speed = (FORCE * (STOP**2 - begin**2) / 2 - 0.3 * WEIGHT * (STOP - begin)) / 2
    assert run["b.v[1]"][-1] == pytest.approx(speed, rel=1e-4)
