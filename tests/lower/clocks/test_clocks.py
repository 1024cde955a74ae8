"""Clocked parts against recursions, instants and second formulations."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import fsolve

import planarc

BACKENDS: tuple[dict[str, Any], ...] = ({"backend": "native"}, {"backend": "numpy"})


def run(body: str, stop: float = 1.0, **options: Any) -> planarc.Result:
    """A run of machine code, which is that of NumPy."""
    text = f"model M\n{body}\nend M;"
    native, python = (planarc.load(text, **b).simulate(stop, **options) for b in BACKENDS)
    for name in native.names:
        np.testing.assert_allclose(native[name], python[name], rtol=1e-9, atol=1e-9)
    return native


def ticks(result: planarc.Result, counter: str) -> list[float]:
    """The instants at which a counter that begins with 0 counts on."""
    time, n = result["time"], result[counter]
    found = [] if n[0] == 0 else [float(time[0])]
    return [*found, *(float(t) for t in time[1:][np.diff(n) > 0])]


def values(result: planarc.Result, name: str, counter: str) -> list[float]:
    """What a variable is after each tick."""
    n = result[counter]
    last = [np.flatnonzero(n == k)[-1] for k in range(1, int(n[-1]) + 1)]
    return [float(result[name][i]) for i in last]


def test_a_sampled_controller_of_a_continuous_plant() -> None:
    """Between ticks the plant x' = A x + B u has a closed form, so that the loop is a recursion."""
    found = run(
        """
  Real x(start=1, fixed=true), v(start=0, fixed=true);
  Real y, dy, u, i(start=0);
  Integer n(start=0);
equation
  der(x) = v;
  der(v) = -x - 0.2*v + hold(u);
  when Clock(1, 10) then
    y = sample(x);
    dy = (y - previous(y))/interval();
    i = previous(i) + interval()*y;
    u = -2*y - 0.1*dy - 0.5*i;
    n = previous(n) + 1;
  end when;
""",
        tolerance=1e-11,
    )
    a = np.array([[0, 1, 0], [-1, -0.2, 1], [0, 0, 0]])
    step = expm(a * 0.1)
    state, i, before, expected = np.array([1.0, 0.0]), 0.0, 0.0, []
    for _ in range(11):
        y = state[0]
        i += 0.1 * y
        u = -2 * y - 0.1 * (y - before) / 0.1 - 0.5 * i
        before = y
        expected.append(u)
        state = (step @ np.array([*state, u]))[:2]
    np.testing.assert_allclose(values(found, "u", "n"), expected, atol=1e-8)


def test_a_clock_and_a_when_with_sample_are_one() -> None:
    plant = "Real x(start=1, fixed=true);"
    clocked = run(
        f"{plant} Real u(start=0); equation der(x) = hold(u); "
        "u = previous(u) - 0.3*sample(x, Clock(0.125));"
    )
    when = run(
        f"{plant} discrete Real u(start=0, fixed=true); equation der(x) = u; "
        "when sample(0, 0.125) then u = pre(u) - 0.3*pre(x); end when;"
    )
    np.testing.assert_allclose(clocked["x"], when["x"], rtol=1e-9)


# Rates ------------------------------------------------------------------------------------------

OPERATORS = ("subSample", "superSample", "shiftSample")


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(OPERATORS), st.integers(1, 3), st.integers(1, 3)),
        min_size=1,
        max_size=4,
    ),
    st.integers(0, 4),
)
def test_parts_tick_when_fractions_say_so(chain: list[tuple[str, int, int]], at: int) -> None:
    """A chain of conversions, whose one clock stands at any of its links."""
    at = min(at, len(chain))
    beats = [(Fraction(1), Fraction(0))]
    for operator, number, resolution in chain:
        interval, first = beats[-1]
        match operator:
            case "subSample":
                beats.append((interval * number, first))
            case "superSample":
                beats.append((interval / number, first))
            case _:
                beats.append((interval, first + interval * Fraction(number, resolution)))
    unit = Fraction(1, 4) / beats[at][0]
    lines = []
    for k, (operator, number, resolution) in enumerate(chain):
        last = f", {resolution}" if operator == "shiftSample" else ""
        lines.append(f"  c{k + 1} = {operator}(c{k}, {number}{last});")
    shifted = beats[at][1] * unit
    given_clock = f"Clock({Fraction(1, 4).numerator}, {Fraction(1, 4).denominator})"
    if shifted:  # the clock that is given begins with the run
        at, unit = 0, Fraction(1, 4)
    lines.append(f"  c{at} = {given_clock};")
    count = len(beats)
    declared = "".join(f"  Clock c{k};\n  Integer n{k}(start=0);\n" for k in range(count))
    lines += [f"  when c{k} then n{k} = previous(n{k}) + 1; end when;" for k in range(count)]
    found = planarc.load(f"model M\n{declared}equation\n" + "\n".join(lines) + "\nend M;").simulate(
        2, intervals=2
    )
    for k, (interval, first) in enumerate(beats):
        expected = []
        t = first * unit
        while t <= 2:
            expected.append(float(t))
            t += interval * unit
        np.testing.assert_allclose(ticks(found, f"n{k}"), expected, atol=1e-12)


def test_values_between_clocks() -> None:
    """Each part reads what the other one has, at common ticks after it."""
    found = run(
        """
  Integer fast(start=0), slow(start=0), again(start=0), late(start=7), early(start=-3);
equation
  when Clock(1, 10) then
    fast = previous(fast) + 1;
  end when;
  slow = subSample(fast, 3);
  again = superSample(slow, 3);
  late = shiftSample(fast, 3, 2);
  early = backSample(late, 1, 2);
"""
    )

    def at(t: float, name: str) -> float:
        return float(found[name][np.flatnonzero(found["time"] <= t + 1e-9)[-1]])

    assert [at(t, "slow") for t in (0, 0.29, 0.3, 0.61)] == [1, 1, 4, 7]
    assert [at(t, "again") for t in (0, 0.1, 0.3, 0.4)] == [1, 1, 4, 4]
    assert [at(t, "late") for t in (0, 0.14, 0.15, 0.26)] == [7, 7, 2, 3]
    assert [at(t, "early") for t in (0, 0.1, 0.19, 0.2)] == [-3, 7, 7, 2]


def test_factors_that_are_to_be_found() -> None:
    found = run(
        """
  Integer a(start=0), b(start=0);
equation
  when Clock(2, 100) then
    a = previous(a) + superSample(b);
  end when;
  when Clock(10, 100) then
    b = previous(b) + 1;
  end when;
"""
    )
    expected = np.cumsum([1 + k // 5 for k in range(51)])
    assert found["a"][-1] == expected[-1]


def test_a_run_that_begins_later_ticks_from_there_on() -> None:
    found = run(
        "Integer n(start=0); equation when Clock(0.25) then n = previous(n) + 1; end when;",
        3.0,
        start_time=2.1,
    )
    np.testing.assert_allclose(ticks(found, "n"), [2.1, 2.35, 2.6, 2.85], atol=1e-12)


def test_the_interval_may_be_set_without_compiling_again() -> None:
    model = planarc.load(
        "model M parameter Real T=0.25; Integer n(start=0); Real d; equation "
        "when Clock(T) then n = previous(n) + 1; d = interval(); end when; end M;"
    )
    found = model.simulate(1, parameters={"T": 0.3})
    np.testing.assert_allclose(ticks(found, "n"), [0, 0.3, 0.6, 0.9], atol=1e-12)
    assert found["d"][-1] == pytest.approx(0.3)


# Conditions -------------------------------------------------------------------------------------


def test_a_clock_of_a_condition_ticks_after_each_rise() -> None:
    """Each time that the angle has turned by 0.5 rad, as a toothed wheel tells it: the condition
    hangs on what the tick sets."""
    found = run(
        """
  Real phi(start=0, fixed=true);
  Real last(start=0), d;
  Integer n(start=0);
  Boolean first;
  Clock c = Clock(phi - hold(last) > 0.5, 0.75);
equation
  der(phi) = 1 + time;
  when c then
    last = sample(phi);
    n = previous(n) + 1;
    d = interval();
    first = firstTick();
  end when;
""",
        0.95,
        tolerance=1e-11,
    )
    expected = [np.sqrt(1 + 2 * 0.5 * k) - 1 for k in (1, 2)]
    np.testing.assert_allclose(ticks(found, "n"), expected, atol=1e-8)
    gaps = [0.75, expected[1] - expected[0]]
    np.testing.assert_allclose(values(found, "d", "n"), gaps, atol=1e-8)
    assert values(found, "first", "n") == [1, 0]


def test_a_condition_that_is_true_at_the_start_ticks_there() -> None:
    found = run(
        "Integer n(start=0); equation when Clock(cos(20*time) > 0) then n = previous(n) + 1; "
        "end when;"
    )
    expected = [0, 1.5 * np.pi / 20, 3.5 * np.pi / 20, 5.5 * np.pi / 20]
    np.testing.assert_allclose(ticks(found, "n"), expected, atol=1e-8)


def test_parts_of_the_ticks_of_a_condition() -> None:
    found = run(
        """
  Integer n(start=0), m(start=0);
equation
  when Clock(sin(20*time) > 0) then
    n = previous(n) + 1;
  end when;
  when subSample(shiftSample(Clock(sin(20*time) > 0), 1), 2) then
    m = previous(m) + 1;
  end when;
""",
        3.0,
    )
    rises = 2 * np.pi * np.arange(10) / 20
    np.testing.assert_allclose(ticks(found, "n"), rises, atol=1e-8)
    np.testing.assert_allclose(ticks(found, "m"), ticks(found, "n")[1::2], atol=1e-9)


# What holds at a tick ---------------------------------------------------------------------------

METHODS = {"ExplicitEuler": 1, "ImplicitEuler": 1, "ImplicitTrapezoid": 2}


@pytest.mark.parametrize(("method", "order"), METHODS.items())
def test_derivatives_are_integrated_by_the_method_of_the_clock(method: str, order: int) -> None:
    """x' = v, v' = -4 x - 0.5 v is an oscillation whose errors shrink by the method's order."""

    def error(count: int) -> float:
        found = run(
            f"""
  parameter Real k=4;
  Real x(start=1), v(start=0);
equation
  when Clock(Clock(1, {count}), "{method}") then
    der(x) = v;
    der(v) = -k*x - 0.5*v;
  end when;
"""
        )
        exact = expm(np.array([[0, 1], [-4, -0.5]]))[0, 0]
        return float(abs(found["x"][-1] - exact))

    assert np.log2(error(40) / error(80)) == pytest.approx(order, abs=0.12)


def test_linear_equations_are_solved_together() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(5, 5)) + 3 * np.eye(5), rng.normal(size=5)
    rows = "\n".join(
        f"  {float(b[i])!r}*u = {' + '.join(f'({float(a[i, j])!r})*x[{j + 1}]' for j in range(5))};"
        for i in range(5)
    )
    found = run(f"  Real x[5], u;\nequation\n  u = sample(1 + time, Clock(0.5));\n{rows}")
    np.testing.assert_allclose(
        [found[f"x[{k}]"][-1] for k in range(1, 6)], np.linalg.solve(a, 2 * b), rtol=1e-9
    )


def test_an_algorithm_ticks_as_a_whole() -> None:
    """A median of three, by statements; what is not set keeps its value from the tick before."""
    found = run(
        """
  Real w[3](each start=0), s, m;
  Integer n(start=0), k(start=0);
equation
  s = sample(sin(10*time), Clock(0.1));
algorithm
  n := previous(n) + (if s > 2 then 0 else 1);
  w := cat(1, previous(w[2:3]), {s});
  m := max(min(w[1], w[2]), min(max(w[1], w[2]), w[3]));
  if mod(n, 2) == 0 then
    k := n;
  end if;
"""
    )
    samples = np.sin(10 * np.arange(11) / 10)
    padded = [0, 0, *samples]
    expected = [np.median(padded[i : i + 3]) for i in range(11)]
    np.testing.assert_allclose(values(found, "m", "n"), expected, atol=1e-9)
    assert values(found, "k", "n") == [0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10]


def test_branches_of_an_if_may_give_variables_in_any_order() -> None:
    found = run(
        """
  Integer a(start=0), b(start=5);
equation
  when Clock(0.25) then
    if previous(a) < 3 then
      a = previous(a) + 1;
      b = 2*a;
    else
      b = previous(b) + 10;
      a = 0;
    end if;
  end when;
"""
    )
    assert values_of(found, "a") == [1, 2, 3, 0, 1] and values_of(found, "b") == [2, 4, 6, 16, 2]


def values_of(result: planarc.Result, name: str) -> list[float]:
    """What a variable is at 0, 0.25 ... 1 s, after the event."""
    at = [np.flatnonzero(result["time"] <= t + 1e-9)[-1] for t in np.arange(0, 1.01, 0.25)]
    return [float(result[name][i]) for i in at]


def test_entries_of_an_array_may_have_clocks_of_their_own() -> None:
    found = run(
        """
  Integer n[2](each start=0);
  Real y[3];
  Clock c[2];
equation
  c[1] = Clock(0.25);
  c[2] = Clock(0.5);
  for i in 1:2 loop
    when c[i] then
      n[i] = previous(n[i]) + 1;
    end when;
    y[i] = sample(time, c[i]);
  end for;
  y[3] = time;
"""
    )
    assert (found["n[1]"][-1], found["n[2]"][-1]) == (5, 3)
    assert values_of(found, "y[2]") == pytest.approx([0, 0, 0.5, 0.5, 1])
    assert found["y[3]"][-1] == 1


def test_assertions_are_looked_at_when_their_part_ticks() -> None:
    body = """
  Real y = sample(time, Clock(0.25));
equation
  when Clock(0.25) then
    assert(y < {limit}, "y is " + String(y));
  end when;
"""
    text = "model M" + body + "end M;"
    with pytest.raises(planarc.PlanarcError, match=r"y is 0\.5"):
        planarc.load(text.replace("{limit}", "0.4")).simulate(1)
    planarc.load(text.replace("{limit}", "1.1")).simulate(1)


def test_what_is_sampled_is_the_left_limit() -> None:
    """A saw that jumps at the ticks: each tick finds it before its jump."""
    found = run(
        """
  Real saw(start=0, fixed=true);
  Real y;
equation
  der(saw) = 1;
  when sample(0.25, 0.25) then
    reinit(saw, 0);
  end when;
  y = sample(saw, Clock(0.25));
"""
    )
    assert values_of(found, "y") == pytest.approx([0, 0.25, 0.25, 0.25, 0.25], abs=1e-9)


def test_records_tick_field_by_field() -> None:
    found = run(
        """
  record R
    Real a;
    Real b[2];
  end R;
  function pair
    input Real x;
    output R r = R(x, {2*x, 3*x});
  algorithm
  end pair;
  R r(a(start=1), b(each start=2)), s;
  Complex z(re(start=1), im(start=0));
equation
  when Clock(0.25) then
    r = R(previous(r.a) + 1, 2*previous(r.b));
    z = previous(z)*Complex(0, 1);
    s = sample(pair(time));
  end when;
"""
    )
    assert values_of(found, "r.a") == [2, 3, 4, 5, 6]
    assert values_of(found, "r.b[2]") == [4, 8, 16, 32, 64]
    assert values_of(found, "z.im") == [1, 0, -1, 0, 1]
    assert values_of(found, "s.b[2]") == pytest.approx([0, 0.75, 1.5, 2.25, 3])


def test_a_derivative_of_the_plant_may_be_sampled() -> None:
    found = run(
        "Real x(start=1, fixed=true), y; equation der(x) = -x; y = sample(der(x), Clock(0.25));",
        tolerance=1e-10,
    )
    expected = -np.exp(-np.arange(0, 1.01, 0.25))
    assert values_of(found, "y") == pytest.approx(expected, abs=1e-8)


def test_vectors_of_clocks_are_connected_entry_by_entry() -> None:
    found = run(
        """
  connector Out = output Clock;
  connector In = input Clock;
  block Source
    Out y[2];
  equation
    y[1] = Clock(1, 10);
    y[2] = Clock(1, 4);
  end Source;
  block Counter
    In u[2];
    Integer n[2](each start=0);
  equation
    for i in 1:2 loop
      when u[i] then
        n[i] = previous(n[i]) + 1;
      end when;
    end for;
  end Counter;
  Source source;
  Counter counter;
  Clock both[2] = {Clock(1, 5), source.y[1]};
  Integer k(start=0);
  Clock unused = Clock(0.001);
equation
  connect(source.y, counter.u);
  when both[1] then
    k = previous(k) + 1;
  end when;
"""
    )
    assert [found[n][-1] for n in ("counter.n[1]", "counter.n[2]", "k")] == [11, 5, 6]
    events = found["time"][1:][np.diff(found["time"]) == 0]
    assert len(set(events)) < 20  # what is unused makes none


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(OPERATORS), st.integers(1, 3), st.integers(1, 3), st.integers(0, 9)
        ),
        min_size=1,
        max_size=5,
    )
)
def test_a_tree_of_filters_in_many_clocks(links: list[tuple[str, int, int, int]]) -> None:
    """Each part filters the value of an earlier one; at one instant, sources come first."""
    beats = [(Fraction(1, 10), Fraction(0))]
    lines = ["  v0 = 0.5*previous(v0) + sample(time, Clock(1, 10)) + 1;"]
    sources = [0]
    for k, (operator, number, resolution, pick) in enumerate(links, start=1):
        source = pick % k
        interval, first = beats[source]
        arguments = f"v{source}, {number}"
        match operator:
            case "subSample":
                interval *= number
            case "superSample":
                interval /= number
            case _:
                first += interval * Fraction(number, resolution)
                arguments += f", {resolution}"
        beats.append((interval, first))
        sources.append(source)
        lines.append(f"  v{k} = 0.5*previous(v{k}) + {operator}({arguments});")
    names = ", ".join(f"v{k}(start={k})" for k in range(len(beats)))
    found = planarc.load(f"model M\n  Real {names};\nequation\n" + "\n".join(lines) + "\nend M;")
    result = found.simulate(2, intervals=2)
    value = [float(k) for k in range(len(beats))]
    ends = [(first + i * interval, k) for k, (interval, first) in enumerate(beats)
            for i in range(int((2 - first) / interval) + 1)]  # fmt: skip
    for t, k in sorted(ends):
        value[k] = value[k] / 2 + (float(t) + 1 if k == 0 else value[sources[k]])
    assert [result[f"v{k}"][-1] for k in range(len(beats))] == pytest.approx(value)


def test_nonlinear_equations_are_solved_together() -> None:
    """Two unknowns at each tick, by Newton's method from the tick before, beside scipy's."""
    found = run(
        """
  Real a, b, c(start=1), s;
equation
  when Clock(0.25) then
    s = sample(time);
    a = 1 + s + sin(b)/2;
    b = cos(a) + c/3;
    c*c*c + c = 2 + a*s;
  end when;
""",
    )

    def misfit(x: np.ndarray, s: float) -> list[float]:
        a, b, c = x
        return [a - 1 - s - np.sin(b) / 2, b - np.cos(a) - c / 3, c**3 + c - 2 - a * s]

    x = np.array([0.0, 0.0, 1.0])
    expected = []
    for s in np.arange(0, 1.01, 0.25):
        x = fsolve(misfit, x, args=(s,), xtol=1e-12)
        expected.append(x)
    shown = np.transpose([values_of(found, n) for n in "abc"])
    np.testing.assert_allclose(shown, expected, rtol=1e-9)


def test_an_actuator_that_saturates_stands_in_the_loop() -> None:
    """Back-calculation against windup: the integral hangs on the force, and this on it."""
    found = run(
        """
  Real e, v, u, i(start=0);
  Boolean full;
equation
  when Clock(1, 10) then
    e = sample(cos(2*time));
    v = 2*e + i;
    full = v > 1.5 or v < -1.5;
    u = if v > 1.5 then 1.5 elseif v < -1.5 then -1.5 else v;
    i = previous(i) + 0.1*(4*e + (u - v)/0.3);
  end when;
""",
    )
    integral, expected = 0.0, []
    for e in np.cos(2 * np.arange(11) / 10):
        free = integral + 0.4 * e  # i = free + (u - v)/3, v = 2 e + i
        v = 2 * e + free
        if abs(v) > 1.5:
            u = float(np.copysign(1.5, v))
            v = (2 * e + free + u / 3) * 3 / 4
        integral = v - 2 * e
        expected.append(v)
    times = np.arange(11) / 10
    at = [np.flatnonzero(found["time"] <= t + 1e-9)[-1] for t in times]
    assert [float(found["v"][i]) for i in at] == pytest.approx(expected, abs=1e-12)
    assert [bool(found["full"][i]) for i in at] == [abs(v) > 1.5 for v in expected]


def test_what_jumps_at_a_tick_is_sampled_as_it_was_before() -> None:
    """By the clock of time, by a when, and by what both lead to."""
    found = run(
        """
  Real step = if time >= 0.25 then 1 + time else 0;
  discrete Real count(start=0, fixed=true);
  Real both = 10*count + step;
  Real s, c, b;
equation
  when sample(0.25, 0.25) then
    count = pre(count) + 1;
  end when;
  when Clock(1, 4) then
    s = sample(step);
    c = sample(count);
    b = sample(both);
  end when;
"""
    )
    assert values_of(found, "s") == pytest.approx([0, 0, 1.5, 1.75, 2])
    assert values_of(found, "c") == [0, 0, 1, 2, 3]
    assert values_of(found, "b") == pytest.approx([0, 0, 11.5, 21.75, 32])


def test_a_subscript_beyond_its_array_ends_the_run_at_its_tick() -> None:
    text = """
model M
  parameter Real a[3] = {1, 2, 4};
  Integer n(start=0);
  Real y;
equation
  when Clock(0.25) then
    n = previous(n) + 1;
    y = a[n];
  end when;
end M;
"""
    with pytest.raises(planarc.PlanarcError, match=r"t = 0\.75 s.*subscript 4 is outside"):
        planarc.load(text).simulate(1)
    assert planarc.load(text).simulate(0.6)["y"][-1] == 4
