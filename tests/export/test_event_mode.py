"""Co-simulation of FMI 3 with event mode, early return and looks within steps."""

from __future__ import annotations

import ctypes
from itertools import pairwise
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Model, FMU3Slave

from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES, runs_here, written
from tests.export.test_events import NAMES, OWN, archive, compiled, misfit, reference

WAYS = {"early": {"early_return_allowed": True}, "events": {"use_event_mode": True},
        "both": {"early_return_allowed": True, "use_event_mode": True}}  # fmt: skip
FED = """
model Fed "A heater that an input switches"
  input Real u(start=0);
  output Real x(start=0, fixed=true);
  output Integer n(start=0, fixed=true);
equation
  der(x) = u - x;
  when u > 0.5 then
    n = pre(n) + 1;
  end when;
end Fed;
"""


class Slave:
    """An instance, its steps and what its logger was told."""

    def __init__(self, path: Path, events: bool = True, early: bool = True, look: object = None,
                 wanted: tuple[str, ...] = ()) -> None:  # fmt: skip
        description = fmpy.read_model_description(path)
        self.names = {v.name: v.valueReference for v in description.modelVariables}
        self.told: list[str] = []
        self.fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                             modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
        self.fmu.instantiate(
            eventModeUsed=events, earlyReturnAllowed=early, intermediateUpdate=look,
            requiredIntermediateVariables=[self.names[n] for n in wanted],
            logMessage=lambda *given: self.told.append(given[-1].decode()),
        )  # fmt: skip
        self.fmu.enterInitializationMode(tolerance=1e-12)
        self.fmu.exitInitializationMode()
        if events:
            self.fmu.updateDiscreteStates()
            self.fmu.enterStepMode()

    def step(self, t: float, h: float) -> tuple[bool, bool, bool, float]:
        found: tuple[bool, bool, bool, float] = self.fmu.doStep(t, h)
        return found

    def handle(self) -> None:
        self.fmu.enterEventMode()
        self.fmu.updateDiscreteStates()
        self.fmu.enterStepMode()

    def value(self, name: str) -> float:
        found: float = self.fmu.getFloat64([self.names[name]])[0]
        return found


def stop_of(name: str) -> float:
    return OWN.get(name, compiled(name).program.experiment.stop)


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", NAMES)
def test_values_are_those_of_planarc(folder: Path, name: str, way: str) -> None:
    stop = stop_of(name)
    table = fmpy.simulate_fmu(
        archive(folder, name), fmi_type="CoSimulation", stop_time=stop, relative_tolerance=1e-11,
        output_interval=stop / 100, record_events=False, **WAYS[way],
    )  # fmt: skip
    assert misfit(name, table) < 1e-6


@runs_here
@pytest.mark.parametrize("way", ("early", "both"))
@pytest.mark.parametrize("name", ("Ball", "StickSlip", "Sampled", "Pulses", "Ends",
                                  "Elementary.BouncingMass"))  # fmt: skip
def test_steps_end_at_events(folder: Path, name: str, way: str) -> None:
    stop = stop_of(name)
    table = fmpy.simulate_fmu(
        archive(folder, name), fmi_type="CoSimulation", stop_time=stop, relative_tolerance=1e-12,
        output_interval=stop / 100, record_events=True, **WAYS[way],
    )  # fmt: skip
    result = run(compiled(name), RunOptions(stop=stop, intervals=100, tolerance=1e-12))
    times = [e.time for e in result.events if e.time > 0]
    events = [t for before, t in pairwise((0.0, *times)) if t - before > 1e-6]
    assert events
    for t in events:
        assert np.abs(table["time"] - t).min() < 1e-9, t


@runs_here
def test_an_event_is_handed_over_before_it_happens(folder: Path) -> None:
    """The values are those of the left limit until the host has the event handled."""
    ball = Slave(archive(folder, "Ball"))
    event, ended, early, last = ball.step(0.0, 1.0)
    fall = np.sqrt(2 / 9.81)
    assert (event, ended, early) == (True, False, True) and last == pytest.approx(fall, abs=1e-9)
    assert ball.value("v") == pytest.approx(-9.81 * fall)
    with pytest.raises(FMICallException):
        ball.step(last, 0.1)
    assert ball.told[-1] == "an event is to be handled in event mode before the next step"
    ball.handle()
    assert ball.value("v") == pytest.approx(0.8 * 9.81 * fall)
    assert ball.step(last, 0.1) == (False, False, False, last + 0.1)


@runs_here
def test_a_saved_state_knows_that_an_event_waits(folder: Path) -> None:
    ball = Slave(archive(folder, "Ball"))
    last = ball.step(0.0, 1.0)[3]
    state = ball.fmu.getFMUState()
    ball.handle()
    ball.fmu.setFMUState(state)
    with pytest.raises(FMICallException):
        ball.step(last, 0.1)
    ball.handle()
    assert ball.value("v") > 0


@runs_here
def test_no_step_ends_early_where_that_is_not_allowed(folder: Path) -> None:
    """Events within a step are the model's own business; one at its end is the host's."""
    ball = Slave(archive(folder, "Ball"), early=False)
    assert ball.step(0.0, 1.0) == (False, False, False, 1.0)
    sampled = Slave(archive(folder, "Sampled"), early=False)
    assert sampled.step(0.0, 0.25) == (False, False, False, 0.25)
    assert sampled.step(0.25, 0.05)[0]
    sampled.handle()
    assert sampled.fmu.getInt32([sampled.names["k"]]) == [4]


@runs_here
def test_an_input_that_switches_waits_at_once(tmp_path: Path) -> None:
    path = written(tmp_path / "a.fmu", compile_model(Request(Path("Fed.pmo"), text=FED)), 3)
    fed = Slave(path)
    fed.step(0.0, 0.5)
    fed.fmu.setFloat64([fed.names["u"]], [0.4])  # no event: it goes on
    assert fed.step(0.5, 0.5) == (False, False, False, 1.0)
    assert fed.value("x") == pytest.approx(0.4 * (1 - np.exp(-0.5)))
    fed.fmu.setFloat64([fed.names["u"]], [1.0])
    assert fed.step(1.0, 0.5) == (True, False, True, 1.0)
    fed.handle()
    assert fed.step(1.0, 0.5) == (False, False, False, 1.5)
    assert fed.fmu.getInt32([fed.names["n"]]) == [1]
    fed.fmu.enterEventMode()  # discrete changes are made there
    fed.fmu.setFloat64([fed.names["u"]], [0.0])
    fed.fmu.updateDiscreteStates()
    fed.fmu.setFloat64([fed.names["u"]], [0.9])
    fed.fmu.updateDiscreteStates()
    fed.fmu.enterStepMode()
    assert fed.fmu.getInt32([fed.names["n"]]) == [2]


@runs_here
def test_calls_of_another_mode_are_refused(folder: Path) -> None:
    path = archive(folder, "Ball")
    plain = Slave(path, events=False)
    for call in ("enterEventMode", "enterStepMode", "updateDiscreteStates"):
        with pytest.raises(FMICallException):
            getattr(plain.fmu, call)()
    assert plain.told[0] == "fmi3EnterEventMode: the instance was made without event mode"
    slave = Slave(path)
    slave.fmu.enterEventMode()
    for call, given in (("enterContinuousTimeMode", ()), ("setTime", (0.1,)),
                        ("doStep", (0.0, 0.1))):  # fmt: skip
        with pytest.raises(FMICallException):
            getattr(slave.fmu, call)(*given) if call == "doStep" else getattr(
                FMU3Model, call)(slave.fmu, *given)  # fmt: skip
    assert all("cannot be called now" in text for text in slave.told) and len(slave.told) == 3
    slave.fmu.enterStepMode()
    assert slave.step(0.0, 0.1)[3] == 0.1


@runs_here
def test_the_end_of_a_run_ends_its_step(folder: Path) -> None:
    ends = Slave(archive(folder, "Ends"), events=False)
    end = -5 * np.log(1 - 0.18)
    t, over, early = 0.0, False, False
    while not over:
        _, over, early, t = ends.step(t, 3.0 - t)
    assert early and t == pytest.approx(end, abs=1e-9)
    assert ends.step(t, 3.0 - t) == (False, True, True, t)


@runs_here
def test_events_without_end_are_told(folder: Path) -> None:
    told: list[str] = []
    with pytest.raises(FMICallException):
        fmpy.simulate_fmu(
            archive(folder, "Ball"), fmi_type="CoSimulation", stop_time=3.0,
            start_values={"e": 0.3}, logger=lambda *given: told.append(given[-1].decode()),
            **WAYS["both"],
        )  # fmt: skip
    assert "events follow each other without end" in told[0]


@runs_here
@pytest.mark.parametrize("early", (False, True))
def test_the_host_looks_at_accepted_steps_and_may_end_them(folder: Path, early: bool) -> None:
    seen: list[tuple[float, float]] = []
    refused: list[int] = []

    def look(host: object, t: float, setting: bool, getting: bool, finished: bool, can: bool,
             wanted: object, until: object) -> None:  # fmt: skip
        assert (setting, getting, finished, can) == (False, True, True, early)
        seen.append((t, slave.value("h")))
        given = (slave.fmu.component, (ctypes.c_uint32 * 1)(slave.names["h"]), 1,
                 (ctypes.c_double * 1)(3.0), 1)  # fmt: skip
        refused.append(slave.fmu.dll.fmi3SetFloat64(*given))
        refused.append(slave.fmu.dll.fmi3Reset(slave.fmu.component))
        if t > 0.05:
            wanted[0] = True  # type: ignore[index]
            until[0] = 0.2  # type: ignore[index]

    slave = Slave(archive(folder, "Ball"), early=early, look=look, wanted=("h",))
    event, _, ended, last = slave.step(0.0, 0.4)
    times = [t for t, _ in seen]
    assert times == sorted(times) and times[-1] == last == (0.2 if early else 0.4)
    assert not event and ended is early
    for t, h in seen:
        assert h == pytest.approx(1 - 9.81 / 2 * t**2, abs=1e-9)
    assert refused and set(refused) == {3}


@runs_here
def test_to_be_looked_at_changes_no_value(folder: Path) -> None:
    """Steps end where the host's do, but the motion is the same."""
    looks: list[float] = []

    def look(host: object, t: float, *rest: object) -> None:
        looks.append(slave.value("x"))

    slave = Slave(archive(folder, "StickSlip"), events=False, early=False, look=look)
    for i in range(100):
        slave.step(i / 10, 0.1)
    assert len(looks) >= 100
    result = reference("StickSlip")
    assert slave.value("x") == pytest.approx(result["x"][-1], abs=1e-7)


def test_the_description_says_what_is_true(folder: Path) -> None:
    says = fmpy.read_model_description(archive(folder, "Ball")).coSimulation
    assert says.hasEventMode and says.providesIntermediateUpdate
    assert says.mightReturnEarlyFromDoStep and says.canReturnEarlyAfterIntermediateUpdate
    still = compile_model(Request(EXAMPLES / "four_bar.pmo"))
    says = fmpy.read_model_description(written(folder / "calm.fmu", still, 3)).coSimulation
    assert not says.mightReturnEarlyFromDoStep
