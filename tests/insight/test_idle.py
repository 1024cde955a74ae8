"""Parts that do nothing are warned of, and no others: a false alarm is worse than a missing one."""

from __future__ import annotations

import pytest

from planarc.probe.check import check_model
from planarc.request.request import Request

_ROTATIONAL = "import R = Modelica.Mechanics.Rotational;"
_ROTORS = f"{_ROTATIONAL} R.Components.Inertia a(J=1); R.Components.Inertia b(J=1);"
_PLANAR = (
    "import P = PlanarMultiBody; inner P.World world; P.Joints.Revolute hinge;"
    "P.Parts.BodyShape bar(r={1,0}, m=1);"
)
_HUNG = "connect(world.frame_b, hinge.frame_a); connect(hinge.frame_b, bar.frame_a);"


def idle(parts: str, equations: str) -> list[str]:
    """The messages of S323 about a model."""
    found = check_model(Request(text=f"model M {parts} equation {equations} end M;"))
    return [d.message for d in found.warnings if d.code == "S323"]


@pytest.mark.parametrize(
    ("parts", "equations"),
    [
        pytest.param(
            f"{_ROTORS} R.Components.IdealGear gear(ratio=2); R.Components.Spring s(c=1);",
            "connect(a.flange_b, gear.flange_a); connect(gear.flange_b, b.flange_a);"
            "connect(a.flange_b, s.flange_a); connect(s.flange_b, b.flange_a);",
            id="a spring over a gear",
        ),
        pytest.param(
            f"{_ROTORS} R.Components.Clutch c(fn_max=1); R.Components.Damper d(d=1);"
            "Modelica.Blocks.Sources.Constant one(k=1);",
            "connect(one.y, c.f_normalized); connect(a.flange_b, c.flange_a);"
            "connect(c.flange_b, b.flange_a); connect(a.flange_b, d.flange_a);"
            "connect(d.flange_b, b.flange_a);",
            id="a damper beside a clutch",
        ),
        pytest.param(
            f"{_ROTATIONAL} R.Components.Inertia a(J=1); R.Components.Fixed f;"
            "R.Sources.Position p(exact=true, useSupport=true);"
            "Modelica.Blocks.Sources.Constant angle(k=1);",
            "connect(angle.y, p.phi_ref); connect(p.flange, a.flange_a);"
            "connect(f.flange, p.support);",
            id="a drive that holds a shaft",
        ),
        pytest.param(
            f"{_PLANAR} P.Sensors.RelativeAngle angle; P.Sensors.Distance d;",
            f"{_HUNG} connect(hinge.frame_a, angle.frame_a);"
            "connect(hinge.frame_b, angle.frame_b); connect(world.frame_b, d.frame_a);"
            "connect(bar.frame_b, d.frame_b);",
            id="sensors of an angle and of a length",
        ),
        pytest.param(
            f"{_ROTATIONAL} inner PlanarMultiBody.World world; PlanarMultiBody.Parts.Mounting1D m;"
            "R.Components.Inertia a(J=1); R.Components.Spring s(c=1);",
            "connect(world.frame_b, m.frame_a); connect(m.flange_b, s.flange_a);"
            "connect(s.flange_b, a.flange_a);",
            id="a mount of a shaft on the ground",
        ),
        pytest.param(
            f"{_PLANAR} P.Forces.Torque t; P.Forces.WorldForce f(resolveInFrame="
            "P.Types.ResolveInFrameB.frame_resolve);",
            f"{_HUNG} t.torque = 1; f.force = {{1,0}}; connect(world.frame_b, t.frame_a);"
            "connect(bar.frame_b, t.frame_b); connect(bar.frame_b, f.frame_b);"
            "connect(world.frame_b, f.frame_resolve);",
            id="a torque against the ground, and a force along its axes",
        ),
        pytest.param(
            f"{_PLANAR} P.Forces.Spring s(c=1, s_unstretched=0.5);",
            f"{_HUNG} connect(world.frame_b, s.frame_a); connect(bar.frame_b, s.frame_b);",
            id="a spring from the ground to a bar",
        ),
    ],
)
def test_what_does_something_is_not_warned_of(parts: str, equations: str) -> None:
    assert idle(parts, equations) == []


def test_a_sensor_in_a_connection_is_not_warned_of() -> None:
    text = (
        f"model M {_PLANAR} P.Sensors.CutForce cut; equation "
        "connect(world.frame_b, hinge.frame_a); connect(hinge.frame_b, cut.frame_a);"
        "connect(cut.frame_b, bar.frame_a); end M;"
    )
    assert check_model(Request(text=text)).warnings == ()


def test_axes_of_a_sensor_are_no_end_of_it() -> None:
    text = (
        f"model M {_PLANAR} P.Sensors.RelativePosition s("
        "resolveInFrame=P.Types.ResolveInFrameAB.frame_resolve); equation "
        f"{_HUNG} connect(world.frame_b, s.frame_a); connect(bar.frame_b, s.frame_b); "
        "connect(bar.frame_a, s.frame_resolve); end M;"
    )
    assert check_model(Request(text=text)).warnings == ()


def test_a_wheel_that_rolls_on_the_ground_does_not_float() -> None:
    text = (
        "model M import P = PlanarMultiBody; inner P.World world; P.Parts.Body wheel(m=10);"
        "P.Joints.RollingJoint roll(R=0.3); equation connect(roll.frame_a, wheel.frame_a); end M;"
    )
    assert check_model(Request(text=text)).warnings == ()


def test_a_spring_between_the_ground_and_the_ground_does_nothing() -> None:
    found = idle(
        f"{_PLANAR} P.Parts.Fixed post(r={{1,1}}); P.Forces.Spring s(c=1);",
        f"{_HUNG} connect(world.frame_b, s.frame_a); connect(post.frame_b, s.frame_b);",
    )
    assert found == ["`s` does nothing: both its ends are on the ground"]
