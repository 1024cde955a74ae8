"""A limiter that is at its limit nearly all the while is told, and none that is there at times."""

from __future__ import annotations

import pytest

import planarc

SIGNAL = """model M
  Modelica.Blocks.Sources.Sine sine(amplitude=A, f=1, offset=OFFSET);
  Modelica.Blocks.Nonlinear.Limiter limiter(uMax=1, uMin=LEAST);
equation
  connect(sine.y, limiter.u);
end M;
"""


def told(
    amplitude: float, offset: float = 0.0, least: float = -1.0, stop: float = 2.0
) -> list[str]:
    text = SIGNAL.replace("OFFSET", repr(offset)).replace("LEAST", repr(least))
    warnings = planarc.load(text.replace("A,", f"{amplitude},")).simulate(stop).warnings
    return [w.message for w in warnings if w.code == "R454"]


def test_the_share_is_that_of_the_closed_form() -> None:
    """|10*sin| is above 1 but for 4*asin(0.1) of each turn, 6.4 % of it."""
    (message,) = told(10.0)
    assert message == "`limiter` is at its limit `uMax` or `uMin` for 94% of the run"


def test_a_single_limit_is_named_alone() -> None:
    (message,) = told(2.0, offset=2.5, least=-9.0)
    assert message.startswith("`limiter` is at its limit `uMax` for 7")


@pytest.mark.parametrize("values", [(1.2,), (0.5,), (0.1, 5.0)])
def test_what_is_there_at_times_or_always_is_not_told(values: tuple[float, ...]) -> None:
    """A signal that is constant behind its limiter was hardly to be limited."""
    assert told(*values) == []


def test_a_run_of_no_time_says_nothing() -> None:
    assert told(10.0, stop=0.0) == []


SERVO = """model Servo
  import Modelica.Mechanics.Rotational.*;
  Components.Inertia load(J=1, phi(start=0.1, fixed=true), w(fixed=true));
  Sources.Torque motor;
  Components.IdealGear gear(ratio=RATIO);
  Sensors.AngleSensor angle;
  Modelica.Blocks.Continuous.LimPID pid(k=1e3, yMax=0.01,
    controllerType=Modelica.Blocks.Types.SimpleController.P);
  Modelica.Blocks.Sources.Constant goal(k=GOAL);
equation
  connect(goal.y, pid.u_s);
  connect(angle.phi, pid.u_m);
  connect(pid.y, motor.tau);
  connect(motor.flange, gear.flange_a);
  connect(gear.flange_b, load.flange_a);
  connect(angle.flange, load.flange_b);
end Servo;
"""


def of_servo(ratio: float, goal: float, stop: float) -> list[tuple[str, str]]:
    text = SERVO.replace("RATIO", repr(ratio)).replace("GOAL", repr(goal))
    warnings = planarc.load(text).simulate(stop).warnings
    return [(w.severity.value, w.message) for w in warnings if w.code == "R454"]


def test_a_controller_whose_loop_has_the_wrong_sign_is_warned_of() -> None:
    """Its torque is that of the gear all the while: phi = 0.1 + ratio*yMax*t^2/2."""
    ((severity, message),) = of_servo(-50.0, 0.2, 10.0)
    assert severity == "warning"
    assert message.startswith("`pid` is at its limit `yMax` for 100% of the run, and what it mea")
    assert message.endswith(f"to {0.1 - 50 * 0.01 * 10**2 / 2:.4g}")


def test_a_controller_on_its_way_has_a_note() -> None:
    ((severity, message),) = of_servo(50.0, 100.0, 10.0)
    assert (severity, message) == ("note", "`pid` is at its limit `yMax` for 100% of the run")
