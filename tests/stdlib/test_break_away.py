"""What rests on several points is pushed ever harder: by Coulomb's law it breaks loose as a whole,
however its points share the load before."""

from __future__ import annotations

import pytest

from tests.stdlib.small import G, both_backends, run


def crate(m: float, mu: float, rate: float, contour: str) -> str:
    return f"""
  Parts.Body crate(m={m}, I={m}*0.02, r(start={{0, 0.1}}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact floor(redeclare {contour}, redeclare Contacts.HalfPlane contour2, mu={mu});
  Forces.WorldForce push;
equation
  push.force = {{{rate}*time, 0}};
  connect(crate.frame_a, floor.frame_a);
  connect(world.frame_b, floor.frame_b);
  connect(crate.frame_a, push.frame_b);
"""


CONTOURS = {
    "polygon": "Contacts.Polygon contour1(vertices={{-0.2,-0.1},{0.2,-0.1},{0.2,0.1},{-0.2,0.1}})",
    "two points": "Contacts.Point contour1(points={{-0.2,-0.1},{0.2,-0.1}})",
    "three points": "Contacts.Point contour1(points={{-0.2,-0.1},{0.05,-0.1},{0.2,-0.1}})",
}


@both_backends
@pytest.mark.parametrize("contour", CONTOURS)
@pytest.mark.parametrize(
    ("m", "mu", "rate"), [(10, 0.4, 100), (10, 0.2, 1000), (100, 0.5, -1000), (100, 0.4, 1000)]
)
def test_a_crate_breaks_loose_at_its_limit(
    contour: str, m: float, mu: float, rate: float, backend: str
) -> None:
    result = run(crate(m, mu, rate, CONTOURS[contour]), 2, backend)
    loose = mu * m * G / abs(rate)
    gone = rate / (6 * m) * max(0.0, 2 - loose) ** 3
    assert result.ended is None
    assert result["crate.r[1]"][-1] == pytest.approx(gone, rel=1e-4, abs=1e-9)
