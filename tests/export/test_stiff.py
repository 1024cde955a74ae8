"""The implicit steps of exported models, by their laws."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave

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
FED = """
model Fed
  input Real u(start=0);
  output Real x(start=0, fixed=true);
equation
  der(x) = u - x;
end Fed;
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


@runs_here
@pytest.mark.parametrize("stiff", (False, True))
@pytest.mark.parametrize("set", (False, True))
@pytest.mark.parametrize("length", (1e-30, 5e-324, 1e-17))
def test_steps_shorter_than_the_time_can_tell_move_nothing(
    tmp_path: Path, length: float, set: bool, stiff: bool
) -> None:
    """With and without new slopes, at the start and on the way."""
    path = planarc.load(FED).export_fmu(tmp_path / "a.fmu")
    description = fmpy.read_model_description(path)
    names = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    fmu.instantiate()
    fmu.setBoolean([names["_stiff"]], [stiff])
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    t = 0.0
    for _ in range(4):
        before = fmu.getFloat64([names["x"]])
        if set:
            fmu.setFloat64([names["u"]], [1.0])
        last = fmu.doStep(currentCommunicationPoint=t, communicationStepSize=length)[-1]
        assert last == t + length and fmu.getFloat64([names["x"]]) == pytest.approx(before)
        fmu.doStep(currentCommunicationPoint=last, communicationStepSize=0.25)
        t = last + 0.25
    wanted = (1 - np.exp(-1.0)) if set else 0.0
    assert fmu.getFloat64([names["x"]])[0] == pytest.approx(wanted, abs=1e-6)


@runs_here
@pytest.mark.parametrize("stiff", (False, True))
@pytest.mark.parametrize("length", (0.0, -0.01, np.nan, np.inf, 5.0))
def test_steps_of_no_length_and_beyond_the_end_are_errors(
    tmp_path: Path, length: float, stiff: bool
) -> None:
    """An illegal argument is an error by the standard; the instance is none the worse for it."""
    path = planarc.load(FED).export_fmu(tmp_path / "a.fmu")
    description = fmpy.read_model_description(path)
    names = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    told: list[str] = []
    fmu.instantiate(logMessage=lambda *given: told.append(given[-1].decode()))
    fmu.setBoolean([names["_stiff"]], [stiff])
    fmu.enterInitializationMode(stopTime=2.0)
    fmu.setFloat64([names["u"]], [1.0])
    fmu.exitInitializationMode()
    fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.5)
    with pytest.raises(fmpy.fmi1.FMICallException) as failed:
        fmu.doStep(currentCommunicationPoint=0.5, communicationStepSize=length)
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.doStep(currentCommunicationPoint=np.nan, communicationStepSize=0.1)
    assert failed.value.status == 3
    beyond = "the step goes beyond the stop time"
    assert told == [beyond if length == 5.0 else "the length of the step is not above zero",
                    "the step does not begin where the last one ended"]  # fmt: skip
    fmu.doStep(currentCommunicationPoint=0.5, communicationStepSize=0.5)
    assert fmu.getFloat64([names["x"]])[0] == pytest.approx(1 - np.exp(-1.0), abs=1e-6)
