"""Events: their times, what they do, and what they must not do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc.core.diagnostic import Severity
from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.dae import Assertion, Message, Reinit, SetDiscrete, Terminate
from planarc.solve.simulate import simulate

SOLVERS = [Solver.CVODE_BDF, Solver.CVODE_ADAMS, Solver.LSODA, Solver.SCIPY_BDF]
G, LOSS = 9.81, 0.7


def run(tools: Any, mechanism: Any, **options: Any) -> Any:
    program = mechanism.program()
    options.setdefault("tolerance", 1e-9)
    return simulate(
        program, tools.Interpreter(program), RunOptions(backend=Backend.NUMPY, **options)
    )


def falling(tools: Any, **changes: Any) -> Any:
    """A mass that falls from h = 1."""
    return tools.Mechanism(
        [tools.Coordinate("h", 1.0, written=True)],
        mass=lambda t, q: [[t.one]],
        force=lambda t, q, v: [t.const(-G)],
        **changes,
    )


def ball(tools: Any, stop: float, loss: float = LOSS) -> Any:
    return falling(
        tools,
        relations=lambda t: [(t.symbol("h"), False, False, "h <= 0")],
        discretes=lambda t: [("hit", t.event(0), 0.0), ("n", None, 0.0)],
        whens=lambda t: [
            (
                "hit",
                [
                    Reinit(t.symbol("h", 1), t.mul(t.const(-loss), t.pre("der(h)"))),
                    SetDiscrete("n", t.add(t.pre("n"), t.one)),
                ],
            )
        ],
        stop=stop,
    )


def impacts(count: int) -> list[float]:
    first = np.sqrt(2 / G)
    times = [first]
    for n in range(1, count):
        times.append(times[-1] + 2 * LOSS**n * first)
    return times


@pytest.mark.parametrize("solver", SOLVERS)
def test_impacts_happen_when_they_must(tools: Any, solver: Solver) -> None:
    result = run(tools, ball(tools, 2.48), solver=solver)
    assert result.ended is None
    assert [e.causes for e in result.events] == [("h <= 0",)] * 10
    assert np.allclose([e.time for e in result.events], impacts(10), atol=5e-7, rtol=0)
    assert result["n"][-1] == 10
    assert result["h"].min() > -1e-10


def test_each_event_has_a_row_before_and_a_row_after(tools: Any) -> None:
    result = run(tools, ball(tools, 1.0), intervals=10)
    assert len(result.time) == 11 + 2
    (row,) = np.flatnonzero(np.diff(result.time) == 0)
    before, after = result["der(h)"][row], result["der(h)"][row + 1]
    assert after == pytest.approx(-LOSS * before)
    assert result["hit"][row : row + 2].tolist() == [0.0, 0.0]  # true only in the instant
    assert result["n"][row : row + 2].tolist() == [0.0, 1.0]


@pytest.mark.parametrize("solver", [Solver.CVODE_BDF, Solver.LSODA])
def test_a_pile_of_events_stops_with_the_reason(tools: Any, solver: Solver) -> None:
    """Impacts follow each other ever faster, up to t = 2.5586."""
    result = run(tools, ball(tools, 4.0), solver=solver, tolerance=1e-6)
    assert result.ended.code == "R432"
    assert result.ended.severity is Severity.ERROR
    assert "`h <= 0`" in result.ended.message
    assert result.time[-1] == pytest.approx(2.5586, abs=1e-2)
    assert len(result.events) < 200


@pytest.mark.parametrize("solver", [Solver.CVODE_BDF, Solver.LSODA])
def test_chattering_is_noticed_and_named(tools: Any, solver: Solver) -> None:
    """A force that always pushes back to zero: no motion, but no end of events."""

    def force(t: Any, q: Any, v: Any) -> Any:
        return [t.if_(t.event(0), t.const(-5.0), t.const(5.0))]

    mechanism = tools.Mechanism(
        [tools.Coordinate("x", 1.0, written=True)],
        mass=lambda t, q: [[t.one]],
        force=force,
        relations=lambda t: [
            (t.neg(t.add(t.symbol("x"), t.symbol("x", 1))), True, False, "x + v > 0")
        ],
        stop=3.0,
    )
    result = run(tools, mechanism, solver=solver, tolerance=1e-6)
    assert result.ended.code == "R432"
    assert "`x + v > 0`" in result.ended.message
    assert "mode" in (result.ended.hint or "")
    # From here on x + v = 0 should hold: it was reached in motion, at about 0.6 s.
    assert abs(result["x"][-1] + result["der(x)"][-1]) < 1e-2


def switched(tools: Any, at: float, strict: bool, **changes: Any) -> Any:
    """A thrust of 3 from the time `at` on."""

    def force(t: Any, q: Any, v: Any) -> Any:
        return [t.if_(t.event(0), t.const(3.0), t.zero)]

    return tools.Mechanism(
        [tools.Coordinate("x")],
        mass=lambda t, q: [[t.one]],
        force=force,
        relations=lambda t: [(t.sub(t.const(at), t.time), strict, True, f"time >= {at}")],
        stop=1.0,
        **changes,
    )


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("strict", [True, False])
def test_instants_of_time_are_met_exactly(tools: Any, solver: Solver, strict: bool) -> None:
    result = run(tools, switched(tools, 0.3, strict), solver=solver, intervals=10)
    assert [e.time for e in result.events] == [0.3]
    # The row asked for at 0.3 is one of the two of the event.
    assert len(result.time) == 12
    assert result["x"][-1] == pytest.approx(1.5 * 0.7**2, abs=1e-8)
    assert result["der(der(x))"][result.time == 0.3].tolist() == [0.0, 3.0]


def test_an_event_at_the_very_end_is_taken(tools: Any) -> None:
    result = run(tools, switched(tools, 1.0, False), intervals=4)
    assert result.time.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 1.0]
    assert result["der(der(x))"][-2:].tolist() == [0.0, 3.0]


def test_a_relation_that_holds_at_the_start_makes_no_event(tools: Any) -> None:
    result = run(tools, switched(tools, 0.0, False), intervals=4)
    assert result.events == ()
    assert result["x"][-1] == pytest.approx(1.5, abs=1e-9)


def test_a_relation_at_zero_takes_the_side_it_moves_to(tools: Any) -> None:
    """v < 0 is false at rest, as the first row shows; a falling mass is below at once, without
    an event."""
    mechanism = falling(
        tools,
        relations=lambda t: [(t.symbol("h", 1), True, False, "v < 0")],
        extra=lambda t: [("down", t.if_(t.event(0), t.one, t.zero))],
    )
    result = run(tools, mechanism, intervals=4)
    assert result.events == ()
    assert result.time[:2].tolist() == [0.0, 0.0]
    assert result["down"].tolist() == [0.0] + [1.0] * 5


def sampled(tools: Any, start: float, interval: float) -> Any:
    return falling(
        tools,
        samplers=[(start, interval)],
        discretes=lambda t: [("tick", t.symbol("$sample[0]"), 0.0), ("held", None, 9.0)],
        whens=lambda t: [("tick", [SetDiscrete("held", t.symbol("h"))])],
    )


@pytest.mark.parametrize("solver", [Solver.CVODE_BDF, Solver.LSODA])
def test_samples_come_at_their_instants_and_hold(tools: Any, solver: Solver) -> None:
    result = run(tools, sampled(tools, 0.1, 0.3), solver=solver, intervals=20)
    # The last instant, 0.1 + 3*0.3, is the stop time but for rounding.
    assert [e.time for e in result.events] == [0.1, 0.1 + 0.3, 0.1 + 2 * 0.3, 1.0]
    fall = [1 - G / 2 * e.time**2 for e in result.events]
    rows = [int(np.flatnonzero(result.time == e.time)[1]) for e in result.events]
    assert np.allclose(result["held"][rows], fall, atol=1e-8)
    assert result["held"][rows[0] - 1] == 9.0
    assert set(result["held"].tolist()) == {9.0, *result["held"][rows].tolist()}


def test_a_sample_at_the_start_is_no_event_of_its_own_rows(tools: Any) -> None:
    result = run(tools, sampled(tools, 0.0, 0.5), intervals=4)
    assert result["held"][0] == 1.0
    assert np.flatnonzero(np.diff(result.time) == 0).size == 2  # at 0.5 and 1.0


def test_terminate_ends_the_run_with_a_note(tools: Any) -> None:
    mechanism = falling(
        tools,
        relations=lambda t: [(t.symbol("h"), False, False, "h <= 0")],
        discretes=lambda t: [("hit", t.event(0), 0.0)],
        whens=lambda t: [
            ("hit", [Terminate(Message(("ground reached with ", (t.symbol("h", 1), ".3g"))))])
        ],
    )
    result = run(tools, mechanism)
    assert result.ended.severity is Severity.NOTE
    assert result.ended.code == "R431"
    assert "ground reached with -4.43" in result.ended.message
    assert result.time[-1] == pytest.approx(np.sqrt(2 / G), abs=1e-7)
    assert result.time[-1] == result.time[-2]


def test_a_failed_assert_ends_the_run_and_keeps_its_row(tools: Any) -> None:
    def asserts(warning: bool) -> Any:
        return falling(
            tools,
            asserts=lambda t: [
                Assertion(
                    t.less(t.const(0.5), t.symbol("h")),
                    Message(("too low: ", (t.symbol("h"), ""))),
                    warning,
                )
            ],
        )

    result = run(tools, asserts(False))
    assert result.ended.code == "R430"
    assert result.ended.severity is Severity.ERROR
    assert "too low: 0.49" in result.ended.message
    assert result["h"][-1] <= 0.5 < result["h"][-2]
    result = run(tools, asserts(True))
    assert result.ended is None
    assert [w.severity for w in result.warnings] == [Severity.WARNING]
    assert len(result.time) == 501


def test_actions_at_the_start_need_initial(tools: Any) -> None:
    """`when h > 0` does not fire because it holds at the start; `when initial()` does, and so does
    `when {h > 0, initial()}`, but nothing that merely depends on it."""

    def mechanism(name: str, *conditions: tuple[str, Any]) -> Any:
        return falling(
            tools,
            relations=lambda t: [(t.neg(t.symbol("h")), True, False, "h > 0")],
            discretes=lambda t: [
                *((name, value(t), 0.0) for name, value in conditions),
                ("n", None, 5.0),
            ],
            whens=lambda t: [(name, [SetDiscrete("n", t.add(t.pre("n"), t.one))])],
            stop=0.1,
        )

    def initial(t: Any) -> Any:
        return t.symbol("$initial")

    def edge(t: Any) -> Any:
        return t.and_(t.symbol("$when[1]"), t.not_(t.pre("$when[1]")))

    literal = ("$when[1]", initial)
    acting = (
        mechanism("$when[1]", literal),
        mechanism("$edge[2]", literal, ("$edge[2]", edge)),
    )
    for each in acting:
        found = run(tools, each)["n"]
        assert found[0] == found[-1] == 6.0
    silent = (
        mechanism("c", ("c", lambda t: t.event(0))),
        mechanism("c", ("c", initial)),
        mechanism("$when[1]", ("$when[1]", lambda t: t.or_(initial(t), t.event(0)))),
        mechanism("$when[2]", ("c", initial), ("$when[2]", lambda t: t.symbol("c"))),
    )
    for each in silent:
        assert run(tools, each)["n"][-1] == 5.0


def test_events_that_do_not_come_to_rest_are_named(tools: Any) -> None:
    """b := not pre(b): nothing ends this at one instant."""
    mechanism = falling(
        tools,
        relations=lambda t: [(t.symbol("h"), False, False, "h <= 0")],
        discretes=lambda t: [
            ("b", t.and_(t.event(0), t.not_(t.pre("b"))), 0.0),
        ],
    )
    result = run(tools, mechanism)
    assert result.ended.code == "R433"
    assert "`b`" in result.ended.message
    assert "pre" in (result.ended.hint or "")


def test_reinit_makes_its_variable_a_state(tools: Any) -> None:
    """In a crank-slider whose crank is preferred, the slider's speed is set anew."""
    place = 0.3 * np.cos(1.0) + np.sqrt(1 - (0.3 * np.sin(1.0)) ** 2)
    mechanism = tools.crank_slider(
        tools.Coordinate("crank.phi", 1.0, fixed=True, speed=1.0, speed_fixed=True),
        tools.Coordinate("slide.s", float(place)),
    )
    mechanism.relations = lambda t: [(t.sub(t.const(0.2), t.time), False, True, "time >= 0.2")]
    mechanism.discretes = lambda t: [("kick", t.event(0), 0.0)]
    mechanism.whens = lambda t: [("kick", [Reinit(t.symbol("slide.s", 1), t.const(-0.7))])]
    mechanism.stop = 0.4
    result = run(tools, mechanism)
    assert result.ended is None
    assert result.states[0].states == ("slide.s", "der(slide.s)")
    before, after = np.flatnonzero(result.time == 0.2)
    assert result["der(slide.s)"][after] == pytest.approx(-0.7, abs=1e-12)
    assert result["slide.s"][after] == pytest.approx(result["slide.s"][before], abs=1e-12)
    # The crank follows through the constraint.
    ratio = result["der(crank.phi)"] / result["der(slide.s)"]
    assert ratio[after] == pytest.approx(ratio[before], abs=1e-9)


@pytest.mark.parametrize("solver", [Solver.CVODE_BDF, Solver.LSODA])
def test_simultaneous_switches_are_one_event(tools: Any, solver: Solver) -> None:
    def force(t: Any, q: Any, v: Any) -> Any:
        one = t.if_(t.event(0), t.const(1.0), t.zero)
        return [t.add(one, t.if_(t.event(1), t.const(2.0), t.zero))]

    mechanism = tools.Mechanism(
        [tools.Coordinate("x")],
        mass=lambda t, q: [[t.one]],
        force=force,
        relations=lambda t: [
            (t.sub(t.const(0.5), t.time), False, True, "time >= 0.5"),
            (t.sub(t.time, t.const(0.5)), True, True, "time < 0.5"),
        ],
    )
    result = run(tools, mechanism, solver=solver)
    assert len(result.events) == 1
    assert result.events[0].causes == ("time >= 0.5", "time < 0.5")
    # First 2, then 1: the velocity is 1 and then grows half as fast.
    assert result["der(x)"][-1] == pytest.approx(1.5, abs=1e-9)
