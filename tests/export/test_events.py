"""FMUs of models with events: their events fall where planarc's do, and so do their values."""

from __future__ import annotations

import platform
from functools import cache
from itertools import pairwise
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.solve.solvers.cvode import SHARE
from tests.export.fmus import HERE, WAYS, runs_here, simulate, written

both_here = pytest.mark.skipif(
    not HERE or platform.machine() != "x86_64", reason="there is no library of FMI 2 for it"
)
VERSIONS = (2, 3)

BALL = """
model Ball "Falls, bounces, counts"
  parameter Real e=0.8;
  output Real h(start=1, fixed=true);
  output Real v(start=0, fixed=true);
  output Integer n(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h <= 0 then
    reinit(v, -e*pre(v));
    n = pre(n) + 1;
  end when;
  annotation(experiment(StopTime=2));
end Ball;
"""
STICK_SLIP = """
model StickSlip "A mass on a belt, held by a spring: it sticks, then slips"
  parameter Real F0=1.5;
  parameter Real F1=1;
  parameter Real belt=0.5;
  output Real x(start=0, fixed=true);
  output Real v(start=0, fixed=true);
  output Boolean stuck(start=false, fixed=true);
  output Real f;
  Real r = belt - v;
equation
  der(x) = v;
  der(v) = if stuck then 0 else f - 4*x;
  f = if stuck then 4*x elseif r > 0 then F1 else -F1;
  stuck = abs(4*x) < F0 and (pre(stuck) or r <= 0);
  when stuck then
    reinit(v, belt);
  end when;
  annotation(experiment(StopTime=10));
end StickSlip;
"""
SAMPLED = """
model Sampled "A sampled controller, and steps of what it is to reach"
  parameter Real T=0.1;
  output Real x(start=1, fixed=true);
  output Real v(start=0, fixed=true);
  discrete output Real u(start=0, fixed=true);
  discrete Real s(start=0, fixed=true);
  output Integer k(start=0, fixed=true);
  Real wanted = if time < 3.05 then 0 elseif time < 5 then 1 else -0.5;
equation
  der(x) = v;
  der(v) = u - 0.3*v - x;
  when sample(0, T) then
    s = pre(s) + T*(wanted - x);
    u = 2*(wanted - x) + 0.6*s - 0.5*v;
    k = pre(k) + 1;
  end when;
  annotation(experiment(StopTime=6));
end Sampled;
"""
PULSES = """
model Pulses "Relations of time, an instant that events move on, and what is true at first"
  output Real x(start=0, fixed=true);
  output Integer n(start=0, fixed=true);
  output Boolean odd(start=false, fixed=true);
  Real y = if sin(7*time) > 0.3 then 1 else -1;
  discrete Real next(start=0.37, fixed=true);
equation
  der(x) = y - x;
  when time >= pre(next) then
    next = pre(next) + 0.37;
    n = pre(n) + 1;
  end when;
  when {n > 3, initial()} then
    odd = not pre(odd);
  end when;
  annotation(experiment(StopTime=3));
end Pulses;
"""
ENDS = """
model Ends "Levels on the way up, and the end"
  parameter Real last=0.9;
  output Real x(start=0, fixed=true);
  output Boolean high = x > 0.5;
  output Integer level = if x > 0.8 then 2 elseif high then 1 else 0;
equation
  der(x) = 1 - 0.2*x;
  when x > last then
    terminate("it is high enough");
  end when;
  annotation(experiment(StopTime=3));
end Ends;
"""
BREAKS = """
model Breaks "An assertion at an event"
  output Real x(start=0, fixed=true);
equation
  der(x) = 1;
  when x > 0.5 then
    assert(x < 0.4, "it broke");
  end when;
  annotation(experiment(StopTime=1));
end Breaks;
"""
SLIPS = """
model Slips "What holds it wants to slide a little before it can"
  parameter Real back=1e-6 "How much less it wants once it slides";
  output Real x(start=0, fixed=true);
  Real wanted;
  output Boolean slides(start=false, fixed=true) = wanted > 1;
equation
  wanted = 2*time - (if slides then back else 0);
  der(x) = if slides then 1 else 0;
  annotation(experiment(StopTime=1));
end Slips;
"""
TABLE = """
model Table "A table of the library, which tells in which row it goes wrong"
  Modelica.Blocks.Sources.CombiTimeTable table(table={{0, 0}, {1, 2}, {2, 1}, {3, 4}});
  output Real x(start=0, fixed=true);
equation
  der(x) = table.y[1];
  annotation(experiment(StopTime=3));
end Table;
"""
TURNS = """
model Turns "What is true from the start on, though rounding looks at the start"
  Real phi(start=2.5, fixed=true);
  Integer turn=integer(phi);
  output Integer even(start=0, fixed=true), turns(start=0, fixed=true), begun(start=0, fixed=true);
equation
  der(phi) = 1;
  when mod(turn, 2) == 0 then
    even = pre(even) + 1;
  end when;
  when change(turn) then
    turns = pre(turns) + 1;
  end when;
  when {initial(), turn == 3} then
    begun = pre(begun) + 1;
  end when;
  annotation(experiment(StopTime=1));
end Turns;
"""
STRUCK = """
model Struck "A blow on a ball that rests on a yielding floor under a load"
  import PlanarMultiBody.*;
  inner World world;
  Joints.Prismatic slide(n={0, 1}, s(start=0.099, fixed=true), v(fixed=true));
  Parts.Body ball(m=1);
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    law=Types.ContactLaw.Compliant, c=1e6, e=0.8);
  Forces.WorldForce load;
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, ball.frame_a);
  connect(ball.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
  connect(load.frame_b, ball.frame_a);
  load.force = {0, if time > 0.1 and time < 0.101 then -2000 else -100};
  annotation(experiment(StopTime=0.2));
end Struck;
"""
TEXTS = {"Ball": BALL, "StickSlip": STICK_SLIP, "Sampled": SAMPLED, "Pulses": PULSES, "Ends": ENDS,
         "Breaks": BREAKS, "Slips": SLIPS, "Table": TABLE, "Turns": TURNS,
         "Struck": STRUCK}  # fmt: skip
LIBRARY = "PlanarMultiBody.Examples."
OWN = {  # of the library, with the time that is compared
    "Elementary.BouncingMass": 2.5,
    "Elementary.DrivenPendulum": 2.0,
    "Contacts.SoftLanding": 2.0,
    "Systems.QuickReturn": 2.0,
}
NAMES = ("Ball", "StickSlip", "Sampled", "Pulses", "Ends", "Slips", "Table", "Struck", *OWN)


@cache
def compiled(name: str) -> Compiled:
    if name in TEXTS:
        return compile_model(Request(Path(f"{name}.pmo"), text=TEXTS[name]))
    return compile_model(Request(class_name=LIBRARY + name))


@cache
def reference(name: str) -> Result:
    stop = OWN.get(name, compiled(name).program.experiment.stop)
    # The importer's CVODE holds its steps to 1e-11, and so does planarc's then.
    return run(compiled(name), RunOptions(stop=stop, intervals=100, tolerance=1e-11 / SHARE))


def archive(folder: Path, name: str, version: int = 3) -> Path:
    return written(folder / f"{name}{version}.fmu", compiled(name), version)


def misfit(name: str, table: np.ndarray) -> float:
    """The largest difference to planarc's run between its events, beside a variable's range."""
    result, program = reference(name), compiled(name).program
    events = np.array([e.time for e in result.events])
    columns = {c.name: c for c in program.columns}
    apart = np.abs(events[:, None] - table["time"]).min(0) > 1e-8
    rows = np.abs(result.time[:, None] - table["time"]).argmin(0)
    same = apart & (np.abs(result.time[rows] - table["time"]) < 1e-9)
    assert same.sum() > 0.3 * len(table)
    worst = 0.0
    for output in table.dtype.names[1:]:
        c = columns[output]
        values = c.sign * result.data[:, result.stored[c.slot]]
        missed = np.abs(values[rows[same]] - table[output][same].astype(float)).max()
        worst = max(worst, float(missed) / max(float(np.ptp(values)), 1e-9))
    return worst


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_fmpy_has_nothing_to_say(folder: Path, name: str, version: int) -> None:
    assert validate_fmu(str(archive(folder, name, version))) == []


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", NAMES)
def test_a_run_is_the_one_of_planarc(folder: Path, name: str, way: str) -> None:
    stop = OWN.get(name, compiled(name).program.experiment.stop)
    table = simulate(archive(folder, name), way, stop)
    ended = reference(name).ended
    assert ended is not None or table["time"][-1] == pytest.approx(stop)
    assert misfit(name, table) < 1e-6


@both_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ("Sampled", "StickSlip"))
def test_both_versions_run_alike(folder: Path, name: str, way: str) -> None:
    """The same code settles in both: equal to the last digit."""
    two, three = (simulate(archive(folder, name, v), way, 2.0) for v in VERSIONS)
    assert all((two[column] == three[column]).all() for column in two.dtype.names)


@runs_here
@pytest.mark.parametrize("name", NAMES)
def test_events_of_model_exchange_fall_where_planarcs_do(folder: Path, name: str) -> None:
    result = reference(name)
    table = simulate(archive(folder, name), "ModelExchange", float(result.time[-1]),
                     record_events=True)  # fmt: skip
    times = [e.time for e in result.events if e.time > 0]
    events = [t for before, t in pairwise((0.0, *times)) if t - before > 1e-6]
    assert events
    for t in events:  # others follow from what is looked ahead at the one before
        assert np.abs(table["time"] - t).min() < 1e-9, t


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_other_parameters_move_events(folder: Path, way: str) -> None:
    """A sampler of another interval, a bounce of another height."""
    table = simulate(archive(folder, "Sampled"), way, 1.0, start_values={"T": 0.25})
    at = {round(t, 6): k for t, k in zip(table["time"], table["k"], strict=True)}
    assert [at[t] for t in (0.1, 0.3, 0.6, 0.9)] == [1, 2, 3, 4]
    table = simulate(archive(folder, "Ball"), way, 1.0, start_values={"e": 0.5, "h": 2.0})
    fall = np.sqrt(4 / 9.81)
    rows = np.abs(table["time"] - 0.9).argmin()
    since = 0.9 - fall
    assert table["n"][rows] == 1
    assert table["h"][rows] == pytest.approx(0.5 * 9.81 * fall * since - 9.81 / 2 * since**2)


@both_here
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("way", WAYS)
def test_what_is_true_at_first_does_not_act_there(folder: Path, way: str, version: int) -> None:
    table = simulate(archive(folder, "Turns", version), way, 1.0)
    ends = {name: [table[name][i] for i in (0, -1)] for name in ("even", "turns", "begun")}
    assert ends == {"even": [0, 0], "turns": [0, 1], "begun": [1, 2]}


@both_here
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("way", WAYS)
def test_terminate_ends_a_run(folder: Path, way: str, version: int) -> None:
    told: list[str] = []
    table = simulate(archive(folder, "Ends", version), way, 3.0,
                     logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    end = -5 * np.log(1 - 0.18)
    assert table["time"][-1] == pytest.approx(end, abs=0.031)
    assert f"terminated at t = {end:.6g} s: it is high enough" in told


@both_here
def test_a_step_that_the_model_ends_tells_its_last_time(folder: Path) -> None:
    path = archive(folder, "Ends", 2)
    description = fmpy.read_model_description(path)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    told: list[str] = []
    callbacks = fmpy.fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(
        lambda *given: told.append(given[-1].decode())
    )
    fmu.instantiate(callbacks=callbacks)
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=2.0)
    assert fmu.getBooleanStatus(3)
    assert fmu.getRealStatus(2) == pytest.approx(-5 * np.log(1 - 0.18), abs=1e-7)
    assert told == ["terminated at t = 0.992255 s: it is high enough"]
    fmu.terminate()


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_an_assertion_at_an_event_is_told(folder: Path, way: str) -> None:
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(archive(folder, "Breaks"), way, 1.0,
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert told[0] == "assertion failed at t = 0.5 s: it broke"


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_a_text_that_is_put_together_while_running_is_left_out(folder: Path, way: str) -> None:
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(archive(folder, "Table"), way, 3.0, start_values={"table.table[3,1]": 0.5},
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    said = "assertion failed at t = 0 s in `table`: the first column of a table does not increase"
    assert told[0] == f"{said} at ...: sort the rows"


@runs_here
def test_a_saved_state_holds_what_is_discrete(folder: Path) -> None:
    """Ticks, truths and left limits: the same end from there, to the last digit."""
    path = archive(folder, "Sampled")
    description = fmpy.read_model_description(path)
    names = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()

    def go(first: int, last: int) -> tuple[float, ...]:
        for i in range(first, last):
            fmu.doStep(currentCommunicationPoint=0.07 * i, communicationStepSize=0.07)
        numbers = fmu.getFloat64([names[n] for n in ("x", "v", "u")])
        return (*numbers, *fmu.getInt32([names["k"]]))

    go(0, 10)
    state = fmu.getFMUState()
    end = go(10, 50)
    fmu.setFMUState(state)
    assert go(10, 50) == end
    fmu.freeFMUState(state)


@runs_here
def test_events_without_end_are_told(folder: Path) -> None:
    """Bounces of a ball pile up where it comes to rest."""
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(archive(folder, "Ball"), "CoSimulation", 3.0, start_values={"e": 0.3},
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    end = np.sqrt(2 / 9.81) * 1.3 / 0.7  # of the geometric series
    said = "events follow each other without end at t = "
    assert said in told[0] and float(told[0].split()[9]) == pytest.approx(end, abs=1e-4)
