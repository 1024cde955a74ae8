"""The implicit steps of exported models, by their laws."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

import planarc
from tests.export.fmus import runs_here

#: Prothero's and Robinson's equation, whose solution is that of the slow part.
FOLLOWS = """
model Follows
  parameter Real k=1e6;
  output Real x(start=1, fixed=true);
equation
  der(x) = -k*(x - cos(time)) - sin(time);
end Follows;
"""
RELAXES = """
model Relaxes "Van der Pol's oscillator"
  parameter Real mu=1000;
  output Real x(start=2, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = mu*((1 - x^2)*v) - x;
end Relaxes;
"""
SWINGS = """
model Swings
  output Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -9*x;
end Swings;
"""


def run(path: Path, stop: float, points: int, **start: object) -> np.ndarray:
    return fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=stop,
                             output_interval=stop / points, start_values=start)  # fmt: skip


@runs_here
@pytest.mark.parametrize("k", (1.0, 1e3, 1e6, 1e9))
def test_what_is_stiff_follows_the_slow_part(tmp_path: Path, k: float) -> None:
    path = planarc.load(FOLLOWS).export_fmu(tmp_path / "a.fmu", stiff=True)
    table = run(path, 10.0, 37, k=k)
    assert table["x"] == pytest.approx(np.cos(table["time"]), abs=2e-6)


@runs_here
def test_a_relaxation_is_that_of_planarc(tmp_path: Path) -> None:
    model = planarc.load(RELAXES)
    path = model.export_fmu(tmp_path / "a.fmu", stiff=True)
    table = run(path, 500.0, 50)
    result = model.simulate(500, intervals=50, tolerance=1e-10)
    assert table["x"] == pytest.approx(np.interp(table["time"], result.time, result["x"]), abs=1e-5)


@runs_here
def test_what_is_not_stiff_is_followed_too(tmp_path: Path) -> None:
    path = planarc.load(SWINGS).export_fmu(tmp_path / "a.fmu", stiff=True)
    for points in (2_000, 7):
        table = run(path, 4.0, points)
        assert table["x"] == pytest.approx(np.cos(3 * table["time"]), abs=2e-6)


@runs_here
def test_a_parameter_changes_the_method(tmp_path: Path) -> None:
    """Both ways give the same motion, but not the same digits."""
    path = planarc.load(SWINGS).export_fmu(tmp_path / "a.fmu")
    explicit, implicit = (run(path, 4.0, 50, _stiff=choice)["x"] for choice in (False, True))
    assert implicit == pytest.approx(explicit, abs=2e-6) and (implicit != explicit).any()
    chosen = planarc.load(SWINGS).export_fmu(tmp_path / "b.fmu", stiff=True)
    assert (run(chosen, 4.0, 50)["x"] == implicit).all()


@runs_here
def test_a_mechanism_exchanges_its_states_with_either(tmp_path: Path) -> None:
    file = Path(__file__).parents[2] / "examples" / "four_bar.pmo"
    path = planarc.load(file).export_fmu(tmp_path / "a.fmu", stiff=True)
    set = {"coupler.r[1]": 1.5}
    one, other = (run(path, 1.0, 20, **set, _stiff=choice) for choice in (True, False))
    assert one["revA.phi"] == pytest.approx(other["revA.phi"], abs=1e-4)


@runs_here
def test_events_end_implicit_steps(tmp_path: Path) -> None:
    """A ball that jumps twice, by its closed form."""
    text = """
model Ball
  output Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -10;
  when h <= 0 then
    reinit(v, -0.5*pre(v));
  end when;
end Ball;
"""
    path = planarc.load(text).export_fmu(tmp_path / "a.fmu", stiff=True)
    table = run(path, 0.9, 9)
    fall = np.sqrt(0.2)
    t = table["time"] - fall
    wanted = np.where(t < 0, 1 - 5 * table["time"] ** 2, 5 * fall * t - 5 * t**2)
    before = t < fall
    assert table["h"][before] == pytest.approx(wanted[before], abs=1e-7)
