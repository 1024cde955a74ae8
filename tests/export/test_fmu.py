"""FMUs, as another tool runs them: FMPy validates each, and its runs agree with planarc's."""

from __future__ import annotations

import platform
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.export.fmu import make_fmu
from planarc.export.wishes import Wishes
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES, HERE, WAYS, runs_here, simulate, written

MODELS = ("pendulum", "double_pendulum", "four_bar", "crank_slider", "walking_leg")


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(EXAMPLES / f"{name}.pmo"))


def archive(folder: Path, name: str, version: int = 3) -> Path:
    return written(folder / f"{name}{version}.fmu", compiled(name), version)


def misfit(name: str, table: np.ndarray, stop: float, **options: object) -> float:
    """The largest difference to a run of planarc, as a part of the variable's range."""
    program = compiled(name).program
    chosen = {"intervals": 100, "tolerance": 1e-11, **options}
    result = run(compiled(name), RunOptions(stop=stop, **chosen))
    assert result.ended is None
    rows = np.abs(result.time[:, None] - table["time"]).argmin(0)
    assert np.abs(result.time[rows] - table["time"]).max() < 1e-9
    columns = {c.name: c for c in program.columns}
    worst = 0.0
    for output in table.dtype.names[1:]:
        c = columns[output]
        values = c.sign * result.data[rows, result.stored[c.slot]]
        size = max(np.ptp(values), 1e-9)
        worst = max(worst, float(np.abs(values - table[output]).max() / size))
    return worst


@pytest.mark.parametrize("version", (2, 3))
@pytest.mark.parametrize("name", MODELS)
def test_fmpy_has_nothing_to_say(folder: Path, name: str, version: int) -> None:
    assert validate_fmu(str(archive(folder, name, version))) == []


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", MODELS)
def test_a_run_is_the_one_of_planarc(folder: Path, name: str, way: str) -> None:
    stop = min(3.0, compiled(name).program.experiment.stop)
    assert misfit(name, simulate(archive(folder, name), way, stop), stop) < 1e-6


@runs_here
@pytest.mark.parametrize("interval", (0.01, 0.5))
def test_loops_are_closed_however_far_steps_could_reach(folder: Path, interval: float) -> None:
    """A drive of constant speed has no errors that would bound a step, and a long one would close
    the loops of the leg in another way, or not at all."""
    table = simulate(archive(folder, "walking_leg"), "CoSimulation", 3.0, output_interval=interval)
    assert misfit("walking_leg", table, 3.0, intervals=round(3.0 / interval)) < 1e-6


@pytest.mark.skipif(platform.machine() != "x86_64" or not HERE, reason="not of FMI 2")
@pytest.mark.parametrize("way", WAYS)
def test_both_versions_run_alike(folder: Path, way: str) -> None:
    """The same code steps in both: equal to the last digit."""
    two, three = (simulate(archive(folder, "crank_slider", v), way, 2.0) for v in (2, 3))
    assert two.dtype.names == three.dtype.names
    assert all((two[name] == three[name]).all() for name in two.dtype.names)


@runs_here
@pytest.mark.parametrize(
    "set",
    [
        {"crank.r[1]": 0.3},
        {"rocker.r[1]": 1.2, "crankBody.m": 3.0},
        {"revA.phi": 2.5},
        {"revA.phi": -1.5, "coupler.r[1]": 1.0},
    ],
)
def test_other_parameters_and_starts_follow_the_assembly(folder: Path, set: dict) -> None:
    table = simulate(archive(folder, "four_bar"), "CoSimulation", 1.0, start_values=set)
    starts = {k: v for k, v in set.items() if k.startswith("rev")}
    values = {k: v for k, v in set.items() if k not in starts}
    assert misfit("four_bar", table, 1.0, values=values, starts=starts) < 2e-6


@runs_here
@pytest.mark.parametrize("intervals", [100, 2])
@pytest.mark.parametrize("way", WAYS)
def test_states_are_exchanged_where_a_crank_swings(folder: Path, way: str, intervals: int) -> None:
    """With a coupler of 1.5 m no angle can be the state for long, however few steps a host tells
    of."""
    set = {"coupler.r[1]": 1.5}
    path = archive(folder, "four_bar")
    table = simulate(path, way, 1.3, start_values=set, output_interval=1.3 / intervals)
    program = compiled("four_bar").program
    result = run(compiled("four_bar"), RunOptions(stop=1.3, tolerance=1e-9, values=set))
    assert len(result.states) > 3
    c = next(c for c in program.columns if c.name == "revA.phi")
    end = c.sign * result.data[-1, result.stored[c.slot]]
    assert abs(table["revA.phi"][-1] - end) < 1e-5


@runs_here
@pytest.mark.parametrize("version", (2, 3))
def test_a_loop_that_does_not_close_is_told(folder: Path, version: int) -> None:
    told: list[str] = []

    def log(*given: object) -> None:
        told.append(given[-1].decode())

    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(archive(folder, "four_bar", version), "CoSimulation", 1.0,
                 start_values={"crank.r[1]": 30.0}, logger=log)  # fmt: skip
    assert "a loop does not close" in told[0]


class Instance:
    """An instance for co-simulation, initialized."""

    def __init__(self, path: Path, unpacked: str) -> None:
        description = fmpy.read_model_description(path)
        self.fmu = FMU3Slave(
            guid=description.guid,
            unzipDirectory=unpacked,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.names = {v.name: v.valueReference for v in description.modelVariables}
        self._outputs = [o.variable.valueReference for o in description.outputs]
        self.fmu.instantiate()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.t = 0.0

    def go(self, steps: int) -> tuple[float, ...]:
        """The outputs after so many steps."""
        for _ in range(steps):
            self.fmu.doStep(currentCommunicationPoint=self.t, communicationStepSize=0.01)
            self.t += 0.01
        return tuple(self.fmu.getFloat64(self._outputs))


@runs_here
def test_states_between_steps_are_as_exact_as_at_their_ends(folder: Path) -> None:
    """Of an oscillator, whose closed form is known, at 5,000 points and at 7."""
    source, path = folder / "swings.pmo", folder / "swings.fmu"
    source.write_text("""
model Swings
  output Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -9*x;
end Swings;
""")
    path.write_bytes(make_fmu(compile_model(Request(source)), Wishes()).data)
    for points in (5_000, 7):
        table = fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=4.0,
                                  output_interval=4 / points)  # fmt: skip
        assert len(table) > points
        assert table["x"] == pytest.approx(np.cos(3 * table["time"]), abs=2e-8)


@runs_here
def test_inputs_act_at_once(folder: Path) -> None:
    """Held over each step of the host: a mass on a spring under a force that is 1, then -2."""
    text = """
model Driven
  input Real f(start=1);
  output Real y;
  parameter Real m=2;
  Real x(start=0, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  m*der(v) = f - 8*x;
  y = x + f;
end Driven;
"""
    source, path = folder / "driven.pmo", folder / "driven.fmu"
    source.write_text(text)
    path.write_bytes(make_fmu(compile_model(Request(source)), Wishes()).data)
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(path)
    names = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    assert fmu.getFloat64([names["y"]]) == [1.0]
    fmu.exitInitializationMode()
    fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.7)
    x, v = (1 - np.cos(1.4)) / 8, np.sin(1.4) / 4
    fmu.setFloat64([names["f"]], [-2.0])
    assert fmu.getFloat64([names["y"]])[0] == pytest.approx(x - 2, abs=1e-7)
    fmu.doStep(currentCommunicationPoint=0.7, communicationStepSize=0.5)
    x = -0.25 + (x + 0.25) * np.cos(1.0) + v / 2 * np.sin(1.0)
    assert fmu.getFloat64([names["y"]])[0] == pytest.approx(x - 2, abs=1e-7)


@runs_here
@pytest.mark.parametrize("name", ["four_bar", "dominoes"])
def test_a_state_that_was_saved_leads_to_the_same_end(folder: Path, name: str) -> None:
    """Also in another instance, of which large models have addresses in their memory."""
    path = archive(folder, name)
    unpacked = fmpy.extract(path)
    one = Instance(path, unpacked)
    one.go(20)
    state, t = one.fmu.getFMUState(), one.t
    end = one.go(60)
    kept = one.fmu.serializeFMUState(state)
    one.fmu.setFMUState(state)
    one.t = t
    assert one.go(60) == end
    other = Instance(path, unpacked)
    other.fmu.setFMUState(other.fmu.deserializeFMUState(kept))
    other.t = t
    assert other.go(60) == end
    one.fmu.freeFMUState(state)


@runs_here
def test_instances_in_threads_do_not_meet(folder: Path) -> None:
    path = archive(folder, "four_bar")
    unpacked = fmpy.extract(path)
    instances = [Instance(path, unpacked) for _ in range(50)]
    alone = Instance(path, unpacked).go(50)
    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(lambda i: i.go(50), instances)) == {alone}


def test_the_same_model_gives_the_same_bytes() -> None:
    one, two = (make_fmu(compiled("pendulum"), Wishes()).data for _ in range(2))
    assert one == two


@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("pendulum", 116_500),
        ("four_bar", 160_500),
        ("ratchet_and_pawl", 229_500),
        ("cam_lift_off", 245_000),
        ("dominoes", 234_000),
        ("gripper", 235_000),
        ("escapement", 235_000),
        ("chain_over_peg", 248_000),
        ("PlanarMultiBody.Examples.Contacts.RattlingGears", 250_000),
    ],
)
def test_five_platforms_take_little_room(name: str, most: int) -> None:
    """Of 23 contacts more than of a loop: each platform has code of its own."""
    model = compile_model(Request(class_name=name)) if "." in name else compiled(name)
    assert len(make_fmu(model, Wishes()).data) < most


BIG = """
model Big
  output Integer n(start = 2000000000, fixed = true);
equation
  when sample(0, 0.25) then
    n = pre(n) + 100000000;
  end when;
end Big;
"""


@runs_here
def test_an_integer_of_more_than_32_bits_is_no_other_number(tmp_path: Path) -> None:
    path = written(tmp_path / "big.fmu", compile_model(Request(text=BIG)), 3)
    assert simulate(path, "CoSimulation", 0.2)["n"][-1] == 2_100_000_000
    with pytest.raises(FMICallException):
        simulate(path, "CoSimulation", 1.0)
