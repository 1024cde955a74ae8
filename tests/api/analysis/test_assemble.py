"""All assemblies of a mechanism."""

from __future__ import annotations

import math

import pytest

from planarc import Model, PlanarcError, UsageError, load

#: The ends of a bar slide along x and y.
TRAMMEL = """
model Trammel
  import PlanarMultiBody.{Joints, Parts};
  parameter Modelica.Units.SI.Length L=1;
  inner PlanarMultiBody.World world(g=0);
  Joints.Prismatic px(n={1, 0}, s(start=0.6*L, fixed=true));
  Joints.Prismatic py(n={0, 1}, s(start=0.5*L));
  Joints.Revolute r1;
  Joints.Revolute r2;
  Parts.BodyShape bar(r={L, 0}, m=1);
equation
  connect(world.frame_b, px.frame_a);
  connect(world.frame_b, py.frame_a);
  connect(px.frame_b, r1.frame_a);
  connect(r1.frame_b, bar.frame_a);
  connect(bar.frame_b, r2.frame_a);
  connect(py.frame_b, r2.frame_b);
end Trammel;
"""


def test_a_four_bar_has_two(four_bar: Model) -> None:
    first, second = four_bar.assemble()
    assert first["revA.phi"] == second["revA.phi"] == 1.0
    assert first["revB.phi"] == pytest.approx(four_bar.simulate(0)["revB.phi"][0])
    # C lies on both sides of the line from B to D, which has this direction.
    b = (0.4 * math.cos(1), 0.4 * math.sin(1))
    line = math.atan2(-b[1], 1 - b[0])
    turned = [1 + a["revB.phi"] - line for a in (first, second)]
    assert math.remainder(turned[0] + turned[1], 2 * math.pi) == pytest.approx(0, abs=1e-9)
    for assembly in (first, second):
        result = four_bar.simulate(0, start=assembly.start)
        assert result["revB.phi"][0] == pytest.approx(assembly["revB.phi"], abs=1e-9)


def test_a_slider_is_on_the_left_or_on_the_right(slider: Model) -> None:
    found = slider.assemble(start={"main.phi": -0.5})
    y, base = 0.2 * math.sin(-0.5), 0.2 * math.cos(-0.5)
    exact = [base + math.sqrt(0.49 - y * y), base - math.sqrt(0.49 - y * y)]
    assert [a["slide.s"] for a in found] == pytest.approx(exact)


@pytest.mark.parametrize("length", [1e-6, 1.0, 500.0, 1e4])
def test_there_are_as_many_in_any_size(length: float) -> None:
    found = load(TRAMMEL).assemble(parameters={"L": length}, tries=60)
    exact = [-0.8 * length, 0.8 * length]
    assert sorted(a["py.s"] for a in found) == pytest.approx(exact, rel=1e-9)


def test_what_does_not_close_is_said(four_bar: Model) -> None:
    with pytest.raises(PlanarcError, match="no way to put"):
        four_bar.assemble(parameters={"coupler.r": [0.01, 0]}, tries=20)
    with pytest.raises(UsageError, match="above 0"):
        four_bar.assemble(tries=0)


def test_an_open_chain_is_assembled_as_it_starts(pendulum: Model) -> None:
    (only,) = pendulum.assemble()
    assert only.start == {"hinge.phi": 0.5}
    assert only.distance == 0


def test_initial_equations_hold_positions() -> None:
    """A four-bar has two ways with its crank held, whichever way it is held."""
    text = """
model Bars
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute A, B(phi(start=-0.2)), C(phi(start=1)), D(phi(start=2));
  PlanarMultiBody.Parts.BodyShape crank(r={0.3, 0}), coupler(r={1, 0}), rocker(r={0.8, 0});
  PlanarMultiBody.Parts.Fixed ground(r={1.1, 0});
initial equation
  A.phi = 0.7;
  A.w = 2;
equation
  connect(world.frame_b, A.frame_a);
  connect(A.frame_b, crank.frame_a);
  connect(crank.frame_b, B.frame_a);
  connect(B.frame_b, coupler.frame_a);
  connect(ground.frame_b, D.frame_a);
  connect(D.frame_b, rocker.frame_a);
  connect(coupler.frame_b, C.frame_a);
  connect(rocker.frame_b, C.frame_b);
end Bars;
"""
    found = load(text).assemble()
    assert len(found) == 2
    assert [a["A.phi"] for a in found] == pytest.approx([0.7, 0.7])
    for assembly in found:
        result = load(text).simulate(0.1, start=dict(assembly.start))
        for name in ("B.phi", "D.phi"):
            assert result[name][0] == pytest.approx(assembly[name], abs=1e-6)
