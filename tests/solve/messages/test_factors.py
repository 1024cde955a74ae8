"""What is off by a factor is told where an assertion fails, and nothing where it is not."""

from __future__ import annotations

import pytest

import planarc

GEARS = """model Gears
  import PlanarMultiBody.*;
  inner World world;
  Parts.FixedTranslation ground(r={%s, 0});
  Joints.Revolute ja(phi(fixed=true), w(start=1, fixed=true)), jb%s;
  Parts.Body ba(m=1, I=0.01), bb(m=1, I=0.01);
  Contacts.%s pair(Ra=%s, Rb=%s);
equation
  connect(world.frame_b, ja.frame_a);
  connect(world.frame_b, ground.frame_a);
  connect(ground.frame_b, jb.frame_a);
  connect(ja.frame_b, ba.frame_a);
  connect(jb.frame_b, bb.frame_a);
  connect(ja.frame_b, pair.frame_a);
  connect(jb.frame_b, pair.frame_b);
end Gears;
"""
BOTH = "it holds with `Ra=0.05` and `Rb=0.1`: "
MM = BOTH + "lengths are in m, 1 mm is 1e-3 m"
HALF = BOTH + "give radii, which are half of the diameters"
OTHER = "it holds with a thousand times `Ra` and `Rb`: look for another length that is in mm"


@pytest.mark.parametrize(
    ("kind", "apart", "radii", "hint"),
    [
        ("GearPair", 0.15, (50, 100), MM),
        ("GearPair", 0.15, (0.1, 0.2), HALF),
        ("GearPair", 150, (0.05, 0.1), OTHER),
        ("GearPair", 0.15, (0.06, 0.1), None),
        ("GearPair", 0.15, (0.02, 0.04), None),
        ("GearPair", 0.15, (0.15, 0.3), None),
        ("Belt", 0.3, (50, 100), MM),
        ("Belt", 0.3, (0.2, 0.4), None),  # half of it would do, and less as well
        ("Belt", 0.3, (0.1, 0.25), None),
    ],
)
def test_wheels(kind: str, apart: float, radii: tuple[float, float], hint: str | None) -> None:
    free = "(phi(fixed=true), w(fixed=true))" if kind == "Belt" else ""
    with pytest.raises(planarc.PlanarcError, match="R430") as caught:
        planarc.load(GEARS % (apart, free, kind, *radii)).simulate(0.0)
    (found,) = caught.value.diagnostics
    assert found.hint == hint


def test_values_of_a_run_count() -> None:
    model = planarc.load(GEARS % (0.3, "(phi(fixed=true), w(fixed=true))", "Belt", 0.05, 0.1))
    model.simulate(0.0)
    with pytest.raises(planarc.PlanarcError) as caught:
        model.simulate(0.0, parameters={"pair.Ra": 50, "pair.Rb": 100})
    assert caught.value.diagnostics[0].hint == MM


OWN = """model Own
  model Stop
    parameter Real gap(unit="m") = %s "Gap";
    Real x(unit="m", start=0.1, fixed=true);
  equation
    der(x) = 0;
    assert(%s, "the stop is not there, gap = " + String(gap));
  end Stop;
  Stop stop;
end Own;
"""


@pytest.mark.parametrize(
    ("gap", "condition", "hint"),
    [
        (100, "abs(x - gap) < 0.01", "it holds with `gap=0.1`: lengths are in m, 1 mm is 1e-3 m"),
        (0.2, "abs(x - gap) < 0.01", None),  # no radius
        (3, "abs(x - gap) < 0.01", None),
        (0.2, "x > gap", None),
        (0.5, "x > 5*gap", None),
    ],
)
def test_own_parts(gap: float, condition: str, hint: str | None) -> None:
    with pytest.raises(planarc.PlanarcError, match="R430") as caught:
        planarc.load(OWN % (gap, condition)).simulate(0.0)
    assert caught.value.diagnostics[0].hint == hint
