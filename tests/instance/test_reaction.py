"""The iteration of events in machine code does what Python's does: both run the same models."""

from __future__ import annotations

import math
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import planarc
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.instance.reaction import texts_of
from planarc.instance.reactor import Reactor
from planarc.ir.kernel import Reacted
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.solve.kernels import load
from planarc.solve.simulate import simulate

EXAMPLES = Path(__file__).parents[2] / "examples"

BALL = """
model Ball
  Real h(start=1, fixed=true), v(start=0, fixed=true);
  discrete Integer hits(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h <= 0 then
    reinit(v, -0.7*pre(v));
    hits = pre(hits) + 1;
  end when;
  annotation(experiment(StopTime=2));
end Ball;
"""
SAMPLED = """
model Sampled
  Real x(start=0, fixed=true);
  discrete Real u(start=0, fixed=true), last(start=0, fixed=true);
equation
  der(x) = u - x;
  when sample(0, 0.1) then
    last = pre(u);
    u = 0.5*pre(u) + (if x < 0.5 then 1 else -0.2);
  end when;
  annotation(experiment(StopTime=2));
end Sampled;
"""
FRICTION = """
model Friction
  Real x(start=0, fixed=true), v(start=1, fixed=true), f;
  Boolean stuck(start=false, fixed=true);
equation
  der(x) = v;
  der(v) = if stuck then 0 else f - (if v > 0 then 2 else -2);
  f = 3*sin(2*time);
  stuck = abs(f) < 2.2 and (pre(stuck) or abs(v) < 1e-3);
  when stuck then
    reinit(v, 0);
  end when;
  annotation(experiment(StopTime=8));
end Friction;
"""
DELAYED = """
model Delayed
  Real x(start=1, fixed=true), y;
  Boolean high(start=false);
equation
  y = delay(x, 0.3);
  der(x) = -x + (if high then 1 else -1);
  high = y < 0.2 or (pre(high) and y < 0.5);
  annotation(experiment(StopTime=5));
end Delayed;
"""
ENDS = """
model Ends
  Real x(start=0, fixed=true);
equation
  der(x) = 1;
  when x > 0.5 then
    {action}
  end when;
  annotation(experiment(StopTime=1));
end Ends;
"""
#: A loop of numbers at an instant, which passes alone do not bring to rest.
LOOP = """
model Loop
  Real x(start=0, fixed=true);
  discrete Real a(start=0, fixed=true);
  Real b;
equation
  der(x) = a;
  b = 2*a + time;
  when sample(0.1, 0.1) then
    a = 3*b + 1;
  end when;
  annotation(experiment(StopTime=0.5));
end Loop;
"""


def compiled(text: str) -> Compiled:
    return compile_model(Request(None, None, text=text))


def of_example(name: str) -> Compiled:
    return compile_model(Request(EXAMPLES / f"{name}.pmo"))


class Count:
    """How many events machine code was asked for, and how many of them it left to Python."""

    asked = left = 0


@contextmanager
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[Count]:
    count, react = Count(), Reactor.react

    def told(self: Reactor, *given: Any) -> Reacted | None:
        found = react(self, *given)
        count.asked += 1
        count.left += found is None
        return found

    with monkeypatch.context() as patch:
        patch.setattr(Reactor, "react", told)
        yield count


def both(model: Compiled, monkeypatch: pytest.MonkeyPatch) -> tuple[Result, Result, Count]:
    """The run with machine code, that without, and what was asked of it."""
    options = RunOptions(backend=Backend.NATIVE)
    with counted(monkeypatch) as count:
        native = simulate(model.program, model.load(), options)
        asked = count.asked
        python = simulate(model.program, load(model.program, model.code), options)
        assert count.asked == asked > 0, "machine code is asked, and by no other run"
    return native, python, count


def equal(one: Result, two: Result) -> bool:
    return (
        one.events == two.events
        and np.array_equal(one.time, two.time)
        and np.array_equal(one.data, two.data, equal_nan=True)
    )


@pytest.mark.parametrize("text", [BALL, SAMPLED, FRICTION, DELAYED])
def test_the_same_numbers(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    native, python, count = both(compiled(text), monkeypatch)
    assert count.asked > 3
    assert count.left == 0
    assert equal(native, python)


@pytest.mark.parametrize("name", ["cam_lift_off", "geneva_drive", "escapement"])
def test_the_same_touches(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One closes at a time: the order of additions is the same, and so are all digits."""
    native, python, count = both(of_example(name), monkeypatch)
    assert len(native.events) > 10
    assert count.left == 0
    assert equal(native, python)


def test_many_touches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers are added in another order where many close at once: what a run tells is the same."""
    native, python, count = both(of_example("gripper"), monkeypatch)
    assert count.left == 0
    assert [e.causes for e in native.events] == [e.causes for e in python.events]
    assert np.allclose(native.time, python.time, rtol=0, atol=1e-9)
    moved = np.ptp(python.data, axis=0)
    far = np.abs(native.data - python.data).max(axis=0)
    assert (far <= 1e-6 * moved + 1e-9).all()


@pytest.mark.parametrize(
    ("action", "code"),
    [
        ('assert(x < 0.2, "too far: " + String(x));', "R430"),
        ('terminate("there");', None),
        ("reinit(x, sqrt(-x));", None),
    ],
)
def test_python_tells_what_ends_a_run(
    action: str, code: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    native, python, count = both(compiled(ENDS.format(action=action)), monkeypatch)
    assert count.left == 1
    assert native.ended is not None
    assert native.ended == python.ended
    if code is not None:
        assert native.ended.code == code
    assert equal(native, python)


def test_python_tells_what_is_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    action = 'assert(x < 0.2, "far", AssertionLevel.warning);'
    native, python, count = both(compiled(ENDS.format(action=action)), monkeypatch)
    assert count.left == 1
    assert [w.message for w in native.warnings] == [w.message for w in python.warnings]
    assert any("far" in w.message for w in native.warnings)


def test_python_closes_loops_of_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    native, python, count = both(compiled(LOOP), monkeypatch)
    assert count.left >= 4
    assert equal(native, python)


def test_where_nothing_switches_there_is_no_code() -> None:
    assert texts_of(of_example("four_bar").program) is None
    assert texts_of(of_example("geneva_drive").program) is not None


def test_equal_texts_for_equal_models() -> None:
    one, two = (texts_of(of_example("dominoes").program) for _ in range(2))
    assert one is not None and two is not None
    assert (one.kind, one.own, one.shared()) == (two.kind, two.own, two.shared())


@st.composite
def switching(draw: st.DrawFn) -> str:
    """A model that switches at random: limits, hysteresis, clocks, jumps, friction."""
    number = st.integers(-20, 20).map(lambda n: n / 10)
    positive = st.integers(1, 15).map(lambda n: n / 10)
    level = draw(number)
    laws = draw(
        st.lists(
            st.sampled_from(
                [
                    "b1 = x > {0} or (pre(b1) and x > {0} - {1});",
                    "b1 = x*y < {0};",
                    "b1 = sin({1}*time) > {0};",
                    "b1 = time > {1} and y < {0};",
                ]
            ),
            min_size=1,
            max_size=1,
        )
    )
    clauses = draw(
        st.lists(
            st.sampled_from(
                [
                    "when b1 then n = pre(n) + 1; reinit(x, pre(x) - {0}); end when;",
                    "when not b1 then n = pre(n) + 1; end when;",
                    "when {{b1, sample({1}, {1})}} then n = pre(n) + 1; reinit(y, {0}); end when;",
                    "when sample(0, {1}) then n = pre(n) + (if x > y then 2 else 1); end when;",
                    "when x > y then n = pre(n) + 1; elsewhen x < y - {1} then n = 0; end when;",
                ]
            ),
            min_size=1,
            max_size=1,
        )
    )
    others = draw(
        st.lists(
            st.sampled_from(
                [
                    "when sample({1}, {1}/2) then u = pre(u)/2 + x; end when;",
                    "when change(b1) then u = x; end when;",
                    "when {{b1, y > {0}}} then u = if b1 then {0} else pre(u) + y; end when;",
                ]
            ),
            min_size=1,
            max_size=1,
        )
    )
    force = draw(
        st.sampled_from(
            [
                "f = if x > {0} then -{1}*(x - {0}) else 0;",
                "f = {1}*sign(u - y) + max(x, {0});",
                "f = min(max(u - x, -{1}), {1}) + floor({1}*time)*{0};",
                "f = smooth(0, abs(x - {0}))*(if b1 then -1 else 1);",
            ]
        )
    )
    body = "\n  ".join(
        text.format(draw(number), draw(positive)) for text in (*laws, *clauses, *others, force)
    )
    return f"""
model Switching
  Real x(start={draw(number)}, fixed=true), y(start={level}, fixed=true), f;
  Boolean b1(start=false);
  discrete Integer n(start=0, fixed=true);
  discrete Real u(start=0, fixed=true);
equation
  der(x) = y;
  der(y) = f - x - {draw(positive)}*y + cos(3*time);
  {body}
  annotation(experiment(StopTime=3));
end Switching;
"""


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(text=switching())
def test_whatever_switches(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        native, python, _ = both(compiled(text), monkeypatch)
    except PlanarcError:
        return  # no start, as either would say
    assert native.ended == python.ended
    assert equal(native, python)


BUFFER = """
model Buffer
  parameter Integer n = 500;
  discrete Real x[n](each start=0, each fixed=true), y[n](each start=1, each fixed=true);
  discrete Real total(start=0, fixed=true);
  discrete Integer k(start=1, fixed=true);
  Real u = {input};
algorithm
  when {{sample(0, 0.01), u < 0.4}} then
    x[k] := u*k;
    y[n + 1 - k] := u - time;
    k := pre(k) + 1;
  elsewhen sample(0.005, 0.1) then
    x[k] := -1;
  end when;
equation
  when sample(0, 0.02) then
    total = sum(x[i]*y[i] for i in 1:5);
  end when;
  annotation(experiment(StopTime=1));
end Buffer;
"""


def test_arrays_are_set_in_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that is set at an index that varies is as many actions as it has elements."""
    model = compiled(BUFFER.format(input="exp(-time)"))
    native, python, count = both(model, monkeypatch)
    assert count.asked > 100
    assert count.left == 0
    assert equal(native, python)
    last = {s.name: native.data[-1, native.stored[s.slot]] for s in model.program.discretes}
    before = [0.01 * i for i in range(92)]  # ln(0.4) lies behind the last of them
    expected = [math.exp(-t) * (i + 1) for i, t in enumerate(before)]
    assert [last[f"x[{i + 1}]"] for i in range(92)] == pytest.approx(expected, rel=1e-6)
    texts = texts_of(model.program)
    assert texts is not None
    short = texts_of(compiled(BUFFER.format(input="exp(-time)").replace("500", "250")).program)
    assert short is not None
    assert texts.own.count("fcmp") == short.own.count("fcmp") < 100, "a loop is code once"


#: From 0.25 s on the value of an element is the root of a negative number.
NEGATIVE = BUFFER.format(input="1").replace("x[k] := u*k", "x[k] := sqrt(0.245 - time)*k")


def test_python_tells_which_element_has_no_value(monkeypatch: pytest.MonkeyPatch) -> None:
    text = NEGATIVE
    native, python, count = both(compiled(text), monkeypatch)
    assert count.left == 1
    assert native.ended is not None
    assert "x[26]" in native.ended.message
    assert native.ended == python.ended
    assert equal(native, python)


def test_python_does_what_would_be_long_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each element is a formula of its own."""
    text = """
model Long
  discrete Real x[60](each start=1, each fixed=true);
  discrete Integer k(start=0, fixed=true);
equation
  when sample(0, 0.5) then
    for i in 1:60 loop
      x[i] = sum(sin(j*time) for j in i:i + 90 + mod(7*i, 60));
    end for;
  end when;
  when sample(0, 0.1) then
    k = pre(k) + 1;
  end when;
  annotation(experiment(StopTime=1));
end Long;
"""
    native, python, count = both(compiled(text), monkeypatch)
    assert 0 < count.left < count.asked
    assert equal(native, python)


def test_a_kernel_goes_with_its_last_owner() -> None:
    """What iterates its events does not hold it: garbage is seldom collected."""
    kernel = compiled(BALL).load()
    reacting = kernel.capabilities.reacting
    assert reacting().reactions is not None
    del reacting
    there = weakref.ref(kernel)
    del kernel
    assert there() is None


def test_an_exported_run_tells_which_element_has_no_value() -> None:
    text = NEGATIVE
    model = planarc.load(text)
    for solver in ("auto", "exported"):
        with pytest.raises(planarc.RunStopped) as caught:
            model.simulate(1.0, solver=solver)
        (found,) = caught.value.diagnostics
        assert found.code == "R421"
        assert "x[26]" in found.message
