"""Inverse dynamics against closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc import Model, PlanarcError, UsageError, load
from planarc.api.result import RunStopped

G = 9.81


def _q(t: Any) -> Any:
    return 0.2 + 0.6 * np.sin(3 * t)


def _v(t: Any) -> Any:
    return 1.8 * np.cos(3 * t)


def _a(t: Any) -> Any:
    return -5.4 * np.sin(3 * t)


TABLE = np.linspace(-0.2, 2.2, 1000)
MOTIONS: list[tuple[str, Any, float]] = [
    ("text", "0.2 + 0.6*sin(3*time)", 1e-10),
    ("function", _q, 1e-6),
    ("with derivatives", (_q, _v, _a), 1e-10),
    ("table", (TABLE, _q(TABLE)), 1e-3),
]


@pytest.mark.parametrize("case", [m[1:] for m in MOTIONS], ids=[m[0] for m in MOTIONS])
def test_the_torque_of_a_pendulum(pendulum: Model, case: tuple[Any, float]) -> None:
    motion, accuracy = case
    driven = pendulum.drive("hinge.phi", motion, stop_time=2)
    t = driven.time
    exact = (0.3 + 2 * 0.49) * _a(t) + 2 * G * 0.7 * np.cos(_q(t))
    assert np.max(np.abs(driven.effort() - exact)) < accuracy
    assert np.max(np.abs(driven["hinge.phi"] - _q(t))) < accuracy
    # The bearing carries the bob: m*(a - g), in world.
    along = -0.7 * (_a(t) * np.sin(_q(t)) + _v(t) ** 2 * np.cos(_q(t)))
    assert np.max(np.abs(driven["hinge.frame_a.f[1]"] - 2 * along)) < accuracy
    assert driven.result.statistics.solver == "none"
    assert not [n for n in driven.result.names if n.startswith("planarc")]


def test_the_torque_of_a_parallelogram(parallelogram: Model) -> None:
    driven = parallelogram.drive("A.phi", "-1 + 0.4*sin(2*time)", stop_time=3)
    t = driven.time
    phi, z = -1 + 0.4 * np.sin(2 * t), -1.6 * np.sin(2 * t)
    mass = 0.1 + 0.25**2 + 0.3 + 3 * 0.25**2 + 2 * 0.5**2
    exact = mass * z + G * np.cos(phi) * (0.25 + 3 * 0.25 + 2 * 0.5)
    assert driven.efforts == {"A.phi": "A.tau"}
    assert np.max(np.abs(driven.effort("A.phi") - exact)) < 1e-9


def test_the_torque_of_a_crank_slider_at_constant_speed(slider: Model) -> None:
    # Only the slider has mass: tau*w = m*x'*x'', x = r*cos(phi) + sqrt(L^2 - r^2*sin(phi)^2).
    massless = {"crank.m": 0, "crank.I": 0, "rod.m": 0, "rod.I": 0}
    r, length, m, w = 0.2, 0.7, 3.0, 5.0
    driven = slider.drive(
        "main.phi", lambda t: -1 + w * t, stop_time=2, intervals=400, parameters=massless
    )
    phi = -1 + w * driven.time
    s, c = np.sin(phi), np.cos(phi)
    root = np.sqrt(length**2 - r**2 * s**2)
    first = -r * s - r**2 * s * c / root
    second = -r * c - r**2 * (c**2 - s**2) / root - r**4 * s**2 * c**2 / root**3
    assert np.max(np.abs(driven.effort() - m * w**2 * first * second)) < 1e-6


def test_the_force_on_a_slide(slider: Model) -> None:
    driven = slider.drive("slide.s", "0.75 + 0.05*sin(time)", stop_time=1)
    power = driven.effort() * driven["slide.v"]
    energy = (
        0.5 * (0.01 + 0.01) * driven["main.w"] ** 2
        + 0.5 * 2 * (driven["rod.body.v_CM[1]"] ** 2 + driven["rod.body.v_CM[2]"] ** 2)
        + 0.5 * 0.05 * driven["rod.body.w"] ** 2
        + 0.5 * 3 * driven["slide.v"] ** 2
        + G * (driven["rod.body.r_0CM[2]"] * 2 + driven["crank.body.r_0CM[2]"])
    )
    work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(driven.time))])
    assert driven.efforts == {"slide.s": "slide.f"}
    assert np.max(np.abs(energy - energy[0] - work)) < 1e-4 * np.ptp(energy)


def test_what_is_not_driven_moves_by_itself() -> None:
    double = load("examples/double_pendulum.pmo")
    text = double.drive("shoulder.phi", "0.3*sin(time)", stop_time=2, tolerance=1e-9)
    function = double.drive(
        "shoulder.phi", lambda t: 0.3 * math.sin(t), stop_time=2, tolerance=1e-9
    )
    assert text.result.states[0].states == ("elbow.phi", "elbow.w")
    assert np.max(np.abs(text["elbow.phi"] - function["elbow.phi"])) < 1e-6
    assert np.max(np.abs(text.effort() - function.effort())) < 1e-4
    both = double.drive(
        {"shoulder.phi": "0.3*sin(time)", "elbow.phi": (text.time, text["elbow.phi"])}, stop_time=2
    )
    assert np.max(np.abs(both["elbow.tau"][5:-5])) < 1e-2 * np.max(np.abs(both["shoulder.tau"]))


def test_a_drive_beside_the_one_that_is_there() -> None:
    model = load(
        """
model Damped
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(drivenFlange=true, phi(fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.Body bob(m=1, I=0.5);
  Modelica.Mechanics.Rotational.Components.Damper damper(d=3);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bob.frame_a);
  connect(damper.flange_b, hinge.axis);
  connect(damper.flange_a, hinge.support);
end Damped;
"""
    )
    driven = model.drive("hinge.phi", "sin(time)", stop_time=2)
    t = driven.time
    assert np.max(np.abs(driven.effort() - (3 * np.cos(t) - 0.5 * np.sin(t)))) < 1e-9


WRONG: list[tuple[str, Callable[[Model], Any], str]] = [
    ("name", lambda m: m.drive("hinge.fi", "time"), "no variable"),
    ("velocity", lambda m: m.drive("hinge.w", "time"), "no coordinate of a joint"),
    ("nothing", lambda m: m.drive("hinge.phi"), "takes a number, a function"),
    ("short", lambda m: m.drive("hinge.phi", ([0, 1], [0, 1])), "at least 4 points"),
    ("nan", lambda m: m.drive("hinge.phi", lambda t: math.nan), "no finite number"),
]


@pytest.mark.parametrize("wrong", [w[1:] for w in WRONG], ids=[w[0] for w in WRONG])
def test_a_wrong_motion_is_refused(pendulum: Model, wrong: Any) -> None:
    request, words = wrong
    with pytest.raises(UsageError, match=words):
        request(pendulum)


def test_a_motion_that_cannot_be_is_refused(parallelogram: Model, pendulum: Model) -> None:
    with pytest.raises(PlanarcError, match=r"cannot move with `A\.phi` and `D\.phi` given"):
        parallelogram.drive({"A.phi": "-1 + time", "D.phi": "-1 + time"})
    with pytest.raises(PlanarcError, match="unknown name `foo`"):
        pendulum.drive("hinge.phi", "sin(foo)")


def test_relations_switch_while_a_freedom_is_left() -> None:
    text = """model Two
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute a(phi(start=0.1, fixed=true), w(fixed=true));
  PlanarMultiBody.Joints.Revolute b(phi(fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.BodyShape upper(r={1, 0}, m=1), lower(r={1, 0}, m=1);
  Boolean above = a.phi > 0.05;
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, upper.frame_a);
  connect(upper.frame_b, b.frame_a);
  connect(b.frame_b, lower.frame_a);
end Two;"""
    driven = load(text).drive("b.phi", "0.5*sin(2*time)", stop_time=1)
    away = np.abs(driven["a.phi"] - 0.05) > 1e-6  # not the row before it switches
    assert np.array_equal(driven["above"][away] == 1, driven["a.phi"][away] > 0.05)
    assert {0, 1} == {*driven["above"]}


def test_messages_of_a_motion_name_what_was_given(parallelogram: Model, pendulum: Model) -> None:
    with pytest.raises(PlanarcError) as refused:
        parallelogram.drive({"A.phi": lambda t: -1 + t, "D.phi": lambda t: -1 + t})
    assert "planarcMotion" not in str(refused.value.diagnostics)
    with pytest.raises(PlanarcError) as stopped:
        pendulum.drive("hinge.phi", "sqrt(1 - time)", stop_time=2)
    found = stopped.value.diagnostics[0]
    assert found.span is not None and found.span.source.text == "hinge.phi=sqrt(1 - time)"
    assert found.span.text == "sqrt(1 - time)"


def test_a_pole_of_a_motion_is_told_with_the_motion() -> None:
    double = load("examples/double_pendulum.pmo")
    with pytest.raises(RunStopped) as stopped:
        double.drive("elbow.phi", "sqrt(1 - time)", stop_time=2)
    (found,) = stopped.value.diagnostics
    assert [r.span and r.span.text for r in found.related[:1]] == ["sqrt(1 - time)"]
    assert found.hint is not None and "give `elbow.phi` a motion" in found.hint
