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


def test_lengths_are_told_where_no_direction_helps() -> None:
    """A cam of at most 6 cm does not reach a roller that slides through x = y = 0.5 m."""
    text = model_of("follower_along_its_face").replace("{0, 0.25}", "{0.5, 0.5}")
    text = text.replace("connect(world.frame_b, guide", "connect(cap.frame_b, guide")
    text = text.replace("StraightLine curve2(s_min=-0.1, s_max=0.1)", "Circle curve2(R=0.01)")
    hint = hint_of(text)
    assert "lengths" in hint
    assert "direction" not in hint
