"""Exported models with `delay`: against closed forms, and against planarc's own runs."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu

import planarc
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.compiler import run as run_model
from planarc.core.options import RunOptions
from planarc.export.fmu import make_fmu
from planarc.export.module import write_whole
from planarc.export.page.module import make_module
from planarc.export.wishes import Wishes
from planarc.instance.past.layout import sizes
from planarc.ir.result import Result
from planarc.request.request import Request
from tests.export.fmus import WAYS, runs_here, simulate, written
from tests.export.test_c import Run, misfit, needs_compiler, run  # noqa: F401
from tests.export.test_wasm import needs_node, of_node
from tests.solve.events.test_delays import by_steps

ECHO = """
model Echo "A loop that acts late"
  parameter Real T=1;
  output Real x(start=1, fixed=true);
equation
  der(x) = -delay(x, T);
  annotation(experiment(StopTime=4));
end Echo;
"""
CART = """
model Cart "A controller with dead time brings a body to its place"
  parameter Real lag=0.15;
  inner PlanarMultiBody.World world(g=0);
  PlanarMultiBody.Joints.Prismatic rail(drivenFlange=true,
    s(start=0.3, fixed=true), v(start=0, fixed=true));
  Modelica.Mechanics.Translational.Sources.Force drive;
  PlanarMultiBody.Parts.Body body(m=2, I=0.1);
  output Real s = rail.s;
  output Real f = -delay(6*rail.s + 5*rail.v, lag);
equation
  connect(world.frame_b, rail.frame_a);
  connect(rail.frame_b, body.frame_a);
  connect(drive.flange, rail.axis);
  drive.f = f;
  annotation(experiment(StopTime=4));
end Cart;
"""
VARYING = """
model Varying "A delay that changes"
  output Real x(start=1, fixed=true);
  output Real y;
  Real T = 0.4 + 0.3*sin(2*time);
equation
  y = delay(x, T, 1);
  der(x) = -2*y + sin(time);
  annotation(experiment(StopTime=3));
end Varying;
"""
STAIRS = """
model Stairs "Samples that come back late, and what follows from them"
  parameter Real T=0.33;
  discrete output Real u(start=0, fixed=true);
  output Real x(start=0, fixed=true);
  output Integer n(start=0, fixed=true);
  output Real late = delay(u, T);
equation
  der(x) = late - x;
  when sample(0, 0.1) then
    u = sin(5*time) - 0.4*x;
  end when;
  when late > 0.5 then
    n = pre(n) + 1;
  end when;
  annotation(experiment(StopTime=3));
end Stairs;
"""
RELAY = """
model Relay "Switches late"
  output Real x(start=0, fixed=true);
equation
  der(x) = if delay(x, 0.3) > 0.2 then -1 else 1;
  annotation(experiment(StopTime=3));
end Relay;
"""
STILL = """
model Still "Nothing but time"
  parameter Real T=0.7;
  output Real y = delay(sin(20*time), T);
  annotation(experiment(StopTime=3));
end Still;
"""
GIVEN = """
model Given "What a host gives, later"
  input Real u(start=0);
  output Real y = delay(u, 1);
  annotation(experiment(StopTime=2));
end Given;
"""
BENT = """
model Bent "The delay hangs on the state, and the value meets it"
  output Real x(start=1, fixed=true);
  output Real y = x*delay(x, 0.3 + 0.1*x, 1);
equation
  der(x) = -y;
end Bent;
"""
BEYOND = """
model Beyond "The delay becomes longer than it may"
  output Real y = delay(sin(time), 0.5*time, 1);
  annotation(experiment(StopTime=4));
end Beyond;
"""
TUNED = """
model Tuned "A gain that a host may change, and a delay time that it may not"
  parameter Real k=1;
  parameter Real T=1;
  output Real x(start=1, fixed=true);
equation
  der(x) = -k*delay(x, T);
end Tuned;
"""
OFTEN = """
model Often "Many more events within the delay than at export; u jumps at each, x does not"
  parameter Real T=0.07;
  parameter Real step=0;
  Real x(start=1, fixed=true), v(start=0, fixed=true);
  discrete Real n(start=0, fixed=true);
  Real u = x + step*n;
  output Real y = delay(u, 0.33);
equation
  der(x) = v;
  der(v) = -4*x;
  when sample(0.02, T) then
    n = pre(n) + 1;
  end when;
  annotation(experiment(StopTime=0.6, Interval=0.01, Tolerance=1e-8));
end Often;
"""
TEXTS = {"Echo": ECHO, "Cart": CART, "Varying": VARYING, "Stairs": STAIRS, "Relay": RELAY,
         "Still": STILL, "Given": GIVEN, "Bent": BENT, "Beyond": BEYOND,
         "Tuned": TUNED, "Often": OFTEN}  # fmt: skip
RUN = ("Echo", "Cart", "Varying", "Stairs", "Relay", "Still")


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(Path(f"{name}.pmo"), text=TEXTS[name]))


@cache
def reference(name: str) -> Result:
    return run_model(compiled(name), RunOptions(intervals=100, tolerance=1e-12))


def archive(folder: Path, name: str, version: int = 3) -> Path:
    return written(folder / f"{name}{version}.fmu", compiled(name), version)


def apart(name: str, table: np.ndarray) -> float:
    """The largest difference to planarc's run between its events, beside a variable's range."""
    result = reference(name)
    columns = {c.name: c for c in compiled(name).program.columns}
    events = np.array([-1.0, *(e.time for e in result.events)])
    rows = np.abs(result.time[:, None] - table["time"]).argmin(0)
    same = np.abs(events[:, None] - table["time"]).min(0) > 1e-7
    same &= np.abs(result.time[rows] - table["time"]) < 1e-9
    assert same.sum() > 0.8 * len(table)
    worst = 0.0
    for output in table.dtype.names[1:]:
        c = columns[output]
        values = c.sign * result.data[:, result.stored[c.slot]]
        missed = np.abs(values[rows[same]] - table[output][same].astype(float)).max()
        worst = max(worst, float(missed) / float(np.ptp(values)))
    return worst


@runs_here
@pytest.mark.parametrize("version", (2, 3))
@pytest.mark.parametrize("name", RUN)
def test_a_run_is_the_one_of_planarc(folder: Path, name: str, version: int) -> None:
    path = archive(folder, name, version)
    assert validate_fmu(str(path)) == []
    stop = compiled(name).program.experiment.stop
    for way in WAYS:
        assert apart(name, simulate(path, way, stop)) < 1e-6, way


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_the_method_of_steps(folder: Path, way: str) -> None:
    table = simulate(archive(folder, "Echo"), way, 4.0)
    assert table["x"] == pytest.approx([by_steps(t) for t in table["time"]], abs=1e-8)
    slow = simulate(archive(folder, "Echo"), way, 4.0, start_values={"T": 2.0})
    squared = [1 - t if t < 2 else 1 - t + (t - 2) ** 2 / 2 for t in slow["time"]]
    assert slow["x"] == pytest.approx(squared, abs=1e-8)


@runs_here
@pytest.mark.parametrize("early", (False, True))
@pytest.mark.parametrize("name", ("Echo", "Relay", "Varying"))
def test_hosts_that_handle_events_themselves(folder: Path, name: str, early: bool) -> None:
    stop = compiled(name).program.experiment.stop
    table = simulate(archive(folder, name), "CoSimulation", stop, use_event_mode=True,
                     early_return_allowed=early)  # fmt: skip
    assert apart(name, table) < 1e-6


@runs_here
@pytest.mark.parametrize("name", ("Echo", "Stairs"))
def test_implicit_steps_become_past(tmp_path: Path, name: str) -> None:
    path = tmp_path / "stiff.fmu"
    platforms = ("x86_64-linux", "aarch64-linux")
    path.write_bytes(make_fmu(compiled(name), Wishes(3, platforms=platforms, stiff=True)).data)
    stop = compiled(name).program.experiment.stop
    assert apart(name, simulate(path, "CoSimulation", stop)) < 1e-6


class Instance:
    """A run of co-simulation by hand."""

    def __init__(self, path: Path, unpacked: str) -> None:
        told = fmpy.read_model_description(path)
        self.names = {v.name: v.valueReference for v in told.modelVariables}
        self.fmu = FMU3Slave(guid=told.guid, unzipDirectory=unpacked,
                             modelIdentifier=told.coSimulation.modelIdentifier)  # fmt: skip
        self.fmu.instantiate()
        self.begin()

    def begin(self) -> None:
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def go(self, first: int, last: int, step: float = 0.07) -> list[float]:
        found = []
        for i in range(first, last):
            self.fmu.doStep(currentCommunicationPoint=step * i, communicationStepSize=step)
            found += self.get("x")
        return found

    def get(self, name: str) -> list[float]:
        values: list[float] = self.fmu.getFloat64([self.names[name]])
        return values


@runs_here
def test_a_saved_state_holds_the_past(folder: Path) -> None:
    path = archive(folder, "Stairs")
    unpacked = fmpy.extract(path)
    one = Instance(path, unpacked)
    one.go(0, 10)
    state = one.fmu.getFMUState()
    kept = one.fmu.serializeFMUState(state)
    end = one.go(10, 40)
    one.fmu.setFMUState(state)
    assert one.go(10, 40) == end
    other = Instance(path, unpacked)
    other.go(0, 3)
    other.fmu.setFMUState(other.fmu.deserializeFMUState(kept))
    assert other.go(10, 40) == end
    one.fmu.freeFMUState(state)


@runs_here
def test_reset_empties_the_past(folder: Path) -> None:
    path = archive(folder, "Stairs")
    one = Instance(path, fmpy.extract(path))
    first = one.go(0, 30)
    one.fmu.reset()
    one.begin()
    assert one.go(0, 30) == first


@runs_here
def test_instances_do_not_meet(folder: Path) -> None:
    path = archive(folder, "Stairs")
    unpacked = fmpy.extract(path)
    instances = [Instance(path, unpacked) for _ in range(50)]
    alone = Instance(path, unpacked).go(0, 30)
    with ThreadPoolExecutor(8) as pool:
        assert all(found == alone for found in pool.map(lambda i: i.go(0, 30), instances))


@runs_here
def test_a_gain_changes_on_the_way_and_a_delay_time_does_not(folder: Path) -> None:
    path = archive(folder, "Tuned")
    one = Instance(path, fmpy.extract(path))
    one.go(0, 1, 0.5)
    one.fmu.setFloat64([one.names["k"]], [2.0])
    assert one.go(1, 3, 0.5) == pytest.approx([-0.5, -1.25], abs=1e-9)
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.fmu.setFloat64([one.names["T"]], [2.0])


class Host:
    """Model exchange by hand, with steps of one length by the classical method of order 4."""

    def __init__(self, path: Path) -> None:
        told = fmpy.read_model_description(path)
        self.names = {v.name: v.valueReference for v in told.modelVariables}
        self.fmu = FMU3Model(guid=told.guid, unzipDirectory=fmpy.extract(path),
                             modelIdentifier=told.modelExchange.modelIdentifier)  # fmt: skip
        self.fmu.instantiate()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.count = told.numberOfContinuousStates
        self.next, self.times = 0.0, [0.0]
        self.event()

    def event(self) -> None:
        following = self.fmu.updateDiscreteStates()[-1]
        self.next = following if following > 0 else math.inf
        self.fmu.enterContinuousTimeMode()

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        self.fmu.setTime(t)
        given = (ctypes.c_double * max(self.count, 1))(*y)
        self.fmu.setContinuousStates(given, self.count)
        self.fmu.getContinuousStateDerivatives(given, self.count)
        return np.array(given[: self.count])

    def go(self, stop: float, h: float, strays: bool = False) -> list[float]:
        t, found = 0.0, []
        given = (ctypes.c_double * max(self.count, 1))()
        self.fmu.getContinuousStates(given, self.count)
        y = np.array(given[: self.count])
        while t < stop - 1e-12:
            end = min(t + h, self.next, stop)
            if strays:  # a step that is given up
                self.rates(t + 0.9 * (end - t), y + 5.0)
            s = end - t
            a = self.rates(t, y)
            b = self.rates(t + s / 2, y + s / 2 * a)
            c = self.rates(t + s / 2, y + s / 2 * b)
            d = self.rates(end, y + s * c)
            y, t = y + s / 6 * (a + 2 * b + 2 * c + d), end
            self.rates(t, y)
            self.fmu.completedIntegratorStep()
            if t >= self.next:
                self.fmu.enterEventMode()
                self.event()
            self.times.append(t)
            found += list(y) or self.fmu.getFloat64([self.names["y"]])
        return found


@runs_here
def test_steps_that_a_host_gives_up_leave_no_trace(folder: Path) -> None:
    plain, strayed = (Host(archive(folder, "Echo")).go(3.0, 0.03, s) for s in (False, True))
    assert plain == strayed
    assert plain[-1] == pytest.approx(by_steps(3.0), abs=1e-9)


@runs_here
def test_long_steps_of_a_host_end_where_the_past_does(folder: Path) -> None:
    """The host is told of the next instant in time, however long its steps are."""
    found = Host(archive(folder, "Echo")).go(4.0, 10.0)
    assert len(found) == 4 and found[-1] == pytest.approx(by_steps(4.0), abs=1e-6)


@runs_here
def test_the_past_is_thinned_without_loss(folder: Path) -> None:
    """Seven thousand steps lie within the delay, many more than there is room for."""
    host = Host(archive(folder, "Still"))
    found = np.array(host.go(1.5, 1e-4))
    t = np.array(host.times[1:])
    late = t > 0.7
    assert late.sum() > 7000
    assert np.abs(found[late] - np.sin(20 * (t[late] - 0.7))).max() < 1e-9


@runs_here
def test_a_past_that_jumps_too_often_is_told(folder: Path) -> None:
    path = archive(folder, "Given")
    told: list[str] = []
    description = fmpy.read_model_description(path)
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    fmu.instantiate(logMessage=lambda *given: told.append(given[-1].decode()))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    reference = next(v.valueReference for v in description.modelVariables if v.name == "u")

    def go() -> None:
        for i in range(9000):
            fmu.setFloat64([reference], [float(i % 7)])
            fmu.doStep(currentCommunicationPoint=1e-4 * i, communicationStepSize=1e-4)

    with pytest.raises(fmpy.fmi1.FMICallException):
        go()
    assert "of its past no more than" in told[0] and "pieces are kept" in told[0]


def late(t: np.ndarray, interval: float, step: float = 0.0) -> np.ndarray:
    """What `Often` delays."""
    s = np.maximum(t - 0.33, 0.0)
    return np.cos(2 * s) + step * np.maximum(np.floor((s - 0.02) / interval) + 1, 0)


@pytest.mark.parametrize("solver", ("exported", "exported-stiff"))
@pytest.mark.parametrize("interval", (3e-4, 1e-4, 3e-5))
def test_smooth_signals_are_right_however_many_events_there_are(
    interval: float, solver: str
) -> None:
    found = planarc.load(OFTEN).simulate(parameters={"T": interval}, solver=solver)
    assert found["y"] == pytest.approx(late(found.time, interval), abs=1e-9)


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_smooth_signals_of_archives_with_many_events(folder: Path, way: str) -> None:
    table = simulate(archive(folder, "Often"), way, 0.5, start_values={"T": 3e-4})
    missed = np.abs(table["y"] - late(table["time"], 3e-4)).max()
    assert missed < (1e-8 if way == "CoSimulation" else 1e-4)  # fmpy's own accuracy


def test_each_of_many_jumps_comes_back_or_the_run_ends() -> None:
    model = planarc.load(OFTEN)
    found = model.simulate(parameters={"T": 7e-4, "step": 1.0}, solver="exported")
    part = (found.time - 0.35) / 7e-4
    clear = np.abs(part - np.round(part)) > 1e-3
    exact = late(found.time, 7e-4, 1.0)
    assert found["y"][clear] == pytest.approx(exact[clear], abs=1e-9)
    with pytest.raises(planarc.PlanarcError, match="of its past no more than"):
        model.simulate(parameters={"T": 3e-4, "step": 1.0}, solver="exported")


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_what_a_host_gives_comes_back(folder: Path, way: str) -> None:
    rows = np.array([(0, 0.0), (0.5, 1.0), (2.0, 1.0)], dtype=[("time", float), ("u", float)])
    table = simulate(archive(folder, "Given"), way, 2.0, input=rows)
    late = np.interp(table["time"] - 1, rows["time"], rows["u"], left=0.0)
    held = 0.04 if way == "CoSimulation" else 1e-9  # inputs stay from step to step
    assert np.abs(table["y"] - late).max() <= held * 1.001


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("name", "values", "words"),
    (
        ("Echo", {"T": 0.0}, "the delay time of `delay(x, T)` is not above zero"),
        ("Beyond", {}, "is not between 0 and its largest one"),
    ),
)
def test_delay_times_that_cannot_be_are_told(
    folder: Path, way: str, name: str, values: dict[str, float], words: str
) -> None:
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(archive(folder, name), way, 4.0, start_values=values,
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert words in told[0]


@runs_here
def test_derivatives_take_the_past_as_given(folder: Path) -> None:
    """By a state that the delay time hangs on, too: against differences at one instant."""
    host = Host(archive(folder, "Bent"))
    found = host.go(1.0, 0.01)
    x, y = host.names["x"], host.names["y"]
    host.rates(1.0, np.array(found[-1:]))
    (slope,) = host.fmu.getDirectionalDerivative([y], [x], [1.0])
    h = 1e-6
    high, low = (-host.rates(1.0, np.array([found[-1] + s * h]))[0] for s in (1, -1))
    assert slope == pytest.approx((high - low) / (2 * h), rel=1e-6)
    assert slope != pytest.approx(-found[-1], rel=1e-3)


@needs_compiler
@pytest.mark.parametrize("stiff", (False, True))
@pytest.mark.parametrize("name", RUN)
def test_as_c(run: Run, tmp_path: Path, name: str, stiff: bool) -> None:  # noqa: F811
    model = planarc.load(TEXTS[name])
    done = run(model.export_c(tmp_path / "c", stiff=stiff))
    assert done.returncode == 0 and not done.stderr
    assert misfit(model, done.stdout) < 1e-6


@needs_compiler
def test_source_runs_as_the_library_does(tmp_path: Path) -> None:
    path = planarc.load(STAIRS).export_fmu(tmp_path / "a.fmu", source=True)
    binary = simulate(path, "CoSimulation", 3.0)
    unpacked = Path(fmpy.extract(path))
    (library,) = (unpacked / "binaries" / "x86_64-linux").glob("*.so")
    sources = sorted((unpacked / "sources").glob("*.c"))
    command = ["cc", "-std=c99", "-O1", "-shared", "-fPIC", *sources, "-lm", "-o", library]
    subprocess.run(command, check=True)
    names = [n for n in binary.dtype.names if n != "time"]
    table = fmpy.simulate_fmu(unpacked, fmi_type="CoSimulation", stop_time=3.0, output=names,
                              relative_tolerance=1e-11, output_interval=0.03)  # fmt: skip
    shutil.rmtree(unpacked)
    assert all(np.abs(binary[n] - table[n]).max() < 1e-9 for n in names)


@needs_node
def test_a_page_runs_it(tmp_path: Path) -> None:
    model = compiled("Echo")
    slots = [model.program.slots[name] for name in ("T", "x")]
    times = [0.04 * i for i in range(101)]
    module = make_module(model)
    orders: list[tuple[object, object]] = [([], times), ([[slots[0], 2.0]], times),
                                           ([[slots[0], 0.0]], times)]  # fmt: skip
    plain, slow, none = of_node(tmp_path, module.code, slots, *orders)
    assert plain["columns"][1] == pytest.approx([by_steps(t) for t in times], abs=1e-8)
    assert slow["columns"][1][50] == pytest.approx(-1.0, abs=1e-8)
    assert none["failed"] and "not above zero" in module.late[int(none["failed"]) - 1]


def test_models_without_delays_know_no_past() -> None:
    from planarc.export.fmi import three
    from planarc.export.image import take_image

    model = compile_model(Request(Path("examples/pendulum.pmo")))
    texts = write_whole(model.program, take_image(model), three.functions(), "", 1e-9).texts
    calls = ("px_past", "px_take", "px_record", "px_mark", "px_cross", "px_come_back", "px_link")
    assert not any(name in text for name in calls for text in texts)


def test_room_is_fixed_and_follows_from_the_model() -> None:
    few, many = (sum(sizes(1, pieces, pieces, 0, 2).values()) for pieces in (100, 200))
    assert many - few == 100 * (2 + 2 + 6)
