"""Starts at or next to a dead centre: refused where what is held decides nothing."""

from __future__ import annotations

import pytest

import planarc
from planarc.core.diagnostic import Diagnostic

BACKENDS = ["numpy", "native"]

SLIDER = """model Slider
  import P = PlanarMultiBody;
  inner P.World world;
  P.Joints.Revolute main, pin, wrist;
  P.Joints.Prismatic slide(n={1, 0}SLIDE);
  P.Parts.BodyShape crank(r={0.3, 0}, m=1, I=0.01), rod(r={0.8, 0}, m=1, I=0.01);
  P.Parts.Body load(m=1, I=0.01);
equation
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, crank.frame_a);
  connect(crank.frame_b, pin.frame_a);
  connect(pin.frame_b, rod.frame_a);
  connect(rod.frame_b, wrist.frame_a);
  connect(wrist.frame_b, load.frame_a);
  connect(slide.frame_b, load.frame_a);
  connect(world.frame_b, slide.frame_a);
end Slider;
"""


def slider(s: float, v: float) -> str:
    return SLIDER.replace("SLIDE", f", s(start={s!r}, fixed=true), v(start={v!r}, fixed=true)")


def refused(text: str, backend: str) -> Diagnostic:
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(text, backend=backend).simulate(0.001)
    return caught.value.diagnostics[0]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("s", [1.1, 1.0999999, 1.09999999])
def test_a_speed_held_at_a_dead_centre(s: float, backend: str) -> None:
    found = refused(slider(s, 0.5), backend)
    assert found.code == "R428"
    assert f"at `slide.s` = {s:.6g} the loop of `crank` and `rod` (joints `main`," in found.message
    assert "starts at a dead centre, where " in found.message
    assert "`slide.v` = 0.5 cannot be held: `main.w` would have to be " in found.message
    assert found.span is not None
    assert found.span.line == 5
    assert "`main.phi` and `main.w` instead of `slide.s` and `slide.v`" in str(found.hint)


def test_the_numbers() -> None:
    """w = v/(ds/dphi), and that is sin(phi + psi)*r/cos(psi) with r*sin(phi) = l*sin(psi)."""
    found = refused(slider(1.0999999, 0.5), "numpy")
    assert "would have to be -1741 (condition 4e03)" in found.message


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("s", "w"), [(1.0999, -55.054), (1.09, -5.5625)])
def test_farther_from_it(s: float, w: float, backend: str) -> None:
    result = planarc.load(slider(s, 0.5), backend=backend).simulate(0.001)
    assert result["main.w"][0] == pytest.approx(w, rel=1e-4)


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_crank_may_be_held_there(backend: str) -> None:
    text = SLIDER.replace("SLIDE", ", s(start=1.1)").replace(
        "Revolute main,", "Revolute main(phi(start=0, fixed=true), w(start=3, fixed=true)),"
    )
    result = planarc.load(text, backend=backend).simulate(0.001)
    assert result["slide.s"][0] == pytest.approx(1.1)
    assert result["slide.v"][0] == pytest.approx(0, abs=1e-9)


def test_a_hint_into_the_dead_centre_is_not_given() -> None:
    found = refused(slider(1.1001, 0.5), "numpy")
    assert found.code == "R412"
    assert "well inside its reach: `slide.s(start = 1.1)` is a dead centre" in str(found.hint)
