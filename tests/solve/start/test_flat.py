"""A loop that starts with all bars on one line is refused, with the ways that lead from there."""

from __future__ import annotations

import re

import numpy as np
import pytest

import planarc

#: Ground, crank, coupler and rocker: length / `{size}`. Both pivots are on the x-axis.
FOUR_BAR = """
model FourBar
  import PlanarMultiBody.Joints.Revolute;
  import PlanarMultiBody.Parts;
  inner PlanarMultiBody.World world;
  Parts.FixedTranslation ground(r={{{ground}*{size}, 0}});
  Revolute a(phi(start={angle}, fixed=true), w(start=0, fixed=true));
  Revolute b(phi(start=-({angle})));
  Revolute c;
  Revolute d(phi(start={angle}));
  Parts.BodyShape crank(r={{1*{size}, 0}}, m=1, I={size}^2);
  Parts.BodyShape coupler(r={{{coupler}*{size}, 0}}, m=1, I={size}^2);
  Parts.BodyShape rocker(r={{{rocker}*{size}, 0}}, m=1, I={size}^2);
equation
  connect(world.frame_b, ground.frame_a);
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, coupler.frame_a);
  connect(ground.frame_b, d.frame_a);
  connect(d.frame_b, rocker.frame_a);
  connect(rocker.frame_b, c.frame_a);
  connect(coupler.frame_b, c.frame_b);
end FourBar;
"""


def four_bar(
    angle: float, ground: float = 2, coupler: float = 2, rocker: float = 1, size: float = 1
) -> planarc.Model:
    return planarc.load(
        FOUR_BAR.format(angle=angle, ground=ground, coupler=coupler, rocker=rocker, size=size)
    )


def refused(model: planarc.Model) -> planarc.Diagnostic:
    with pytest.raises(planarc.PlanarcError) as caught:
        model.simulate(0.1)
    (found,) = caught.value.diagnostics
    return found


@pytest.mark.parametrize("backend", ["numpy", "native"])
@pytest.mark.parametrize("angle", [0.0, 1e-7, -1e-8])
def test_a_parallelogram_that_lies_flat_is_refused(angle: float, backend: str) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        four_bar(angle).simulate(0.1, backend=backend)
    (found,) = caught.value.diagnostics
    assert found.code == "R437"
    assert found.span is not None
    assert "Revolute a(" in found.span.source.text[found.span.start - 20 : found.span.end + 3]


@pytest.mark.parametrize(("ground", "coupler", "rocker"), [(2, 2, 1), (1.5, 2, 1.5)])
def test_the_ways_that_are_told_close_the_loop(
    ground: float, coupler: float, rocker: float
) -> None:
    """The coupler's length between the ends of crank and rocker, by hand."""
    hint = refused(four_bar(0.0, ground, coupler, rocker)).hint
    assert hint is not None
    told = re.search(r"`a.phi` = (\S+), `d.phi` is (\S+) on one and (\S+) on the other", hint)
    assert told is not None
    a, *ways = (float(x) for x in told.groups())
    for d in ways:
        between = ground + rocker * np.exp(1j * d) - np.exp(1j * a)
        assert abs(between) == pytest.approx(coupler, abs=1e-4)
    assert abs(ways[0] - ways[1]) > 0.1


def test_a_rhombus_whose_slide_stands_on_its_pivot_is_refused() -> None:
    """Crank and rod are equally long: with the slide on the crank's pivot both turn about it
    together, or the slide moves."""
    model = planarc.load("""
    model Rhombus
      import P = PlanarMultiBody;
      inner P.World world;
      P.Joints.Revolute a(phi(start=1.5707963267948966, fixed=true), w(fixed=true));
      P.Joints.Revolute b(phi(start=3)), c;
      P.Joints.Prismatic slide(n={1, 0}, s(start=0));
      P.Parts.BodyShape crank(r={1, 0}, m=1, I=0.1), rod(r={1, 0}, m=1, I=0.1);
    equation
      connect(world.frame_b, a.frame_a);
      connect(a.frame_b, crank.frame_a);
      connect(crank.frame_b, b.frame_a);
      connect(b.frame_b, rod.frame_a);
      connect(rod.frame_b, c.frame_a);
      connect(world.frame_b, slide.frame_a);
      connect(c.frame_b, slide.frame_b);
    end Rhombus;
    """)
    assert refused(model).code == "R437"


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e3])
def test_a_loop_beside_its_flat_position_starts_at_any_size(size: float) -> None:
    run = four_bar(1e-3, size=size).simulate(0)
    assert run["d.phi"][0] == pytest.approx(1e-3, rel=1e-6)


def test_falling_through_the_flat_position_keeps_the_energy() -> None:
    """From 1 mrad above: the crank is a rod of m l²/3 + I about its pivot, and so is the rocker;
    the coupler moves with their ends."""
    run = four_bar(1e-3).simulate(0.5)
    phi, w = run["a.phi"], run["a.w"]
    inertia = 2 * (0.25 + 1) + 1  # kg.m2, of the parallelogram about its pivots
    kinetic = inertia * w**2 / 2
    potential = 9.81 * 2 * np.sin(phi)
    lost = kinetic + potential - 9.81 * 2 * np.sin(1e-3)
    assert np.abs(lost).max() < 1e-3 * kinetic.max()
