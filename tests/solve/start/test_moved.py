"""Which moves of guesses are told: many turns of a joint, and ways far beyond all parts."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest

from planarc.compiler import compile_model
from planarc.core.diagnostic import Severity
from planarc.core.options import Backend, RunOptions
from planarc.ir.result import Held
from planarc.request.request import Request
from planarc.solve.begun import Begun
from planarc.solve.settings import resolve
from planarc.solve.start.moved import judge_moved

SLIDER = """
model Slider
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute crank(phi(start=0.5));
  Parts.BodyShape arm(r={0.1, 0}, m=1, I=0.1);
  Joints.Revolute pin(phi(start=2.7));
  Parts.BodyShape rod(r={0.5, 0}, m=1, I=0.1);
  Joints.Revolute eye;
  Joints.Prismatic slide(n={1, 0}, s(start=-0.4));
equation
  connect(world.frame_b, crank.frame_a);
  connect(crank.frame_b, arm.frame_a);
  connect(arm.frame_b, pin.frame_a);
  connect(pin.frame_b, rod.frame_a);
  connect(rod.frame_b, eye.frame_a);
  connect(eye.frame_b, slide.frame_b);
  connect(world.frame_b, slide.frame_a);
end Slider;
"""


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Begun:
    file = tmp_path_factory.mktemp("moved") / "slider.pmo"
    Path(file).write_text(SLIDER, encoding="utf-8")
    compiled = compile_model(Request(file, None), Backend.NUMPY)
    options = RunOptions(stop=0.0, backend=Backend.NUMPY)
    run = Begun(compiled.program, compiled.load(), resolve(compiled.program, options), "numpy")
    run.begin()
    return run


@pytest.mark.parametrize(
    ("name", "start", "value", "told"),
    [
        ("pin.phi", 2.7, 2.7 + 22 * pi, "by 11 turns"),
        ("pin.phi", 2.7, 2.7 + 18 * pi, ""),
        ("slide.s", -0.4, -400.0, ""),
        ("eye.phi", 0.0, 22 * pi, ""),  # nobody wrote where it starts
        ("slide.s", -0.4, 600.0, "by 600.4 m, and its parts are 0.5 m long"),
        ("slide.v", 0.0, 1e6, ""),
    ],
)
def test_only_absurd_moves_are_told(
    begun: Begun, name: str, start: float, value: float, told: str
) -> None:
    found = judge_moved(begun.program, begun.kernel, (Held(name, start, value, False),))
    assert (found is not None) == bool(told)
    if found is not None:
        assert found.code == "R442" and found.message.endswith(told)
        assert found.severity is Severity.WARNING
        assert found.span is not None and name.partition(".")[0] in found.span.text


def test_the_farthest_of_all_is_told_and_nothing_of_what_is_held(begun: Begun) -> None:
    held = (
        Held("slide.s", -0.4, 600.0, False),
        Held("pin.phi", 2.7, 1e4, False),
        Held("crank.phi", 0.5, 1e6, True),
    )
    found = judge_moved(begun.program, begun.kernel, held)
    assert found is not None and "`pin.phi`" in found.message
    assert judge_moved(begun.program, begun.kernel, begun.held) is None


@pytest.mark.parametrize(
    ("name", "start", "value", "told"),
    [
        ("slide.s", -0.4, 0.39, True),
        ("slide.s", -0.4, 0.1, False),  # a rough guess
        ("slide.s", -0.4, -0.01, True),  # nothing is left of it
        ("slide.s", -0.4, -1.2, False),
        ("pin.phi", 2.7, 2.7 - 0.6 * pi, True),
        ("pin.phi", 2.7, 2.7 - 0.4 * pi, False),
        ("pin.phi", 2.7, 2.8 + 2 * pi, False),  # a whole turn leads back
        ("eye.phi", 0.0, pi, False),  # nobody wrote where it starts
    ],
)
def test_a_guess_on_another_side_is_a_note(
    begun: Begun, name: str, start: float, value: float, told: bool
) -> None:
    found = judge_moved(begun.program, begun.kernel, (Held(name, start, value, False),))
    assert (found is not None) == told
    if found is not None:
        assert found.severity is Severity.NOTE
        assert found.span is not None and name.partition(".")[0] in found.span.text
