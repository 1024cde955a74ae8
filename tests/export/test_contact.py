"""Exported models with rigid contacts: impacts, stops and friction are those of planarc's runs."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.export.endings import ends_of
from planarc.export.page.module import make_module
from planarc.export.refusal import refuse
from planarc.ir.result import Result
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES, WAYS, runs_here, simulate, written
from tests.export.test_wasm import needs_node, of_node

LIBRARY = "PlanarMultiBody.Examples."

#: The time that is compared: bounces that come to rest, what lets go, what sticks and slides, a
#: door between two stops, corners that rock, joints that rub.
MODELS = {
    "Contacts.BouncingBall": 4.0,
    "Contacts.RattlingGears": 1.0,
    "Contacts.RockerInBowl": 3.0,
    "Contacts.RockingBlock": 2.5,
    "Contacts.SwingDoor": 10.0,
    "Contacts.WornSliderCrank": 0.1,
    "Loops.RubbingCrankSlider": 7.0,
    "cam_lift_off": 4.0,
    "geneva_drive": 5.0,
    "ratchet_and_pawl": 3.0,
}
#: More touches than cases are tried for.
MANY = {"gripper": 1.2, "dominoes": 0.3}
#: Of which events are known so well that two tolerances of `planarc simulate` agree on them.
SHARP = {"Contacts.OffTheLedge": 1.0, "Contacts.SwingDoor": 3.0, "ratchet_and_pawl": 3.0}
FLOOR = """
model Drop "A ball that falls on a floor"
  extends PlanarMultiBody.Examples.Contacts.BouncingBall;
  output Real height = ball.frame_a.r[2] - 0.1;
  output Real speed = ball.v[2];
end Drop;
"""


@cache
def compiled(name: str) -> Compiled:
    if name == "Drop":
        return compile_model(Request(Path("Drop.pmo"), text=FLOOR))
    path = EXAMPLES / f"{name}.pmo"
    return compile_model(Request(path) if path.exists() else Request(class_name=LIBRARY + name))


@cache
def reference(name: str, stop: float) -> Result:
    return run(compiled(name), RunOptions(stop=stop, intervals=100, tolerance=1e-11))


def archive(folder: Path, name: str, version: int = 3) -> Path:
    return written(folder / f"{name}{version}.fmu", compiled(name), version)


def misfit(name: str, stop: float, table: np.ndarray) -> float:
    """The largest difference between events, beside a variable's range, which is nothing but
    rounding where it stands still: some 1e-15."""
    result, program = reference(name, stop), compiled(name).program
    events = np.array([-1.0, *(e.time for e in result.events)])
    columns = {c.name: c for c in program.columns}
    rows = np.abs(result.time[:, None] - table["time"]).argmin(0)
    same = np.abs(events[:, None] - table["time"]).min(0) > 1e-6
    same &= np.abs(result.time[rows] - table["time"]) < 1e-9
    assert same.sum() > 80
    worst = 0.0
    for output in table.dtype.names[1:]:
        c = columns[output]
        values = c.sign * result.data[:, result.stored[c.slot]]
        missed = np.abs(values[rows[same]] - table[output][same].astype(float)).max()
        worst = max(worst, float(missed) / max(float(np.ptp(values)), 1e-8))
    return worst


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", (*MODELS, *MANY))
def test_a_run_is_the_one_of_planarc(folder: Path, name: str, way: str) -> None:
    stop = {**MODELS, **MANY}[name]
    table = simulate(archive(folder, name), way, stop)
    assert table["time"][-1] == pytest.approx(stop)
    assert misfit(name, stop, table) < 1e-6


@runs_here
@pytest.mark.parametrize("name", SHARP)
def test_events_of_model_exchange_fall_where_planarcs_do(folder: Path, name: str) -> None:
    stop = SHARP[name]
    table = simulate(archive(folder, name), "ModelExchange", stop, record_events=True)
    events = [e.time for e in reference(name, stop).events if 0 < e.time < stop]
    assert events
    assert max(np.abs(table["time"] - t).min() for t in events) < 1e-9


@pytest.mark.parametrize("version", (2, 3))
def test_fmpy_has_nothing_to_say(folder: Path, version: int) -> None:
    assert validate_fmu(str(archive(folder, "geneva_drive", version))) == []


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_another_restitution_bounces_by_the_law(folder: Path, way: str) -> None:
    """The ball bounces as high as e^2 times the height that it fell from."""
    e = 0.6
    table = simulate(archive(folder, "Drop"), way, 1.5, start_values={"contact.e": e})
    energy = table["height"] + table["speed"] ** 2 / (2 * 9.81)
    strikes = np.flatnonzero(np.diff(energy) < -1e-3)
    assert len(strikes) > 2
    assert energy[0] == pytest.approx(1.0)
    for n, k in enumerate(strikes[:3], 1):
        assert energy[k + 1] == pytest.approx(e ** (2 * n), rel=1e-6)


@runs_here
def test_a_saved_state_holds_what_touches_remember(folder: Path) -> None:
    """Greatest speeds and paces decide which bounce is the last: the same end to the last digit."""
    path = archive(folder, "Contacts.BouncingBall")
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
        return tuple(fmu.getFloat64([names[n] for n in ("ball.v[1]", "ball.v[2]", "ball.w")]))

    go(0, 20)
    state = fmu.getFMUState()
    end = go(20, 50)
    fmu.setFMUState(state)
    assert go(20, 50) == end
    fmu.freeFMUState(state)


@needs_node
@pytest.mark.parametrize("name", ("Contacts.BouncingBall", "cam_lift_off"))
def test_pages_strike_as_planarc_does(name: str, tmp_path: Path) -> None:
    model, stop = compiled(name), 4.0
    result = reference(name, stop)
    events = np.array([e.time for e in result.events])
    rows = [i for i, t in enumerate(result.time) if np.abs(events - t).min() > 1e-6]
    columns = [c for c in model.program.columns
               if not c.constant and c.name.endswith((".v[1]", ".v[2]", ".phi", ".s"))]  # fmt: skip
    times = [float(result.time[i]) for i in rows]
    (told,) = of_node(
        tmp_path, make_module(model).code, [c.slot for c in columns], ([], [0.0, *times])
    )
    for c, found in zip(columns, np.array(told["columns"]), strict=True):
        values = result.data[rows, result.stored[c.slot]]
        assert np.abs(found[1:] - values).max() <= 1e-6 * max(float(np.ptp(values)), 1e-3), c.name


@pytest.mark.parametrize("name", ("Contacts.NewtonsCradle", "chain_over_peg", "escapement"))
def test_nothing_stands_in_the_way_of_others(name: str) -> None:
    refuse(compiled(name).program)


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_bodies_that_overlap_are_told(folder: Path, way: str) -> None:
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(archive(folder, "Drop"), way, 1.0, start_values={"ball.frame_a.r[2]": 0.01},
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert told and "overlap by 0.09 m" in told[0] and "at t = 0 s" in told[0]


@needs_node
def test_pages_tell_bodies_that_overlap_at_the_start(tmp_path: Path) -> None:
    model = compiled("Drop")
    height = next(c for c in model.program.columns if c.name == "ball.frame_a.r[2]")
    low, high = of_node(
        tmp_path, make_module(model).code, [height.slot],
        ([(height.slot, 0.01)], [0.0, 0.1]), ([(height.slot, 0.5)], [0.0, 0.1]),
    )  # fmt: skip
    assert high["begun"] and high["failed"] == 0
    assert not low["begun"]
    number = low["failed"]
    assert isinstance(number, int)
    assert list(ends_of(model.program))[number - 1].code == "R480"


@runs_here
def test_low_bounces_are_no_rounding_of_the_ones_before(folder: Path) -> None:
    """What leaves a touch stands at zero, and a step that finds its return must not stop there."""
    name = "Contacts.WornSliderCrank"
    table = fmpy.simulate_fmu(
        archive(folder, name), fmi_type="CoSimulation", stop_time=1.0, output_interval=0.01,
        relative_tolerance=1e-12, record_events=False,
    )  # fmt: skip
    result = run(compiled(name), RunOptions(stop=1.0, intervals=100, tolerance=1e-12))
    assert len(result.events) > 80
    assert table["pin.w"] == pytest.approx(at_rows(result, "pin.w", table["time"]), abs=1.6e-5)
    assert table["pin.phi"] == pytest.approx(at_rows(result, "pin.phi", table["time"]), abs=2e-6)


@runs_here
@pytest.mark.parametrize("early", (False, True))
@pytest.mark.parametrize("tolerance", (1e-9, 1e-10, 1e-11, 1e-12))
def test_an_event_that_is_seen_coming_happens_now(
    folder: Path, tolerance: float, early: bool
) -> None:
    """Where a step stops just before a crossing, its way is looked at, not gone."""
    table = fmpy.simulate_fmu(
        archive(folder, "cam_lift_off"), fmi_type="CoSimulation", stop_time=4.0,
        output_interval=0.04, relative_tolerance=tolerance, record_events=early,
        early_return_allowed=early,
    )  # fmt: skip
    leaves = [e.time for e in reference("cam_lift_off", 4.0).events if "lets go" in str(e.causes)]
    assert leaves
    if early:
        assert max(np.abs(table["time"] - t).min() for t in leaves) < 2e-8
    even = np.abs(table["time"][:, None] - np.linspace(0, 4, 101)).min(1) < 1e-9
    assert misfit("cam_lift_off", 4.0, table[even]) < 1e-7


@runs_here
def test_a_blow_runs_through_balls_that_stay_where_they_are(folder: Path) -> None:
    """The inner ones move by rounding alone, and the outer ones as in planarc."""
    name = "Contacts.NewtonsCradle"
    table = fmpy.simulate_fmu(
        archive(folder, name), fmi_type="CoSimulation", stop_time=10.0, output_interval=0.1,
        relative_tolerance=1e-12, record_events=True, early_return_allowed=True,
    )  # fmt: skip
    result = run(compiled(name), RunOptions(stop=10.0, intervals=100, tolerance=1e-12))
    events = [e.time for e in result.events]
    assert len(events) == 10
    assert max(np.abs(table["time"] - t).min() for t in events) < 2e-9
    even = np.abs(table["time"][:, None] - np.linspace(0, 10, 101)).min(1) < 1e-9
    for ball in (1, 5):
        for what in ("phi", "w"):
            wanted = at_rows(result, f"hinge[{ball}].{what}", table["time"][even])
            assert table[f"hinge[{ball}].{what}"][even] == pytest.approx(wanted, abs=1e-7)
    for ball in (2, 3, 4):
        assert np.abs(table[f"hinge[{ball}].w"]).max() < 1e-10


def at_rows(result: Result, name: str, times: np.ndarray) -> np.ndarray:
    return result[name][np.abs(result.time[:, None] - times).argmin(0)]
