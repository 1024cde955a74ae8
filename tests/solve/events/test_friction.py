"""Friction that slides, sticks and breaks away: relations in algebraic loops find their mode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(text: str, backend: Backend, stop: float, intervals: int = 400) -> Any:
    options = RunOptions(stop=stop, intervals=intervals, tolerance=1e-8, backend=backend)
    result = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    assert result.ended is None
    return result


BRAKED = """
model M
  import Modelica.Mechanics.Rotational;
  Rotational.Components.Inertia rotor(J=0.5, phi(start=0, fixed=true), w(start={w}, fixed=true));
  Rotational.Components.BearingFriction bearing(tau_pos=[0, 2], peak=1.5);
  Rotational.Sources.Torque drive;
equation
  drive.tau = {tau};
  connect(drive.flange, rotor.flange_a);
  connect(rotor.flange_b, bearing.flange_a);
end M;
"""


@pytest.mark.parametrize("w", [1.0, -1.0])
def test_a_rotor_comes_to_rest_and_stays(w: float, backend: Backend) -> None:
    result = run(BRAKED.format(w=w, tau="0"), backend, stop=1.0)
    rest = 0.5 * abs(w) / 2  # J*w/tau
    expected = np.sign(w) * np.maximum(abs(w) - 4 * result.time, 0.0)
    assert result["rotor.w"] == pytest.approx(expected, abs=1e-6)
    late = result.time > rest + 1e-6
    assert np.all(np.abs(result["rotor.w"][late]) < 1e-9)


def test_a_swinging_torque_sticks_and_breaks_away_on_both_sides(backend: Backend) -> None:
    result = run(BRAKED.format(w=0, tau="4*sin(time)"), backend, stop=12.0, intervals=4000)
    t, w, torque = result.time, result["rotor.w"], 4 * np.sin(result.time)
    stuck = np.abs(w) < 1e-7
    # It breaks away at the peak of the friction and slides against its smaller value.
    assert t[~stuck][0] == pytest.approx(np.arcsin(3 / 4), abs=0.05)
    assert np.all(np.abs(torque[stuck]) < 3 + 0.1)
    assert w.max() > 0.5
    assert w.min() < -0.5
    # What the drive gives is kept as motion or lost by sliding at 2 N.m.
    given = np.trapezoid(torque * w, t)
    lost = np.trapezoid(2 * np.abs(w), t)
    assert 0.25 * w[-1] ** 2 == pytest.approx(given - lost, abs=2e-3)


def test_two_brakes_on_one_shaft_chase_each_other_to_rest(backend: Backend) -> None:
    result = run(
        """
model M
  import Modelica.Mechanics.Rotational;
  Rotational.Components.Inertia a(J=1, phi(fixed=true), w(start=2, fixed=true));
  Rotational.Components.Inertia b(J=2, phi(fixed=true), w(start=-1, fixed=true));
  Rotational.Components.BearingFriction left(tau_pos=[0, 1]);
  Rotational.Components.BearingFriction right(tau_pos=[0, 3]);
  Rotational.Components.Spring spring(c=1);
equation
  connect(left.flange_b, a.flange_a);
  connect(a.flange_b, spring.flange_a);
  connect(spring.flange_b, b.flange_a);
  connect(b.flange_b, right.flange_a);
end M;
""",
        backend,
        stop=10.0,
    )
    assert abs(result["a.w"][-1]) < 1e-9
    assert abs(result["b.w"][-1]) < 1e-9
    # At rest the spring holds less than what either bearing can.
    assert abs(result["spring.tau"][-1]) <= 1.0 + 1e-9


def test_rounding_errors_of_what_stands_still_make_no_events(backend: Backend) -> None:
    """Two equal motions, computed differently: their distance is nothing but rounding."""
    result = run(
        """
model M
  Real a(start = 0, fixed = true), b(start = 0, fixed = true);
  Real gap = a - b + (if time < 1 then 0.1 else 0);
  Integer count(start = 0, fixed = true);
equation
  der(a) = sin(7*time) + 0.1*cos(a);
  der(b) = (3*sin(7*time) + 0.3*cos(b))/3.0;
  when gap > 0 then
    count = pre(count) + 1;
  end when;
end M;
""",
        backend,
        stop=20.0,
    )
    assert result["count"][-1] == 0
    assert result.statistics.events == 1


STEADY = """
model Held "A drive in steady state, held by friction: two filters, a spring, a bearing"
  import Modelica.Mechanics.Rotational.Components.*;
  Inertia motor(J=0.7), load(J=1.9);
  SpringDamper shaft(c=830, d=2.3);
  BearingFriction bearing(tau_pos=[0, 4; 10, 5]);
  Modelica.Mechanics.Rotational.Sources.Torque drive;
  Modelica.Mechanics.Rotational.Sources.ConstantTorque weight(tau_constant=-1.3);
  Real i, u;
equation
  0.03*der(i) = 0.9 - i - 0.37*motor.w + 0.11*u;
  0.7*der(u) = 0.41*i - u - 0.23*load.w + 0.05*load.phi;
  drive.tau = 2.7*i;
  connect(drive.flange, motor.flange_a);
  connect(motor.flange_b, shaft.flange_a);
  connect(shaft.flange_b, bearing.flange_a);
  connect(bearing.flange_b, load.flange_a);
  connect(weight.flange, load.flange_b);
initial equation
  der(i) = 0;
  der(u) = 0;
  motor.w - 0.3*load.w = 0;
  motor.w + load.w = 0;
  der(motor.w) = 0;
end Held;
"""


def test_what_starts_at_rest_but_for_rounding_sticks(backend: Backend) -> None:
    """The speeds are solved for with the rest, which leaves 1e-24 of them."""
    result = run(STEADY, backend, stop=0.5)
    assert result["load.w"][0] == result["motor.w"][0] == 0.0
    assert not result["bearing.mode"].any()
    assert result["i"][0] > 0.9
