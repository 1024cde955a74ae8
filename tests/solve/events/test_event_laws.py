"""Events against closed forms, from the text of a model, in both back ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import Diagnostic

Stopped = Callable[..., tuple[Diagnostic, planarc.Result]]

G = 9.81


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def whole(body: str) -> str:
    return f"model M\n{body}\nend M;"


def run(body: str, backend: str, stop: float, intervals: int = 50) -> planarc.Result:
    model = planarc.load(whole(body), backend=backend)
    return model.simulate(stop, tolerance=1e-9, intervals=intervals)


def pair(result: planarc.Result, event: int) -> tuple[int, int]:
    """The rows before and after an event."""
    before, after = np.flatnonzero(result.time == result.events[event].time)
    return int(before), int(after)


def test_impacts_come_at_their_times(backend: str) -> None:
    """A ball that keeps 70 % of its speed: flights last sqrt(2/g) times 2*0.7^n."""
    result = run(
        """
  Real h(start=1, fixed=true), v(start=0, fixed=true);
  Integer n(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h <= 0 then
    n = pre(n) + 1;
    reinit(v, -0.7*pre(v));
  end when;""",
        backend,
        2.4,
    )
    flights = np.sqrt(2 / G) * np.array([1.0, *(2 * 0.7 ** np.arange(1, 20))])
    impacts = np.cumsum(flights)
    impacts = impacts[impacts < 2.4]
    assert [e.time for e in result.events] == pytest.approx(impacts.tolist(), abs=5e-7)
    assert result["n"][-1] == len(impacts)
    for i in range(len(impacts)):
        before, after = pair(result, i)
        assert after == before + 1
        assert result["v"][after] == pytest.approx(-0.7 * result["v"][before], rel=1e-12)
        assert result["n"][[before, after]].tolist() == [i, i + 1]
        assert result["h"][before] == pytest.approx(0.0, abs=1e-9)


def test_a_momentum_that_is_reset_takes_the_speed_with_it(backend: str) -> None:
    """A hammer from 2 m that comes back with three tenths of its momentum."""
    result = run(
        """
  parameter Real m = 50;
  Real h(start=2, fixed=true), v(start=0, fixed=true);
  Real p = m*v;
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(p, -0.3*pre(p));
  end when;""",
        backend,
        0.8,
    )
    before, after = pair(result, 0)
    assert result["v"][before] == pytest.approx(-np.sqrt(4 * G), rel=1e-7)
    assert result["v"][after] == pytest.approx(-0.3 * result["v"][before], rel=1e-12)
    assert result["p"] == pytest.approx(50 * result["v"], rel=1e-12, abs=1e-9)
    risen = 0.8 - result.events[0].time
    assert result["v"][-1] == pytest.approx(result["v"][after] - G * risen, rel=1e-7)


@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams", "lsoda", "scipy-bdf"])
def test_every_solver_has_the_same_events(backend: str, solver: str) -> None:
    """A ball thrown up at 3 m/s when time >= 0.25, that lands; sampled thrice."""
    model = planarc.load(
        """model M
  Real h(start=0, fixed=true), v(start=0, fixed=true);
  Boolean flies(start=false, fixed=true);
  discrete Real seen(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = if flies then -10 else 0;
  flies = time >= 0.25 and (not pre(flies) and time < 0.3 or pre(flies) and h >= -1e-3);
  when time >= 0.25 then
    reinit(v, 3);
  elsewhen h < -1e-3 then
    reinit(v, 0);
  end when;
  when sample(0.35, 0.2) then
    seen = h;
  end when;
end M;""",
        backend=backend,
    )
    result = model.simulate(0.9, tolerance=1e-9, solver=solver)
    landing = 0.25 + (3 + np.sqrt(9 + 20 * 1e-3)) / 10
    assert result.statistics.solver.startswith(solver)
    times = [e.time for e in result.events]
    assert [t for t in times if t not in (0.3, times[-1])] == [0.25, 0.35, 0.55, 0.75]
    assert times[-1] == pytest.approx(landing, abs=1e-7)
    for tick in (0.35, 0.55, 0.75):
        row = int(np.flatnonzero(result.time == tick)[-1])
        flown = tick - 0.25
        assert result["seen"][row] == pytest.approx(3 * flown - 5 * flown**2, abs=1e-7)
    assert result["v"][-1] == 0.0
    assert result["h"][-1] == pytest.approx(-1e-3, abs=1e-7)


def test_a_root_of_a_curved_function_is_exact(backend: str) -> None:
    """x = sin(t) passes 0.5 at pi/6 and 5*pi/6; y grows only in between."""
    result = run(
        """
  Real x(start=0, fixed=true), v(start=1, fixed=true), y(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -x;
  der(y) = if x > 0.5 then 1 else 0;""",
        backend,
        3.0,
    )
    times = [np.pi / 6, 5 * np.pi / 6]
    assert [e.time for e in result.events] == pytest.approx(times, abs=5e-8)
    assert result["y"][-1] == pytest.approx(2 * np.pi / 3, abs=1e-7)


@pytest.mark.parametrize("relation", ["time >= t0", "time > t0", "not time < t0", "2*time >= 0.6"])
def test_an_instant_is_met_exactly(backend: str, relation: str) -> None:
    result = run(
        f"""
  parameter Real t0 = 0.3;
  Real x(start=0, fixed=true);
equation
  der(x) = if {relation} then 3 else 0;""",
        backend,
        1.0,
        intervals=10,
    )
    assert [e.time for e in result.events] == [0.3]
    before, after = pair(result, 0)
    assert result["der(x)"][[before, after]].tolist() == [0.0, 3.0]
    assert result["x"][-1] == pytest.approx(2.1, abs=1e-12)
    assert len(result.time) == 12  # the row asked for at 0.3 is one of the two


def test_samples_tick_at_their_instants_and_hold(backend: str) -> None:
    result = run(
        """
  Real x(start=0, fixed=true);
  discrete Real held(start=9, fixed=true);
  Integer n(start=0, fixed=true);
equation
  der(x) = 2*time;
  when sample(0.1, 0.25) then
    held = x;
    n = pre(n) + 1;
  end when;""",
        backend,
        1.0,
    )
    ticks = [0.1 + 0.25 * i for i in range(4)]
    assert [e.time for e in result.events] == ticks
    for i, tick in enumerate(ticks):
        before, after = pair(result, i)
        assert result["held"][after] == pytest.approx(tick**2, abs=1e-8)
        assert result["held"][before] == (9.0 if i == 0 else result["held"][pair(result, i - 1)[1]])
    assert result["n"][-1] == 4


def test_what_happens_at_once_is_one_event(backend: str) -> None:
    """Two instants, a sample and what follows from them fall together at t = 0.5."""
    result = run(
        """
  Real x(start=0, fixed=true);
  Integer a(start=0, fixed=true), b(start=0, fixed=true), c(start=0, fixed=true);
  Integer all_of_them(start=0, fixed=true);
equation
  der(x) = if time < 0.5 then 1 else -1;
  when time >= 0.5 then
    a = pre(a) + 1;
  end when;
  when sample(0.5, 1) then
    b = pre(b) + 1;
  end when;
  when a + b >= 2 then
    c = pre(c) + 1;
  end when;
  when c > 0 then
    all_of_them = a + b + c;
  end when;""",
        backend,
        1.0,
    )
    assert [e.time for e in result.events] == [0.5]
    before, after = pair(result, 0)
    for name, last in (("a", 1), ("b", 1), ("c", 1), ("all_of_them", 3)):
        assert result[name][[before, after]].tolist() == [0, last], name
    assert result["x"][-1] == pytest.approx(0.0, abs=1e-9)


def test_two_balls_that_land_together_are_one_event(backend: str) -> None:
    result = run(
        """
  Real h[2](each start=1, each fixed=true), v[2](each start=0, each fixed=true);
equation
  der(h) = v;
  der(v) = {-9.81, -9.81};
  for i in 1:2 loop
    when h[i] <= 0 then
      reinit(v[i], -0.5*i*pre(v[i]));
    end when;
  end for;""",
        backend,
        0.8,
    )
    fall = np.sqrt(2 / G)
    assert [e.time for e in result.events] == pytest.approx([fall], abs=1e-7)
    _, after = pair(result, 0)
    assert result["v[1]"][after] == pytest.approx(0.5 * G * fall, abs=1e-7)
    assert result["v[2]"][after] == pytest.approx(1.0 * G * fall, abs=1e-7)


def test_any_state_may_be_set_anew(backend: str) -> None:
    """Position and velocity of an oscillator and a free integrator, at one instant."""
    result = run(
        """
  Real x(start=1, fixed=true), v(start=0, fixed=true), z(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -4*x;
  der(z) = 1;
  when time >= 1 then
    reinit(x, pre(x) + 0.5);
    reinit(v, 2*pre(v));
    reinit(z, -1);
  end when;""",
        backend,
        2.0,
    )
    before, after = pair(result, 0)
    x, v = np.cos(2.0) + 0.5, -4 * np.sin(2.0)
    assert result["x"][before] == pytest.approx(np.cos(2.0), abs=1e-7)
    assert result["x"][after] == pytest.approx(x, abs=1e-7)
    assert result["v"][after] == pytest.approx(v, abs=1e-7)
    assert result["z"][after] == -1.0
    end = x * np.cos(2.0) + v / 2 * np.sin(2.0)
    assert result["x"][-1] == pytest.approx(end, abs=1e-7)
    assert result["z"][-1] == pytest.approx(0.0, abs=1e-9)


def test_states_set_at_once_use_the_values_before(backend: str) -> None:
    result = run(
        """
  Real x(start=1, fixed=true), y(start=2, fixed=true);
equation
  der(x) = 0;
  der(y) = 0;
  when {time >= 0.5, time >= 0.75} then
    reinit(x, pre(y));
    reinit(y, pre(x));
  end when;""",
        backend,
        1.0,
    )
    assert [e.time for e in result.events] == [0.5, 0.75]
    for i, after in enumerate(([2.0, 1.0], [1.0, 2.0])):
        row = pair(result, i)[1]
        assert [result["x"][row], result["y"][row]] == after


def test_events_that_come_to_no_rest_name_the_culprits(backend: str, stopped: Stopped) -> None:
    diagnostic, result = stopped(
        whole(
            """
  Real x(start=1, fixed=true);
  Boolean left(start=false, fixed=true), right(start=false, fixed=true), quiet;
equation
  der(x) = -1;
  quiet = x > 0.5;
  left = x <= 0 and not pre(right);
  right = x <= 0 and pre(left);"""
        ),
        backend,
        2.0,
        tolerance=1e-9,
    )
    assert diagnostic.code == "R433"
    assert "`left`" in diagnostic.message
    assert "`right`" in diagnostic.message
    assert "quiet" not in diagnostic.message
    assert "pre" in str(diagnostic.hint)
    assert result.time[-1] == pytest.approx(1.0, abs=1e-8)


def test_neither_truth_agrees_but_for_the_errors_of_states(backend: str) -> None:
    """What wants a millionth less once it slides neither holds nor slides at first."""
    result = run(
        """
  Real x(start=0, fixed=true), wanted;
  Boolean slides(start=false, fixed=true) = wanted > 1;
equation
  wanted = 2*time - (if slides then 1e-6 else 0);
  der(x) = if slides then 1 else 0;""",
        backend,
        1.0,
    )
    assert result.ended is None
    assert result["slides"][-1] == 1
    assert result["x"][-1] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(
    ("given", "told"), [("1", "at small"), ("x", "at large 4")], ids=["steady", "varying"]
)
def test_a_message_that_a_function_makes(
    backend: str, stopped: Stopped, given: str, told: str
) -> None:
    """A text that does not change has one row, and ended in a fault of planarc's own."""
    text = f"""model M
  function named
    input Real x;
    output String s;
  algorithm
    s := if x > 3 then "large " + String(x, significantDigits=1) else "small";
  end named;
  Real x(start=0, fixed=true);
equation
  der(x) = 1;
  assert(x < 4, "at " + named({given}));
end M;"""
    diagnostic, _ = stopped(text, backend, 6.0)
    assert diagnostic.code == "R430" and diagnostic.message.endswith(told)


@pytest.mark.parametrize("back", [1e-3, 0.1])
def test_truths_that_contradict_each_other_end_the_run(
    backend: str, stopped: Stopped, back: float
) -> None:
    """A run left them as they were until the end of its step, and went on without a word."""
    diagnostic, result = stopped(
        whole(
            f"""
  Real x(start=0, fixed=true), wanted;
  Boolean slides(start=false, fixed=true) = wanted > 1;
equation
  wanted = 2*time - (if slides then {back} else 0);
  der(x) = if slides then 1 else 0;"""
        ),
        backend,
        1.0,
    )
    assert diagnostic.code == "R433" and "`slides`" in diagnostic.message
    assert result.time[-1] == pytest.approx(0.5, abs=1e-4)


def test_chattering_names_the_relation_and_gives_advice(backend: str, stopped: Stopped) -> None:
    """A push that turns at x + v = 0 against the motion holds the point on that line."""
    diagnostic, result = stopped(
        whole(
            """
  Real x(start=1, fixed=true), v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = if x + v > 0 then -5 else 5;"""
        ),
        backend,
        3.0,
        tolerance=1e-9,
    )
    assert diagnostic.code == "R432"
    assert "x + v" in diagnostic.message
    assert "mode" in str(diagnostic.hint)
    assert abs(result["x"][-1] + result["v"][-1]) < 1e-3


@pytest.mark.parametrize(
    "relays", ["calm(x(start=-1e3)), wild", "wild, calm(x(start=-1e3))"], ids=["first", "last"]
)
def test_chattering_names_the_component(backend: str, stopped: Stopped, relays: str) -> None:
    text = f"""model M
  model Relay
    Real x(start=1, fixed=true), v(start=0, fixed=true);
  equation
    der(x) = v;
    der(v) = if x + v > 0 then -5 else 5;
  end Relay;
  Relay {relays};
end M;"""
    diagnostic, _ = stopped(text, backend, 3.0, tolerance=1e-9)
    assert diagnostic.code == "R432"
    assert "`x + v > 0` in `wild` switches to and fro" in diagnostic.message


def test_a_regularised_relation_runs_on(backend: str) -> None:
    """The advice holds: smoothed, the same law slides down the line, v = -x."""
    result = run(
        """
  Real x(start=1, fixed=true), v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -5*tanh((x + v)/1e-3);""",
        backend,
        3.0,
    )
    late = result.time > 1
    ratio = result["x"][late] / result["x"][late][0]
    assert ratio == pytest.approx(np.exp(-(result.time[late] - result.time[late][0])), abs=1e-3)


def test_no_event_switches_without_rows(backend: str) -> None:
    result = run(
        """
  Real x(start=0, fixed=true);
equation
  der(x) = noEvent(if time < 0.5 then 1 else 2);""",
        backend,
        1.0,
    )
    assert result.events == ()
    assert len(result.time) == 51
    assert result["x"][-1] == pytest.approx(1.5, abs=1e-5)


def test_a_loop_of_truths_and_numbers_finds_its_mode(backend: str) -> None:
    """A diode on a source and a resistor: its law holds either s = v or s = i.

    The current is that of the half wave; it starts at 0 and stops at pi.
    """
    result = run(
        """
  Real u, i, v, s;
  Boolean off;
  Real charge(start=0, fixed=true);
equation
  off = s < 0;
  v = s*(if off then 1 else 0);
  i = s*(if off then 0 else 1);
  u = sin(time - 1);
  u = v + 2*i;
  der(charge) = i;""",
        backend,
        1 + 2 * np.pi,
        intervals=400,
    )
    times = [1.0, 1 + np.pi, 1 + 2 * np.pi]
    assert [e.time for e in result.events][:2] == pytest.approx(times[:2], abs=1e-8)
    wave = np.sin(result.time - 1)
    assert result["i"] == pytest.approx(np.maximum(wave, 0) / 2, abs=1e-8)
    assert result["v"] == pytest.approx(np.minimum(wave, 0), abs=1e-8)
    assert result["charge"][-1] == pytest.approx(1.0, abs=1e-7)


def test_a_relay_with_hysteresis_swings_between_its_limits(backend: str) -> None:
    """A truth that depends on its own past and on the number that it drives."""
    result = run(
        """
  Real x(start=0, fixed=true);
  Boolean on(start=false, fixed=true);
equation
  der(x) = if on then 1 else -1;
  on = x < -0.25 or pre(on) and x <= 0.25;""",
        backend,
        3.0,
    )
    times = [0.25 + 0.5 * i for i in range(6)]
    assert [e.time for e in result.events] == pytest.approx(times, abs=1e-9)
    wave = np.abs((result.time + 0.25) % 1 - 0.5) - 0.25
    assert result["x"] == pytest.approx(wave, abs=1e-9)


SLIDER = """
  inner PlanarMultiBody.World world(g=0);
  PlanarMultiBody.Joints.Revolute a(phi(start=0.3, fixed=true), w(start=2, fixed=true));
  PlanarMultiBody.Joints.Revolute b(phi(start=-0.4));
  PlanarMultiBody.Joints.Revolute c;
  PlanarMultiBody.Joints.Prismatic s(n={1, 0}, s(start=1.3));
  PlanarMultiBody.Parts.FixedTranslation crank(r={0.3, 0});
  PlanarMultiBody.Parts.FixedTranslation rod(r={1, 0});
  PlanarMultiBody.Parts.Body wheel(m=1, I=0.1);
  PlanarMultiBody.Parts.Body piston(m=1, I=0.1);
  Real energy = 0.05*a.w^2 + 0.5*s.v^2;
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_a, wheel.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, rod.frame_a);
  connect(rod.frame_b, c.frame_a);
  connect(c.frame_b, s.frame_b);
  connect(world.frame_b, s.frame_a);
  connect(s.frame_b, piston.frame_a);
  when time >= 1 then
    reinit(a.w, 2*pre(a.w));
  end when;"""


def test_all_speeds_of_a_loop_follow_the_one_set_anew(backend: str) -> None:
    """Without gravity and friction the energy is constant, but for its factor 4 at the event."""
    result = run(SLIDER, backend, 3.0, intervals=300)
    before, after = pair(result, 0)
    for name in ("s.v", "a.w", "b.w", "c.w"):
        assert result[name][after] == pytest.approx(2 * result[name][before], abs=1e-9), name
    energy = result["energy"]
    assert energy[: before + 1] == pytest.approx(energy[0], rel=1e-6)
    assert energy[after:] == pytest.approx(4 * energy[0], rel=1e-6)
    assert result["a.phi"][-1] > 2 * np.pi  # round the dead centres
    place = 0.3 * np.cos(result["a.phi"]) + np.sqrt(1 - (0.3 * np.sin(result["a.phi"])) ** 2)
    assert result["s.s"] == pytest.approx(place, abs=1e-9)


def test_states_are_chosen_again_after_an_event(backend: str) -> None:
    """A pin in a slot whose angle p jumps: first y is a state, afterwards x has to be.

    With s along the slot, (x, y) = s*(-sin(p), cos(p)); u pushes along it: der(s) = u*(-sin, cos).
    """
    result = run(
        """
  Real p(start=0.001, fixed=true);
  Real x, y(start=-0.48, fixed=true), push;
equation
  der(p) = 0;
  der(x) = 1 + push*cos(p);
  der(y) = 1 + push*sin(p);
  cos(p)*x + sin(p)*y = 0;
  when time >= 0.5 then
    reinit(p, 1.5);
  end when;""",
        backend,
        1.0,
    )
    before, after = pair(result, 0)
    assert "y" in result.states[0].states
    assert [(c.time, sorted(c.states)) for c in result.states[1:]] == [(0.5, ["p", "x"])]

    def along(p: float) -> float:
        return float(np.cos(p) - np.sin(p))  # der(s)

    y = -0.48 + 0.5 * along(0.001) * np.cos(0.001)
    assert result["y"][[before, after]] == pytest.approx([y, y], rel=1e-7)
    s = y / np.cos(1.5) + 0.5 * along(1.5)
    assert result["x"][-1] == pytest.approx(-s * np.sin(1.5), rel=1e-7)
    assert result["y"][-1] == pytest.approx(s * np.cos(1.5), rel=1e-7)


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_chain_of_clauses_comes_to_rest_however_long(backend: str) -> None:
    """Each clause waits for the pass after that of the one before it."""
    count = 150
    waits = "\n".join(
        f"when k[{i}] > pre(k[{i}]) then k[{i + 1}] = pre(k[{i + 1}]) + 1; end when;"
        for i in range(1, count)
    )
    model = planarc.load(f"""
    model Chain
      discrete Integer k[{count}](each start=0, each fixed=true);
    equation
      when time > 0.5 then k[1] = pre(k[1]) + 1; end when;
      {waits}
    end Chain;
    """)
    run = model.simulate(1, backend=backend)
    assert run[f"k[{count}]"][-1] == 1
