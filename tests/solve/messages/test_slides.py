"""The direction that a hint offers closes the loop; parallel slides are told where they lock."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import planarc

ERRORS = Path(__file__).parents[2] / "errors"


def model_of(case: str) -> str:
    text = (ERRORS / f"{case}.case").read_text()
    return text.partition("\n")[2].partition("=== run")[0]


def hint_of(text: str) -> str:
    with pytest.raises(planarc.PlanarcError) as failed:
        planarc.load(text).simulate()
    return failed.value.diagnostics[0].hint or ""


def test_the_offered_direction_closes_the_loop() -> None:
    text = model_of("follower_along_its_face")
    found = re.search(r"direction of `(\w+)`: with `(n=\{\S+ \S+\})`", hint_of(text))
    assert found is not None
    turned = re.sub(rf"({found[1]}\()n=\{{[^}}]*\}}", rf"\1{found[2]}", text)
    assert turned != text
    planarc.load(turned).simulate()


@pytest.mark.parametrize("case", ["yoke_with_one_direction", "slides_of_one_direction"])
def test_the_offered_slide_of_two_moves_the_yoke(case: str) -> None:
    text = model_of(case)
    found = re.search(r"such as `(\w+)\((n=\{\S+ \S+\})\)`", hint_of(text))
    assert found is not None
    turned = re.sub(rf"({found[1]}\()n=\{{[^}}]*\}}", rf"\1{found[2]}", text)
    assert turned != text
    planarc.load(turned).simulate()


FAR = """model Far
  import PlanarMultiBody.*;
  inner World world;
  Parts.Fixed base(r={0.5, 0.5});
  Joints.Revolute main(w(start=1, fixed=true));
  Parts.BodyShape crank(r={0.1, 0}, m=1, I=0.01);
  Joints.Revolute pin;
  Parts.BodyShape rod(r={0.2, 0}, m=1, I=0.01);
  Joints.Revolute wrist;
  Joints.Prismatic rail(n={1, 0});
equation
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, crank.frame_a);
  connect(crank.frame_b, pin.frame_a);
  connect(pin.frame_b, rod.frame_a);
  connect(rod.frame_b, wrist.frame_a);
  connect(base.frame_b, rail.frame_a);
  connect(rail.frame_b, wrist.frame_b);
end Far;
"""


@pytest.mark.parametrize("base", ["{0.5, 0.5}", "{0, 0.5}"])
def test_a_direction_is_told_only_where_it_helps(base: str) -> None:
    """0.3 m reach a rail that passes at the crank's axis, and none at 0.5 m from it."""
    hint = hint_of(FAR.replace("{0.5, 0.5}", base))
    assert ("with `n={0, 1}` the loop closes" in hint) == base.startswith("{0,")
    assert "lengths" in hint
