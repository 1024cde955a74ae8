"""Impossible parameters are refused with a message that says what to change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from planarc.core.diagnostic import PlanarcError

HANGING = """
equation
  connect(world.frame_b, joint.frame_a);
  connect(joint.frame_b, load.frame_a);
"""
BODY, BALL = "Parts.Body load", "Parts.PointMass load"
FREE = f"{BALL}(m=1, fixAngle=true, r(start={{1, 0}}))"


def refusal(run: Callable[..., Any], text: str) -> str:
    """What a model says that stops at its start, or finds none because of its parameters."""
    try:
        result = run(text)
    except PlanarcError as problem:
        return problem.diagnostics[-1].message
    assert result.ended is not None
    assert result.time.tolist() == [0.0]
    return str(result.ended.message)


@pytest.mark.parametrize(
    ("joint", "load", "message"),
    [
        ("Joints.Revolute joint", f"{BODY}(m=-1)", "mass m of a body is negative"),
        ("Joints.Revolute joint", f"{BODY}(m=1, I=-1)", "inertia I of a body is negative"),
        ("Joints.Prismatic joint", f"{BALL}(m=-1)", "mass m of a point mass is negative"),
        ("Joints.Prismatic joint(n={0, 0})", f"{BODY}(m=1)", "axis n of a slide has length zero"),
        ("Forces.Spring joint(c=-1)", FREE, "stiffness c"),
        ("Forces.Damper joint(d=-1)", FREE, "damping d"),
        ("Forces.Spring joint(c=1)", FREE.replace("1, 0", "0, 0"), "ends of a line force"),
        ("Forces.SpringDamperSeries joint(c=1, d=0)", FREE, "damping d of a damper in series"),
        ("Forces.LineForceWithMass joint(m=-1)", FREE, "mass m of a line force"),
        ("Forces.LineForceWithTwoMasses joint(m_a=-1, m_b=1)", FREE, "a mass of a line force"),
        ("Joints.Revolute joint", "Parts.BodyBox load(r={1, 0}, density=-1)", "density of a box"),
        ("Joints.Revolute joint", "Parts.BodyBox load(r={1, 0}, width=-1)", "a side of a box"),
        (
            "Joints.Revolute joint",
            "Parts.BodyBox load(r={1, 0}, width=0.1, innerWidth=0.2)",
            "hole of a box is larger",
        ),
        (
            "Joints.Revolute joint",
            "Parts.BodyCylinder load(r={1, 0}, density=-1)",
            "density of a cylinder",
        ),
        (
            "Joints.Revolute joint",
            "Parts.BodyCylinder load(r={1, 0}, diameter=0.1, innerDiameter=0.2)",
            "bore of a cylinder is wider",
        ),
    ],
)
def test_an_impossible_parameter_stops_the_run(
    run: Callable[..., Any], joint: str, load: str, message: str
) -> None:
    assert message in refusal(run, f"{joint}; {load};{HANGING}")


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("Parts.RollingWheel part(R=0, m=1)", "radius R of a rolling wheel"),
        ("Curves.StraightLine part(s_min=1, s_max=1, r_0={0, 0}, phi=0)", "no length"),
        ("Curves.Circle part(R=0, r_0={0, 0}, phi=0)", "radius R of a contact circle"),
        ("Curves.Ellipse part(a=0, r_0={0, 0}, phi=0)", "axis of an ellipse"),
        ("Curves.SinusEllipse part(A=1, r_0={0, 0}, phi=0)", "waves of a sinus ellipse"),
        ("Curves.Polar part(R=0, r_0={0, 0}, phi=0)", "radius R of a polar curve"),
    ],
)
def test_an_impossible_shape_stops_the_run(
    run: Callable[..., Any], part: str, message: str
) -> None:
    assert message in refusal(run, f"{part};")


def test_a_direction_of_gravity_has_a_length(run: Callable[..., Any]) -> None:
    result = run("Parts.Body stone(m=1, enforceStates=true);", world="n={0, 0}")
    assert result.ended is not None
    assert "direction n of gravity has length zero" in result.ended.message


def test_a_model_without_a_world_gets_one_and_a_warning() -> None:
    from planarc.compiler import compile_model
    from planarc.request.request import Request

    text = "model Test PlanarMultiBody.Parts.Body stone(m=1, enforceStates=true); end Test;"
    (warning,) = compile_model(Request(text=text)).warnings
    assert "`inner PlanarMultiBody.World world`" in warning.message
