"""Requests that once got a quiet answer, and a wrong one."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import PlanarcError
from planarc.cli.app import run as command

PENDULUM = Path(__file__).parents[2] / "examples" / "pendulum.pmo"


@pytest.fixture(scope="module")
def pendulum() -> planarc.Model:
    return planarc.load(PENDULUM)


@pytest.fixture(scope="module")
def result(pendulum: planarc.Model) -> planarc.Result:
    return pendulum.simulate(1)


def refused(call: Callable[[], Any], code: str) -> str:
    with pytest.raises(planarc.UsageError) as problem:
        call()
    assert [d.code for d in problem.value.diagnostics] == [code]
    return str(problem.value)


def test_a_run_knows_nothing_before_and_after_it(result: planarc.Result) -> None:
    assert "from 0 to 1 s" in refused(lambda: result.at("hinge.phi", 99), "C214")
    refused(lambda: result.at("hinge.phi", [0.5, -0.1]), "C214")
    refused(lambda: result.at("hinge.phi", float("nan")), "C214")
    refused(lambda: result.at("hinge.phi", "soon"), "C202")


def test_rounding_at_the_ends_is_no_other_time(result: planarc.Result) -> None:
    ends = result.at("hinge.phi", [-1e-12, 1 + 1e-12])
    np.testing.assert_array_equal(ends, result["hinge.phi"][[0, -1]])


@pytest.mark.parametrize("value", [True, np.True_])
def test_a_truth_value_is_no_mass(pendulum: planarc.Model, value: Any) -> None:
    assert "not true" in refused(
        lambda: pendulum.simulate(0.1, parameters={"rod.m": value}), "C202"
    )


def test_a_truth_value_is_no_mass_in_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["simulate", str(PENDULUM), "--set", "rod.m=true", "--no-output"]) == 2
    assert "`rod.m` takes a number, not true" in capsys.readouterr().err


def test_a_parameter_has_no_start_value(pendulum: planarc.Model) -> None:
    text = refused(lambda: pendulum.simulate(0.1, start={"rod.m": 2}), "C213")
    assert 'parameters={"rod.m": ...}' in text


@pytest.mark.parametrize(
    ("write", "name"),
    [
        (lambda r, path: r.report(path), "x.pdf"),
        (lambda r, path: r.to_csv(path), "x.xlsx"),
        (lambda r, path: r.to_mat(path), "x.csv"),
    ],
)
def test_no_file_has_the_ending_of_another_kind(
    result: planarc.Result, tmp_path: Path, write: Callable[..., Any], name: str
) -> None:
    refused(lambda: write(result, tmp_path / name), "V506")
    assert list(tmp_path.iterdir()) == []


def test_a_number_is_no_path(result: planarc.Result) -> None:
    for write in (result.to_csv, result.report, result.animate):
        assert "not 3" in refused(lambda: write(3), "C202")  # type: ignore[operator] # noqa: B023


@pytest.mark.parametrize("wrong", [{"width": "wide"}, {"speed": "fast"}, {"at": [1]}])
def test_sizes_and_times_of_pictures_are_numbers(
    result: planarc.Result, tmp_path: Path, wrong: dict[str, Any]
) -> None:
    (name,) = wrong
    assert f"`{name}`" in refused(lambda: result.animate(tmp_path / "x.svg", **wrong), "C202")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [({"class_name": 7}, "7"), ({"libraries": 3}, "3"), ({"libraries": [3]}, "3")],
)
def test_names_and_folders_are_texts(wrong: dict[str, Any], told: str) -> None:
    text = "model M\n  Real x = time;\nend M;"
    assert f"not {told}" in refused(lambda: planarc.load(text, **wrong), "C202").replace("[", "")


def test_a_name_without_ending_gets_one(result: planarc.Result, tmp_path: Path) -> None:
    assert result.to_csv(tmp_path / "run.2").name == "run.2.csv"
    assert result.report(tmp_path / "run").name == "run.html"


def test_numbers_beyond_all_floats_are_not_finite(pendulum: planarc.Model) -> None:
    refused(lambda: pendulum.simulate(10**400), "C202")
    refused(lambda: pendulum.simulate(0.1, parameters={"rod.m": 10**400}), "C202")


def test_a_result_is_no_model(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time,x\n0,1\n")
    assert "planarc view" in refused(lambda: planarc.load(path), "C206")


def test_names_that_no_file_can_have_are_refused() -> None:
    refused(lambda: planarc.load("a\0b"), "C108")


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there is no endless device")
def test_what_has_no_end_is_not_read(tmp_path: Path) -> None:
    import os

    refused(lambda: planarc.load(Path("/dev/zero")), "C108")
    pipe = tmp_path / "pipe.pmo"
    os.mkfifo(pipe)
    refused(lambda: planarc.load(pipe), "C108")


def test_a_name_that_stands_elsewhere_says_where() -> None:
    with pytest.raises(AttributeError, match=r"planarc\.load\(.*\)\.simulate"):
        planarc.simulate  # noqa: B018


def test_progress_that_cannot_be_called_is_told_before_the_run(pendulum: planarc.Model) -> None:
    refused(lambda: pendulum.simulate(0.1, progress=3), "C202")  # type: ignore[arg-type]


def test_one_layer_and_one_trace_need_no_list(result: planarc.Result, tmp_path: Path) -> None:
    path = result.animate(tmp_path / "x.svg", traces="rod", layers="forces")
    assert path.stat().st_size > 1000


SLIDE = """
model Slide
  inner PlanarMultiBody.World world(n={n});
  PlanarMultiBody.Joints.Prismatic slide(n={1, 0}, s(start=0.2), v(start=0));
  PlanarMultiBody.Parts.Body load(m=1, I=0.1);
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, load.frame_a);
end Slide;
"""


def test_a_block_on_a_level_slide_rests_in_neutral_equilibrium(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "slide.pmo"
    path.write_text(SLIDE.replace("{n}", "{0, -1}"))
    rest = planarc.load(path).equilibrium()
    assert (rest.stable, rest.neutral, rest.kind) == (False, True, "neutral")
    assert rest["slide.s"] == 0.2
    assert command(["equilibrium", str(path)]) == 0
    assert "rests in a neutral equilibrium" in capsys.readouterr().out


def test_what_cannot_move_rests_stably() -> None:
    still = "model Still\n  Real x = 1;\nend Still;\n"
    assert planarc.load(still).equilibrium().kind == "stable"


def test_a_model_never_changes() -> None:
    model = planarc.load("model M\n  parameter Real a = 1;\n  Real x = a*time;\nend M;")

    def assign(names: Any, name: str) -> None:
        names[name] = 2

    assert 'parameters={"a": ...}' in refused(lambda: assign(model.parameters, "a"), "C202")
    assert 'start={"x": ...}' in refused(lambda: assign(model.variables, "x"), "C202")
    assert "there is no" in refused(lambda: assign(model.parameters, "q"), "C201")


def test_an_index_of_0_is_told_where_counting_begins() -> None:
    model = planarc.load("model M\n  Real r[2] = {time, 2*time};\nend M;")
    told = refused(lambda: model.simulate(1.0)["r[0]"], "C201")
    assert "indices count from 1: the first is `r[1]`" in told
    assert "r[2]" not in told


HANGING = """
model Hanging
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.BodyShape rod(r={1, 0}, m=1);
  PlanarMultiBody.Contacts.<part>;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(<a>, touch.frame_a);
  connect(<b>, touch.frame_b);
end Hanging;
"""


@pytest.mark.parametrize(
    ("part", "a", "b", "told"),
    [
        ("RevoluteStops touch(phi_min=-0.6)", "hinge.frame_a", "hinge.frame_b", "`touch.lower`"),
        ("Rope touch(length=1.6)", "world.frame_b", "rod.frame_b", "`touch`"),
    ],
    ids=["stop", "rope"],
)
def test_a_state_of_rest_beyond_what_touches_is_none(part: str, a: str, b: str, told: str) -> None:
    text = HANGING.replace("<part>", part).replace("<a>", a).replace("<b>", b)
    if "Rope" in part:  # from above, so that it is taut before the rod hangs
        text = text.replace("world.frame_b, touch", "above.frame_b, touch").replace(
            "equation", "  PlanarMultiBody.Parts.Fixed above(r={0, 1});\nequation", 1
        )
    with pytest.raises(PlanarcError, match="the way down to rest leads through") as caught:
        planarc.load(text).equilibrium()
    (found,) = caught.value.diagnostics
    assert found.code == "R471"
    assert told in found.message
    assert found.span is not None and found.span.text.startswith("touch")


def test_a_ball_above_a_floor_is_held_by_it() -> None:
    """It falls on and on without it, which is no answer; where it touches, it rests."""
    model = planarc.load("""
model Above
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Prismatic slide(n={0, 1}, s(start=0.5, fixed=true), v(fixed=true));
  PlanarMultiBody.Parts.Body ball(m=1, I=0.1);
  PlanarMultiBody.Contacts.Contact floor(
    redeclare PlanarMultiBody.Contacts.Circle contour1(R=0.1));
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, ball.frame_a);
  connect(ball.frame_a, floor.frame_a);
  connect(world.frame_b, floor.frame_b);
end Above;
""")
    with pytest.raises(PlanarcError, match="the way down to rest leads through `floor`"):
        model.equilibrium()
    assert model.equilibrium(start={"slide.s": 0.1}).stable


def test_what_only_presses_cannot_pull_at_rest() -> None:
    """A ball that rests on the ground, under a spring that draws it up in the end."""
    text = """
model Drawn
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Prismatic slide(n={0, 1}, s(start=0.1, fixed=true), v(fixed=true));
  PlanarMultiBody.Parts.Body ball(m=1, I=0.1);
  PlanarMultiBody.Contacts.Contact floor(
    redeclare PlanarMultiBody.Contacts.Circle contour1(R=0.1),
    redeclare PlanarMultiBody.Contacts.HalfPlane contour2);
  PlanarMultiBody.Forces.WorldForce pull(force={0, 20});
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, ball.frame_a);
  connect(ball.frame_a, floor.frame_a);
  connect(world.frame_b, floor.frame_b);
  connect(ball.frame_a, pull.frame_b);
end Drawn;
"""
    with pytest.raises(PlanarcError) as caught:
        planarc.load(text).equilibrium()
    assert {d.code for d in caught.value.diagnostics} == {"R471"}
    held = planarc.load(text.replace("{0, 20}", "{0, 5}")).equilibrium()
    assert held["slide.s"] == pytest.approx(0.1)


def test_geared_shafts_rest_stably() -> None:
    """The phase of their teeth is no way to go, and the turning of either is that of both."""
    text = """
model Geared
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Parts.Fixed ground(r={0.15, 0});
  PlanarMultiBody.Joints.Revolute a(phi(fixed=true), w(start=3, fixed=true)), b(phi(fixed=true));
  PlanarMultiBody.Parts.Body wheel(m=1, I=0.01), weight(m=1, I=0.05, r_CM={0.02, 0});
  PlanarMultiBody.Contacts.GearPair pair(Ra=0.05, Rb=0.1);
equation
  connect(world.frame_b, a.frame_a);
  connect(ground.frame_b, b.frame_a);
  connect(a.frame_b, wheel.frame_a);
  connect(b.frame_b, weight.frame_a);
  connect(pair.frame_a, a.frame_b);
  connect(pair.frame_b, b.frame_b);
end Geared;
"""
    rest = planarc.load(text).equilibrium()
    assert rest.kind == "stable"
    assert math.cos(rest["b.phi"]) == pytest.approx(0, abs=1e-6)
    assert math.sin(rest["b.phi"]) == pytest.approx(-1)
