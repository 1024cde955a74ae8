"""Impossible parameters are refused with a message that says what to change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

HANGING = """
equation
  connect(world.frame_b, joint.frame_a);
  connect(joint.frame_b, load.frame_a);
"""
BODY, BALL = "Parts.Body load", "Parts.PointMass load"
FREE = f"{BALL}(m=1, fixAngle=true, r(start={{1, 0}}))"


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
    ],
)
def test_an_impossible_parameter_stops_the_run(
    run: Callable[..., Any], joint: str, load: str, message: str
) -> None:
    result = run(f"{joint}; {load};{HANGING}")
    assert result.ended is not None
    assert message in result.ended.message
    assert result.time.tolist() == [0.0]


def test_a_direction_of_gravity_has_a_length(run: Callable[..., Any]) -> None:
    result = run("Parts.Body stone(m=1, enforceStates=true);", world="n={0, 0}")
    assert result.ended is not None
    assert "direction n of gravity has length zero" in result.ended.message


def test_a_model_without_a_world_gets_one_and_a_warning() -> None:
    from planarc.compiler import compile_model
    from planarc.request import Request

    text = "model Test PlanarMultiBody.Parts.Body stone(m=1, enforceStates=true); end Test;"
    (warning,) = compile_model(Request(text=text)).warnings
    assert "`inner PlanarMultiBody.World world`" in warning.message
