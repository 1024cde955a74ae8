"""Truths at events are those of the values there, down to zero and at any scale."""

from __future__ import annotations

import numpy as np
import pytest

import planarc

SOLVERS = ["cvode-bdf", "cvode-adams", "lsoda", "scipy-bdf"]


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def run(body: str, backend: str, stop: float, **options: object) -> planarc.Result:
    model = planarc.load(f"model M\n{body}\nend M;", backend=backend)
    return model.simulate(stop, intervals=20, **options)  # type: ignore[arg-type]


def last_before(result: planarc.Result, name: str, t: float) -> float:
    return float(result[name][np.flatnonzero(result.time < t)[-1]])


RELATIONS = {"u > 0": (1, 0, 0), "u >= 0": (1, 1, 0), "u < 0": (0, 0, 1), "u <= 0": (0, 1, 1)}


@pytest.mark.parametrize("relation", RELATIONS)
@pytest.mark.parametrize("down", [True, False])
def test_zero_is_on_the_side_that_the_relation_says(
    backend: str, relation: str, down: bool
) -> None:
    """A step function through 1, 0 and -1, or back."""
    sign = 1 if down else -1
    result = run(
        f"""
  Real u = {sign}*(if time < 1 then 1 elseif time < 2 then 0 else -1);
  Boolean b = {relation};""",
        backend,
        3.0,
    )
    found = [last_before(result, "b", t) for t in (1.0, 2.0, 3.0)]
    assert found == list(RELATIONS[relation][::sign])


@pytest.mark.parametrize("relation", RELATIONS)
def test_a_sampled_value_that_is_zero(backend: str, relation: str) -> None:
    result = run(
        f"""
  Integer u(start=1, fixed=true);
  Boolean b = {relation};
equation
  when sample(1, 1) then
    u = pre(u) - 1;
  end when;""",
        backend,
        2.5,
    )
    assert [last_before(result, "b", t) for t in (1.0, 2.0, 2.5)] == list(RELATIONS[relation])


def test_a_limit_reached_exactly(backend: str) -> None:
    result = run(
        """
  Real u = min(time, 1);
  Boolean full = u >= 1, more = u > 1;
  Integer whole = integer(u);""",
        backend,
        2.0,
    )
    assert [result[n][-1] for n in ("full", "more", "whole")] == [1, 0, 1]
    assert last_before(result, "full", 1.0) == last_before(result, "whole", 1.0) == 0


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_counter_follows_the_time(backend: str, solver: str) -> None:
    """The relation is true for one instant only, and ready for the next."""
    result = run(
        """
  Integer count(start=0, fixed=true);
equation
  when integer(time) > pre(count) then
    count = pre(count) + 1;
  end when;""",
        backend,
        5.5,
        solver=solver,
    )
    assert [e.time for e in result.events] == pytest.approx([1, 2, 3, 4, 5], abs=1e-9)
    assert result["count"][-1] == 5


@pytest.mark.parametrize("call", ["integer(floor(x))", "integer(ceil(floor(x)))"])
@pytest.mark.parametrize("start", [0, -3])
@pytest.mark.parametrize("speed", [1, -1])
def test_the_whole_part_of_a_whole_number(backend: str, call: str, start: int, speed: int) -> None:
    result = run(
        f"""
  Real x(start={start}.5, fixed=true);
  Integer n = {call};
equation
  der(x) = {speed};""",
        backend,
        4.25,
    )
    clear = np.abs(result["x"] - np.round(result["x"])) > 1e-3
    assert result["n"][clear].tolist() == np.floor(result["x"][clear]).tolist()


def test_the_whole_part_of_sampled_values(backend: str) -> None:
    result = run(
        """
  Real u(start=-1.5, fixed=true);
  Integer low = integer(u), high = integer(ceil(u)), towards = div(integer(2*u), 2);
equation
  when sample(0.5, 0.5) then
    u = pre(u) + 0.5;
  end when;""",
        backend,
        3.2,
    )
    u = result["u"]
    assert result["low"].tolist() == np.floor(u).tolist()
    assert result["high"].tolist() == np.ceil(u).tolist()
    assert result["towards"].tolist() == np.trunc(u).tolist()


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("scale", [1e-100, 1e-18, 1e-13, 1.0, 1e13])
def test_events_do_not_depend_on_the_unit(backend: str, solver: str, scale: float) -> None:
    """x falls from s to -s, and is set to s again: at any size s."""
    result = run(
        f"""
  parameter Real s = {scale};
  Real x(start=s, fixed=true, nominal=s);
  Integer below(start=0, fixed=true), ends(start=0, fixed=true);
equation
  der(x) = -s;
  when x < 0 then
    below = pre(below) + 1;
  end when;
  when x <= -s then
    ends = pre(ends) + 1;
    reinit(x, s);
  end when;""",
        backend,
        4.5,
        solver=solver,
    )
    assert [e.time for e in result.events] == pytest.approx([1, 2, 3, 4], abs=1e-6)
    assert [result["below"][-1], result["ends"][-1]] == [2, 2]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("keeps", [0.5, 0.7, 0.8])
def test_a_ball_that_bounces_to_its_rest_stays_on_the_floor(
    backend: str, keeps: float, tolerance: float
) -> None:
    """The speed is set anew at the instant at which it is zero: what holds for the new one
    counts. Impacts pile up at sqrt(2/g)*(1 + e)/(1 - e)."""
    result = run(
        f"""
  Real h(start=1, fixed=true), v(start=0, fixed=true);
  Boolean flies(start=true, fixed=true), touches;
  discrete Real next(start=0, fixed=true);
equation
  touches = h <= 0;
  der(h) = v;
  der(v) = if flies then -9.81 else 0;
  when {{h <= 0 and v <= 0, touches}} then
    next = if edge(touches) then -{keeps}*pre(v) else 0;
    flies = next > 0;
    reinit(v, next);
  end when;""",
        backend,
        5.0,
        tolerance=tolerance,
    )
    assert result.ended is None
    end = np.sqrt(2 / 9.81) * (1 + keeps) / (1 - keeps)
    assert result.events[-1].time == pytest.approx(end, rel=0.05)
    assert result["flies"][-1] == 0
    assert abs(result["h"]).min() < 1e-3
    assert result["h"].min() > -10 * tolerance
    assert result["v"][-1] == 0


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("keeps", [1.0, 0.9])
@pytest.mark.parametrize("height", [1e-2, 1e-4, 1e-6])
def test_a_ball_does_not_fall_through_the_floor(
    backend: str, solver: str, keeps: float, height: float
) -> None:
    """Bounces as high as the tolerance, or lower: they are followed, or the run stops."""
    model = planarc.load(
        f"""model M
  Real h(start={height}, fixed=true), v(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h <= 0 then
    reinit(v, -{keeps}*pre(v));
  end when;
end M;""",
        backend=backend,
    )
    try:
        result = model.simulate(2.0, intervals=20, solver=solver)
    except planarc.RunStopped as stopped:
        assert [d.code for d in stopped.diagnostics] == ["R432"]
        result = stopped.result
    assert result["h"].min() > -1e-5


@pytest.mark.parametrize("start", ["0", "1"])
def test_what_leaves_zero_without_speed_is_seen(backend: str, start: str) -> None:
    """x = 1 - t^2/2, or from zero on: the relation switches right after the first row."""
    result = run(
        f"""
  Real x(start={start}, fixed=true), v(start=0, fixed=true);
  Boolean below = x < {start};
equation
  der(x) = v;
  der(v) = -1;""",
        backend,
        1.0,
    )
    assert result.events == ()
    assert not result["below"][0]
    assert result["below"][1:].all()


def test_the_first_row_shows_truths_at_the_start(backend: str) -> None:
    """Strictly above zero is what starts from zero only later, and a when sees that it comes."""
    result = run(
        """
  Real u = 3*sin(2*time);
  Real side = if u > 0 then integer(u) else integer(u) - 1;
  Integer n(start=0, fixed=true);
equation
  when u > 0 then
    n = pre(n) + 1;
  end when;""",
        backend,
        0.1,
    )
    assert result.time[:2].tolist() == [0, 0]
    assert result["side"][:2].tolist() == [-1, 0]
    assert result["n"][:2].tolist() == [0, 1]


def test_what_leaves_zero_slowly_is_seen_at_once(backend: str) -> None:
    """A clutch begins to slip: its speed, an error of rounding before, grows with the square of
    time, and in the time that one looks ahead by less than an error of rounding."""
    result = run(
        """
  Real w(start=10, fixed=true), f(start=0, fixed=true);
  Boolean slips(start=false, fixed=true), moves(start=true);
  discrete Real since(start=0, fixed=true);
equation
  der(f) = 10;
  slips = pre(slips) or f > 10;
  der(w) = if slips then f - 10 else 0;
  moves = w > 0;
  when time >= 0.5 then
    reinit(w, -5e-13);
  end when;
  when moves then
    since = time;
  end when;""",
        backend,
        2.0,
        tolerance=1e-8,
    )
    assert result["since"][-1] == pytest.approx(1, abs=1e-6)
    assert result["w"][-1] == pytest.approx(5, rel=1e-6)


@pytest.mark.parametrize("width", ["1e300", "0.5"])
def test_a_branch_without_value_that_time_does_not_choose_stops_no_start(
    backend: str, width: str
) -> None:
    """A pulse that never ends: its falling edge, with 0 for its length, is not asked for."""
    result = run(
        f"""
  parameter Real width = {width};
  parameter Real over = width + 0.25;
  discrete Real begun(start = 0, fixed = true);
  Real v = if time < begun + 0.25 then 4*(time - begun) elseif time < begun + width then 1
    elseif time < begun + over then (begun + over - time)/(over - width) else 0;
equation
  when sample(2, 2) then
    begun = time;
  end when;""",
        backend,
        3.0,
    )
    rising = {0.15: 0.6, 0.3: 1.0, 2.1: 0.4, 2.4: 1.0}
    falling = {0.6: 0.6, 1.05: 0.0, 2.7: 0.2} if width == "0.5" else {0.6: 1.0, 1.95: 1.0}
    for t, v in {**rising, **falling}.items():
        assert result.at("v", t) == pytest.approx(v, abs=1e-9)
