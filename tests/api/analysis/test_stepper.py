"""Runs that go on step by step: exact steps, events, inputs, back and forth."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import planarc

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"
CART = """model Cart "A mass that is pushed"
  input Real f(start=0, unit="N");
  Real x(start=0, fixed=true, unit="m");
  Real v(start=0, fixed=true, unit="m/s");
  Real r[2] = {x, 2*x};
equation
  der(x) = v;
  der(v) = f;
  annotation(experiment(StopTime=10));
end Cart;"""
SAW = """model Saw "Falls back from 1 to 0"
  Real x(start=0, fixed=true);
  discrete Integer n(start=0, fixed=true);
equation
  der(x) = 1;
  when x >= 1 then
    reinit(x, 0);
    n = pre(n) + 1;
  end when;
  annotation(experiment(StopTime=100));
end Saw;"""


@pytest.fixture(scope="module")
def cart() -> planarc.Model:
    return planarc.load(CART)


def test_steps_are_those_of_a_run() -> None:
    model = planarc.load(FOUR_BAR)
    result = model.simulate(1, intervals=100, tolerance=1e-10)
    found = []
    with model.stepper(0.01, stop_time=1, tolerance=1e-10) as s:
        found.append(s["revA.phi", "revD.frame_a.f[1]"])
        while not s.done:
            s.step()
            found.append(s["revA.phi", "revD.frame_a.f[1]"])
    assert s.step_size == 0.01
    wanted = np.column_stack([result["revA.phi"], result["revD.frame_a.f[1]"]])
    assert np.array(found) == pytest.approx(wanted, rel=1e-6, abs=1e-6)


def test_inputs_stand_still_within_a_step(cart: planarc.Model) -> None:
    with cart.stepper(0.1, tolerance=1e-11) as s:
        s["f"] = 2
        assert s.step() == pytest.approx(0.1, abs=1e-15)
        assert s["v"] == pytest.approx(0.2)
        s["f"] = -2
        s.step()
        assert (s["v"], s["x"]) == pytest.approx((0.0, 0.02), abs=1e-9)
        assert s["r"] == pytest.approx([0.02, 0.04])
        assert s.time == 0.2
        s.step("50ms")
        assert s.time == pytest.approx(0.25)
        s.step()
        assert s.time == pytest.approx(0.35)


def test_a_controller_holds_the_cart(cart: planarc.Model) -> None:
    with cart.stepper(0.02, start={"x": 1}) as s:
        while not s.done:
            s["f"] = -4 * s["x"] - 4 * s["v"]
            s.step()
        assert s.time == 10
        assert s["x"] == pytest.approx(0, abs=1e-5)
        with pytest.raises(planarc.UsageError, match=r"C216.*the run is over at t = 10 s"):
            s.step()


@pytest.mark.parametrize("solver", ["auto", "lsoda"])
def test_events_within_a_step_are_exact(solver: str) -> None:
    with planarc.load(SAW).stepper(0.3, solver=solver) as s:
        for k in range(1, 40):
            s.step()
            x = 0.3 * k
            if abs(x - round(x)) > 1e-6:
                assert s["x"] == pytest.approx(x % 1, abs=1e-8)
                assert s["n"] == math.floor(x)


def test_an_input_switches_relations_at_once() -> None:
    text = """model Relay input Real u(start=0); Real x(start=0, fixed=true);
    Integer k(start=0, fixed=true); equation der(x) = if u > 0.5 then 1 else 0;
    when u > 0.5 then k = pre(k) + 1; end when;
    annotation(experiment(StopTime=10)); end Relay;"""
    with planarc.load(text).stepper(1) as s:
        for u, x, k in ((0, 0, 0), (1, 1, 1), (1, 2, 1), (0, 2, 1), (2, 3, 2)):
            s["u"] = u
            s.step()
            assert (s["x"], s["k"]) == pytest.approx((x, k), abs=1e-9)


def test_a_run_is_begun_again_and_taken_back(cart: planarc.Model) -> None:
    with cart.stepper(0.1, start={"x": 1}, tolerance=1e-11) as s:
        s["f"] = 1
        s.step()
        kept = s.save()
        after = [s.step() and s["x"] for _ in range(5)]
        s.restore(kept)
        assert s.time == pytest.approx(0.1)
        assert [s.step() and s["x"] for _ in range(5)] == pytest.approx(after, rel=1e-9)
        s.reset()
        assert (s.time, s["x"], s["v"], s["f"]) == (0, 1, 0, 0)
        s.step()
        assert s["x"] == pytest.approx(1)


def test_events_are_taken_back_too() -> None:
    with planarc.load(SAW).stepper(0.3) as s:
        for _ in range(2):
            for _ in range(300):
                s.step()
            assert s["n"] == 89 or s["n"] == 90
            s.reset()
            assert (s["n"], s["x"], s.time) == (0, 0, 0)


@pytest.mark.parametrize("way", ["reset", "restore"])
def test_what_switches_once_in_each_episode_does_not_chatter(way: str) -> None:
    text = """model Pushed Real x(start=0, fixed=true), v(start=0, fixed=true); equation
    der(x) = v; der(v) = -x + (if x > 0.1 then 4 else 1); annotation(experiment(StopTime=3));
    end Pushed;"""
    with planarc.load(text).stepper(0.01) as s:
        first, ends = s.save(), []
        for _ in range(6):
            for _ in range(60):
                s.step()
            ends.append(s["x"])
            s.reset() if way == "reset" else s.restore(first)
    assert ends == pytest.approx([ends[0]] * 6)


def test_the_model_may_end_the_run() -> None:
    text = """model Fuse Real x(start=0, fixed=true); equation der(x) = 1;
    when x > 0.25 then terminate("enough"); end when;
    annotation(experiment(StopTime=10)); end Fuse;"""
    with planarc.load(text).stepper(0.1) as s:
        while not s.done:
            s.step()
        assert s.time == pytest.approx(0.25)
        assert s.ended is not None
        assert "enough" in s.ended.message
        s.reset()
        assert not s.done


def test_a_failed_assertion_is_an_error_of_the_run() -> None:
    text = """model Weak Real x(start=0, fixed=true); equation der(x) = 1;
    assert(x < 0.25, "too far"); annotation(experiment(StopTime=10)); end Weak;"""
    with planarc.load(text).stepper(0.1) as s:
        with pytest.raises(planarc.RunError, match="too far"):
            for _ in range(4):
                s.step()
        s.reset()
        s.step()


def test_wrong_requests_are_told(cart: planarc.Model) -> None:
    for step in (0, -1, "5m"):
        with pytest.raises(planarc.UsageError, match=r"C216|C115"):
            cart.stepper(step)  # type: ignore[arg-type]
    s = cart.stepper()
    assert "steps of 0.01 s" in repr(s)
    with pytest.raises(planarc.UnknownName, match="no input `g`"):
        s["g"] = 1
    with pytest.raises(planarc.UnknownName, match="no variable `y`"):
        s["y"]
    for key in (3, ("x", "y")):
        with pytest.raises(planarc.UnknownName, match="no variable"):
            s[key]  # type: ignore[index]
    for value in (math.nan, "1e400N"):
        with pytest.raises(planarc.UsageError, match="C202"):
            s["f"] = value  # type: ignore[assignment]
    with pytest.raises(planarc.UsageError, match=r"C202.*Snapshot"):
        s.restore(3)  # type: ignore[arg-type]
    s.close()
    with pytest.raises(planarc.UsageError, match="the stepper is closed"):
        s.step()


def test_a_delay_belongs_to_the_state() -> None:
    text = """model Late Real x = time; Real y = delay(x, 0.5);
    annotation(experiment(StopTime=10)); end Late;"""
    with planarc.load(text).stepper(0.25) as s:
        for _ in range(4):
            s.step()
        assert s["y"] == pytest.approx(0.5, abs=1e-6)
        with pytest.raises(planarc.PlanarcError, match="R474"):
            s.save()
        s.reset()
        assert s.time == 0
