"""Runs of an exported model in this process: rows, events and words are those of any other run."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import PlanarcError
from planarc.compiler import compile_model, run
from planarc.core.diagnostic import UsageError
from planarc.core.options import RunOptions, Solver
from planarc.export.rehearsal import library
from planarc.export.rehearsal.library import Library
from planarc.ir.result import Interrupted
from planarc.request.request import Request
from tests.export.test_events import BALL, TABLE
from tests.stdlib.small import FREE
from tests.stdlib.small import run as simulated
from tests.stdlib.test_geneva import drive

EXAMPLES = Path(__file__).parents[3] / "examples"
LIBRARY = "PlanarMultiBody.Examples."

WARNS = """
model Warns
  Real x(start = 0, fixed = true);
equation
  der(x) = 1;
  assert(x < 0.5, "x is " + String(x, format = ".3f"), level = AssertionLevel.warning);
end Warns;
"""
ENDS = """
model Ends
  Real x(start = 0, fixed = true);
equation
  der(x) = 1;
  assert(x < 0.5, "x is " + String(x, format = ".3f"));
end Ends;
"""
SNAP = """
model Snap
  Real x(start = -2);
equation
  x^3 - 3*x = 4*time - 2;
end Snap;
"""
DELAYED = """
model Delayed
  Real x(start = 1, fixed = true), y = delay(x, 0.3);
equation
  der(x) = -2*y;
  annotation(experiment(StopTime = 2));
end Delayed;
"""
SAMPLED = """
model Sampled
  Real x(start = 1, fixed = true);
  discrete Real u(start = 0, fixed = true);
equation
  der(x) = u - x;
  when sample(0.1, 0.25) then
    u = pre(u) + 0.5 - x;
  end when;
  annotation(experiment(StopTime = 2));
end Sampled;
"""
OVER = """
model Over
  Real x(start = 0, fixed = true);
equation
  der(x) = 1;
  when x > 0.7 then
    terminate("over");
  end when;
end Over;
"""
ROOT = """
model Root
  Real x(start = 1, fixed = true);
equation
  der(x) = -2*sqrt(x);
  annotation(experiment(StopTime = 2));
end Root;
"""
BROKEN = """
model Broken
  parameter Real p = 4;
  Real x(start = 1, fixed = true);
equation
  der(x) = -p*x;
  assert(p < 3, "p should be below 3", AssertionLevel.warning);
end Broken;
"""
STOPPED = """
model Stopped
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute rev(phi(start = 0.5, fixed = true), w(fixed = true));
  PlanarMultiBody.Parts.BodyShape rod(r = {0.4, 0}, m = 1, I = 0.02, r_CM = {0.2, 0});
  PlanarMultiBody.Contacts.RevoluteStops stops(phi_min = -3, phi_max = 1);
equation
  connect(world.frame_b, rev.frame_a);
  connect(rev.frame_b, rod.frame_a);
  connect(world.frame_b, stops.frame_a);
  connect(stops.frame_b, rev.frame_b);
end Stopped;
"""


@cache
def model(source: str) -> planarc.Model:
    if source.startswith("\n"):
        return planarc.load(source)
    return planarc.load(source if "." in source else EXAMPLES / f"{source}.pmo")


def both(source: str, **options: Any) -> tuple[planarc.Result, planarc.Result]:
    """The usual run, and that of the exported model."""
    given = {"tolerance": 1e-11, **options}
    usual = model(source).simulate(**given)
    return usual, model(source).simulate(**{"solver": "exported", **given})


def rows_of(source: str, solver: Solver, options: Any) -> Any:
    """The rows of a run, however it ends."""
    return run(compile_model(Request(text=source)), RunOptions(solver=solver, **options))


def last_rows(result: planarc.Result, name: str, times: np.ndarray) -> np.ndarray:
    return result[name][np.searchsorted(result["time"], times + 1e-12, "right") - 1]


@pytest.mark.parametrize(
    ("source", "stop"),
    [
        ("four_bar", 2.0),
        ("pendulum", 10.0),
        ("walking_leg", 2.0),
        ("cam_lift_off", 3.043),  # what bounces later hangs on the tolerance
        ("ratchet_and_pawl", 3.0),
        (LIBRARY + "Loops.CrankSlider", 0.5),
        (LIBRARY + "Contacts.NewtonsCradle", 2.0),
        (LIBRARY + "Elementary.BouncingMass", 2.0),
        (BALL, 2.0),
        (TABLE, 2.9),
        (DELAYED, 2.0),
        (SAMPLED, 2.0),
    ],
    ids=lambda given: given.split()[1] if str(given).startswith("\n") else str(given),
)
def test_rows_and_events_are_those_of_any_other_run(source: str, stop: float) -> None:
    usual, here = both(source, stop_time=stop)
    events = np.array([e.time for e in usual.events])
    np.testing.assert_allclose([e.time for e in here.events], events, atol=1e-7)
    assert [e.causes for e in here.events] == [e.causes for e in usual.events]
    grid = np.linspace(usual["time"][0], usual["time"][-1], 101)
    if len(events):
        grid = grid[np.abs(grid[:, None] - events).min(axis=1) > 1e-5]
    for column in usual.rows.program.columns:
        if column.slot in usual.rows.stored:
            a, b = (last_rows(r, column.name, grid) for r in (usual, here))
            size = max(1.0, np.abs(usual[column.name]).max())
            np.testing.assert_allclose(b, a, atol=1e-6 * size, err_msg=column.name)


def test_implicit_steps_lead_to_the_same() -> None:
    usual, here = both("four_bar", solver="exported-stiff", stop_time=1.0)
    np.testing.assert_allclose(here["revA.phi"], usual["revA.phi"], atol=1e-7)
    assert here.statistics.solver == "exported-stiff"
    assert here.statistics.effort == "not counted, events 0"


def test_another_start_keeps_the_assembly() -> None:
    usual, here = both("four_bar", start={"revA.phi": 1.4}, stop_time=0.5)
    np.testing.assert_allclose(here["revD.phi"], usual["revD.phi"], atol=1e-7)
    assert here.rows.held[0].start == 1.4


def test_other_states_are_told_when_they_are_taken() -> None:
    """With a coupler of 1.5 m no angle can be the state for long."""
    taken = [
        {choice.states for choice in r.rows.states}
        for r in both("four_bar", parameters={"coupler.r[1]": 1.5}, stop_time=1.3)
    ]
    assert taken[0] == taken[1] and len(taken[0]) > 2


def test_assertions_end_a_run_or_warn_in_the_same_words() -> None:
    usual, here = both(WARNS)
    assert [str(w) for w in here.warnings] == [str(w) for w in usual.warnings] != []
    ended = []
    for solver in (Solver.AUTO, Solver.EXPORTED):
        rows = run(compile_model(Request(text=ENDS)), RunOptions(solver=solver))
        assert rows.ended is not None and 0 < len(rows.time) < 501
        ended.append((rows.ended.code, rows.ended.span, rows.ended.hint))
        assert rows.ended.message.endswith("x is 0.500")
    assert ended[0] == ended[1]


def test_what_cannot_go_on_here_says_so_and_keeps_its_rows() -> None:
    with pytest.raises(planarc.RunStopped) as stopped:
        model(SNAP).simulate(solver="exported", stop_time=2)
    assert stopped.value.diagnostics[0].code == "R484"
    assert stopped.value.result["time"][-1] == pytest.approx(1, abs=0.01)


def test_a_start_that_nothing_finds_is_told_as_ever() -> None:
    told = []
    for solver in ("auto", "exported"):
        with pytest.raises(PlanarcError) as raised:
            model("four_bar").simulate(solver=solver, parameters={"groundD.r[1]": 50.0})
        told.append(raised.value.diagnostics[0])
    assert (told[0].code, told[0].message) == (told[1].code, told[1].message)


def test_ctrl_c_keeps_the_rows_so_far() -> None:
    def stop(t: float) -> None:
        if t >= 0.5:
            raise KeyboardInterrupt

    options = RunOptions(solver=Solver.EXPORTED)
    rows = run(compile_model(Request(EXAMPLES / "pendulum.pmo")), options, progress=stop)
    assert rows.ended is not None and rows.ended.code == "R440"
    assert rows.time[-1] == pytest.approx(0.5, abs=0.01)


class _Interrupted(dict[int, Any]):
    """Listeners; Ctrl-C comes where machine code has just called Python so many times."""

    def __init__(self, calls: int) -> None:
        self.left = calls

    def get(self, place: int, default: Any = None) -> Any:
        self.left -= 1
        if self.left == 0:
            os.kill(os.getpid(), signal.SIGINT)
        return super().get(place, default)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_on_the_way_from_machine_code_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = compile_model(Request(text=SAMPLED))
    options = RunOptions(solver=Solver.EXPORTED)
    monkeypatch.setattr(library, "_LISTENERS", _Interrupted(2))  # before there is a start
    with pytest.raises(KeyboardInterrupt):
        run(compiled, options)
    monkeypatch.setattr(library, "_LISTENERS", _Interrupted(6))
    rows = run(compiled, options)
    assert isinstance(rows.ended, Interrupted) and rows.ended.code == "R440"
    assert 0.1 <= rows.time[-1] < 0.4


def test_runs_at_once_do_not_hear_each_other() -> None:
    mine = model(LIBRARY + "Contacts.NewtonsCradle")
    mine.simulate(solver="exported", stop_time=0.1)

    def events(tolerance: float) -> list[float]:
        return [e.time for e in mine.simulate(solver="exported", tolerance=tolerance).events]

    alone = [events(10.0**-k) for k in (5, 6, 7, 8)]
    with ThreadPoolExecutor(4) as pool:
        assert [*pool.map(events, (1e-5, 1e-6, 1e-7, 1e-8))] == alone
    assert all(alone)


def test_what_it_does_not_take_is_refused() -> None:
    with pytest.raises(UsageError, match="machine code alone"):
        model("pendulum").simulate(solver="exported", backend="numpy")
    text = "model In\n  input Real u;\n  Real x(start = 0, fixed = true);\nequation\n" \
        "  der(x) = u;\nend In;\n"  # fmt: skip
    with pytest.raises(UsageError, match="takes no input signals"):
        planarc.load(text).simulate(solver="exported", inputs={"u": lambda t: t})


def test_low_bounces_come_to_an_end() -> None:
    """What rises by less than rounding within a short time may still be a bounce."""
    motor = "ConstantSpeed motor(w_fixed=-7, phi(start=-8.17, fixed=true))"
    body = drive("n=8, backlash=1e-3, e=0.5", motor, at=0.12,
                 start="(phi(fixed=true), w(fixed=true))")  # fmt: skip
    counts = [
        len(simulated(body, 2, "native", FREE, solver=s).events) for s in ("auto", "exported")
    ]
    assert counts[0] <= counts[1] < counts[0] + 20


def test_no_row_stands_behind_the_end() -> None:
    for source, options in ((OVER, {"interval": 0.17}), (ROOT, {"interval": 0.07})):
        usual, here = (rows_of(source, s, options) for s in (Solver.AUTO, Solver.EXPORTED))
        assert len(here.time) == len(usual.time)
        np.testing.assert_allclose(here.time, usual.time, atol=1e-6)


def test_what_parameters_break_is_told_once() -> None:
    usual, here = both(BROKEN)
    assert [str(w) for w in here.warnings] == [str(w) for w in usual.warnings] != []


def test_a_start_behind_a_stop_is_told_as_ever() -> None:
    told = []
    for solver in ("auto", "exported"):
        with pytest.raises(planarc.RunStopped) as raised:
            model(STOPPED).simulate(solver=solver, start={"rev.phi": 1.2})
        told.append(str(raised.value))
    assert told[0] == told[1] and "R480" in told[0]


def test_a_start_value_that_it_does_not_take_is_named() -> None:
    counted = SAMPLED.replace("discrete Real u", "Integer u").replace("0.5 - x", "1")
    with pytest.raises(UsageError, match="`u` cannot be set"):
        model(counted).simulate(solver="exported", start={"u": 4})


def test_a_point_and_single_steps_are_no_runs_of_it() -> None:
    usual, here = both(STOPPED, start_from="equilibrium", stop_time=0.1)
    np.testing.assert_allclose(here["rev.phi"], usual["rev.phi"], atol=1e-9)
    with pytest.raises(UsageError, match="takes no single steps"):
        model("pendulum").stepper(0.1, solver="exported")


def test_crowds_have_no_implicit_steps_nor_others() -> None:
    full = model(LIBRARY + "Contacts.FullBox")
    with pytest.raises(UsageError, match="none is implicit"):
        full.simulate(solver="exported-stiff", stop_time=0.01)
    with pytest.raises(UsageError, match="as exported models do"):
        full.simulate(solver="exported", fixed_step=1e-3, stop_time=0.01)


def test_ctrl_c_at_an_event_is_not_lost() -> None:
    library = Library(model(LIBRARY + "Contacts.NewtonsCradle").compiled(), False)

    def struck(time: float, behind: bool, crossing: list[int], fired: list[int]) -> None:
        if crossing:
            raise KeyboardInterrupt

    with library.instance() as instance:
        instance.listen(struck)
        assert instance.begin(0.0, 1e-8) == 0
        with pytest.raises(KeyboardInterrupt):
            instance.go(1.0)


def test_steps_of_a_crowd_are_those_of_the_run_and_not_of_the_export() -> None:
    full = model(LIBRARY + "Contacts.FullBox")
    usual, here = (full.simulate(solver=s, stop_time=0.7) for s in ("auto", "exported"))
    np.testing.assert_array_equal(here.rows.data, usual.rows.data)
