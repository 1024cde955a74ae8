"""Maxima between the rows of a result."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.study.extremum import highest, lowest

EXAMPLES = Path(__file__).parents[2] / "examples"
SWING = """model Swing
  parameter Real a = 1;
  Real x(start=0, fixed=true);
  Real v(start=a, fixed=true);
  Real power = 3*x*v;
  parameter Real c = 2;
equation
  der(x) = v;
  der(v) = -x;
  annotation(experiment(StopTime=6.9, Tolerance=1e-9));
end Swing;"""
RELAY = """model Relay
  Real x(start=0, fixed=true);
  Real y = if x > 0.93 then 1 + sin(3*time) else x;
  discrete Real m(start=0, fixed=true);
equation
  der(x) = cos(time);
  when x > 0.5 then
    m = 4*x;
  end when;
  annotation(experiment(StopTime=7, Tolerance=1e-9));
end Relay;"""


@pytest.mark.parametrize("rows", [20, 50, 400])
@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_swing_is_as_high_as_its_law(rows: int, backend: str) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    result = planarc.load(SWING, backend=backend).simulate(intervals=rows)
    for name, high in (("x", 1.0), ("v", 1.0), ("power", 1.5)):
        assert highest(result, name) == pytest.approx(high, abs=1e-5)
        assert lowest(result, name) == pytest.approx(-high, abs=1e-5)
    assert highest(result, "c") == 2
    assert result["x"].max() < 1 - 1e-6 or rows == 400


@pytest.mark.parametrize("name", ["revA.w", "revD.frame_a.f[1]", "revB.phi", "revA.z"])
def test_a_linkage_goes_as_far_as_with_many_rows(name: str) -> None:
    model = planarc.load(EXAMPLES / "four_bar.pmo")
    fine = model.simulate(2, intervals=50_000, tolerance=1e-9)[name]
    result = model.simulate(2, intervals=100, tolerance=1e-9)
    size = np.ptp(fine)
    assert highest(result, name) == pytest.approx(fine.max(), abs=3e-5 * size)
    assert lowest(result, name) == pytest.approx(fine.min(), abs=3e-5 * size)


def test_events_are_kept_apart() -> None:
    model = planarc.load(RELAY)
    fine, result = model.simulate(intervals=20_000), model.simulate(intervals=60)
    for name in ("x", "y", "m"):
        assert highest(result, name) == pytest.approx(fine[name].max(), abs=1e-5)
        assert lowest(result, name) == pytest.approx(fine[name].min(), abs=1e-5)


def test_what_no_rows_surround_and_what_no_model_explains_are_the_rows(tmp_path: Path) -> None:
    run = planarc.load(SWING).simulate(intervals=20)
    alone = planarc.read(run.to_csv(tmp_path / "run.csv", ["x"]))
    bare = planarc.Result(alone.rows)
    assert highest(bare, "x") == bare["x"].max()
    assert highest(planarc.load(SWING).simulate(0), "x") == 0


def test_a_study_takes_the_motion_not_the_rows() -> None:
    model = planarc.load(SWING)
    study = planarc.sweep(
        model, {"a": [1.0, 2.0]}, ["max(x)", "range(x)", "maxabs(power)"], intervals=20, workers=1
    )
    assert study["max(x)"] == pytest.approx([1, 2], abs=1e-5)
    assert study["range(x)"] == pytest.approx([2, 4], abs=1e-5)
    assert study["maxabs(power)"] == pytest.approx([1.5, 6], abs=1e-4)


ECHO = """model Echo
  parameter Real a = 1;
  Real x(start=0, fixed=true);
  Real v(start=a, fixed=true);
  Real power = 3*x*v;
  Real before = delay(x, 0.3);
equation
  der(x) = v;
  der(v) = -x;
  annotation(experiment(StopTime=6.9, Tolerance=1e-9));
end Echo;"""


def test_states_of_a_model_with_delays_are_followed_between_the_rows() -> None:
    model = planarc.load(ECHO)
    study = planarc.sweep(model, {"a": [1.0, 2.0]}, ["max(x)", "min(v)"], intervals=40, workers=1)
    assert study["max(x)"] == pytest.approx([1, 2], abs=1e-5)
    assert study["min(v)"] == pytest.approx([-1, -2], abs=1e-5)
    assert not study.warnings


def test_a_study_tells_where_rows_count_alone() -> None:
    model = planarc.load(ECHO)
    asked = ["max(power)", "final(power)", "range(a)", "max(x)"]
    study = planarc.sweep(model, {"a": [1.0]}, asked, intervals=20, workers=1)
    rows = model.simulate(intervals=20)["power"]
    assert study["max(power)"] == [rows.max()]
    (told,) = study.warnings
    assert (told.code, told.span.text) == ("C231", "delay(x, 0.3)")
    assert "`max(power)` is that of the rows" in told.message
