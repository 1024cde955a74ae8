"""Laws that every component obeys, in tables: momentum, energy, and equal constructions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]


@dataclass(frozen=True)
class Link:
    """Something between two bodies that float in space."""

    text: str  # declarations
    connections: str = ""  # more than frame_a and frame_b of `link`
    masses: tuple[tuple[float, str, str], ...] = ()  # mass, position and velocity, of its own
    spin: str = "0"  # angular momentum of its own
    stored: str | None = "0"  # potential energy; None: the link takes or gives energy
    start: str = "{0.9, 0.2}"  # of the second body
    free: bool = True  # whether the link leaves the second body all freedom


FLANGES = """
  connect(link.flange_a, inside.flange_a);
  connect(inside.flange_b, link.flange_b);
"""
INSIDE = "Modelica.Mechanics.Translational.Components.Spring inside(c=20, s_rel0=0.8)"

LINKS = {
    "Spring": Link("Forces.Spring link(c=20, s_unstretched=0.5)", stored="10*(link.s - 0.5)^2"),
    "Damper": Link("Forces.Damper link(d=2)", stored=None),
    "SpringDamperParallel": Link(
        "Forces.SpringDamperParallel link(c=20, s_unstretched=0.5, d=2)", stored=None
    ),
    "SpringDamperSeries": Link(
        "Forces.SpringDamperSeries link(c=20, s_unstretched=0.5, d=2)", stored=None
    ),
    "Force": Link("Forces.Force link", "link.force = {1, sin(time)};", stored=None),
    "Force in world": Link(
        "Forces.Force link(resolveInFrame=Types.ResolveInFrameAB.world)",
        "link.force = {1, 2};",
        stored=None,
    ),
    "Torque": Link("Forces.Torque link", "link.torque = 0.3;", stored=None),
    "ForceAndTorque": Link(
        "Forces.ForceAndTorque link", "link.force = {1, 0}; link.torque = 0.2;", stored=None
    ),
    "LineForceWithMass": Link(
        f"Forces.LineForceWithMass link(m=0.3, lengthFraction=0.3); {INSIDE}",
        FLANGES,
        ((0.3, "link.r_mass", "link.v"),),
        stored="10*(link.s - 0.8)^2",
    ),
    "LineForceWithTwoMasses": Link(
        f"Forces.LineForceWithTwoMasses link(m_a=0.3, m_b=0.4, L_a=0.1, L_b=0.2); {INSIDE}",
        FLANGES,
        ((0.3, "link.r_CM_a", "link.v_CM_a"), (0.4, "link.r_CM_b", "link.v_CM_b")),
        stored="10*(link.s - 0.8)^2",
    ),
    "FreeMotion": Link("Joints.FreeMotion link(stateSelect=StateSelect.default)"),
    "Revolute": Link("Joints.Revolute link(w(start=2))", start="{0, 0}", free=False),
    "Prismatic": Link("Joints.Prismatic link(n={1, 1}, v(start=1))", free=False),
    "JointRR": Link("Joints.JointRR link(L=1)", free=False),
    "JointRRWithMass": Link(
        "Joints.JointRRWithMass link(L=1, m=0.4, lengthFraction=0.3)",
        masses=((0.4, "link.r_mass", "link.v"),),
        free=False,
    ),
    "CurveCurveJoint": Link(
        "Joints.CurveCurveJoint link(redeclare Curves.Ellipse curve1(a=0.6, b=0.4),"
        " curve2(R=0.4), s1(start=0.8), s2(start=1.9))",
        free=False,
    ),
    "Mounting1D and Rotor1D": Link(
        """
  Forces.Spring link(c=0);
  Parts.Mounting1D mounting;
  Parts.Rotor1D rotor(J=0.05, phi(fixed=true), w(start=3, fixed=true));
  Modelica.Mechanics.Rotational.Sources.Torque motor(useSupport=true)""",
        """
  connect(one.frame_a, mounting.frame_a);
  connect(one.frame_a, rotor.frame_a);
  connect(mounting.flange_b, motor.support);
  connect(motor.flange, rotor.flange_a);
  motor.tau = 0.4;
""",
        spin="0.05*rotor.w",
        stored=None,
    ),
    "GearConstraint": Link(
        """
  Joints.GearConstraint link(ratio=-2, r_b={1, 0.2}, w_b(start=3));
  Parts.Body carrier(m=0.7, I=0.06, r_CM={0.1, 0})""",
        "connect(carrier.frame_a, link.bearing);",
        ((0.7, "carrier.r_0CM", "carrier.v_CM"),),
        spin="0.06*carrier.w",
        free=False,
    ),
}


@pytest.mark.parametrize("name", LINKS)
def test_what_a_link_does_to_one_body_it_undoes_on_the_other(run: Run, name: str) -> None:
    """Momentum and angular momentum of a free system stay, and energy where it must."""
    link = LINKS[name]
    masses = (
        (1.5, "one.r_0CM", "one.v_CM"),
        (2.5, "two.r_0CM", "two.v_CM"),
        *link.masses,
    )
    second = "each fixed=true" if link.free else ""
    p = " + ".join(f"{m}*{v}" for m, _, v in masses)
    turn = " + ".join(f"{m}*Frames.cross({r}, {v})" for m, r, v in masses)
    kinetic = " + ".join(f"{m / 2}*({v}*{v})" for m, _, v in masses)
    more = "0.03*carrier.w^2 + " if "carrier" in link.text else ""
    result = run(
        f"""
  Parts.Body one(m=1.5, I=0.2, r_CM={{0.1, 0.05}}, enforceStates=true,
    r(each fixed=true), v(start={{0.3, -0.2}}, each fixed=true),
    phi(start=0.1, fixed=true), w(start=0.7, fixed=true));
  Parts.Body two(m=2.5, I=0.3, r_CM={{0, 0.1}}, enforceStates={str(link.free).lower()},
    r(start={link.start}{", " + second if second else ""}),
    v(start={{0, 0.4}}{", " + second if second else ""}));
  {link.text};
  Real p[2] = {p};
  Real L = {turn} + 0.2*one.w + 0.3*two.w + {link.spin};
  Real E = {more}{kinetic} + 0.1*one.w^2 + 0.15*two.w^2 + {link.stored or "0"};
equation
  connect(one.frame_a, link.frame_a);
  connect(two.frame_a, link.frame_b);
  {link.connections}
""",
        world="g=0",
    )
    assert result.ended is None
    names = ["p[1]", "p[2]", "L"] + (["E"] if link.stored is not None else [])
    for quantity in names:
        values = np.broadcast_to(result[quantity], result.time.shape)
        np.testing.assert_allclose(values, values[0], atol=2e-6, err_msg=quantity)


def test_a_force_from_the_world_is_resolved_where_it_says(run: Run) -> None:
    turned = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    for frame, expected in (
        ("world", np.array([2.0, 3.0])),
        ("frame_b", turned @ [2, 3]),
        ("frame_resolve", turned @ turned @ [2, 3]),
    ):
        resolve = "connect(load.frame_resolve, axes.frame_b);" if frame == "frame_resolve" else ""
        result = run(
            f"""
  Parts.Fixed wall(phi=0.5), axes(phi=1);
  Parts.FixedTranslation rod(r={{2, 0}});
  Forces.WorldForceAndTorque load(resolveInFrame=Types.ResolveInFrameB.{frame});
  Forces.WorldForce nothing;
  Forces.WorldTorque twist;
equation
  connect(wall.frame_b, rod.frame_a);
  connect(rod.frame_b, load.frame_b);
  connect(rod.frame_b, nothing.frame_b);
  connect(rod.frame_b, twist.frame_b);
  load.force = {{2, 3}};
  load.torque = 0.7;
  nothing.force = {{0, 0}};
  twist.torque = 0.2;
  {resolve}
"""
        )
        reaction = [float(result[f"rod.frame_a.{q}"][-1]) for q in ("f[1]", "f[2]", "t")]
        arm = turned @ [2, 0]
        moment = arm[0] * expected[1] - arm[1] * expected[0] + 0.9
        np.testing.assert_allclose(reaction, [*-expected, -moment], atol=1e-12)


def test_turning_the_whole_model_turns_its_motion(run: Run) -> None:
    """Ground, gravity and all: joint coordinates and contact force stay as they are."""

    def cam(angle: float) -> Any:
        return run(
            f"""
  Parts.FixedRotation ground(angle={angle});
  Joints.Revolute hinge(phi(start=0.8, fixed=true), w(fixed=true));
  Parts.Body cam(m=2, I=0.01, r_CM={{0.2, 0.03}});
  Joints.CurveCurveJoint contact(redeclare Curves.Ellipse curve1(a=0.15, b=0.08),
    redeclare Curves.StraightLine curve2, s1(start=0.24));
  Joints.Prismatic slide(n={{0, 1}}, s(start=0.12));
  Parts.Body follower(m=0.5);
equation
  connect(world.frame_b, ground.frame_a);
  connect(ground.frame_b, hinge.frame_a);
  connect(hinge.frame_b, cam.frame_a);
  connect(hinge.frame_b, contact.frame_a);
  connect(ground.frame_b, slide.frame_a);
  connect(slide.frame_b, follower.frame_a);
  connect(slide.frame_b, contact.frame_b);
""",
            world=f"n={{{np.sin(angle)}, {-np.cos(angle)}}}",
        )

    upright, turned = cam(0.0), cam(1.1)
    for name, error in (("hinge.phi", 1e-6), ("slide.s", 1e-6), ("contact.f_N", 2e-5)):
        np.testing.assert_allclose(upright[name], turned[name], atol=error)


# Two constructions of the same thing

CRANK = """
  Parts.Fixed D(r={1, 0});
  Joints.Revolute A(phi(start=1, fixed=true), w(start=0, fixed=true));
  Parts.BodyShape crank(r={0.4, 0}, m=1, I=0.02);
  Parts.Body coupler(r_CM={0.4, 0.1}, m=2, I=0.1);
  Parts.Body rocker(r_CM={0.3, 0}, m=1.5, I=0.08);
"""
TURN = """
  connect(world.frame_b, A.frame_a);
  connect(A.frame_b, crank.frame_a);
"""
SHAPE = """
  Joints.Revolute A(phi(start=0.3, fixed=true), w(fixed=true));
equation
  connect(world.frame_b, A.frame_a);
  connect(A.frame_b, bar.frame_a);
"""
FREE = "r(start={0.3, 0.4}, each fixed=true), v(start={1, 0}, each fixed=true)"

EQUAL: dict[str, tuple[str, str, dict[str, str]]] = {
    "JointRRR and plain joints": (
        CRANK
        + """
  Joints.Assemblies.JointRRR dyad(rRod1_ia={0.9, 0}, rRod2_ib={0.8, 0});
equation"""
        + TURN
        + """
  connect(crank.frame_b, dyad.frame_a);
  connect(D.frame_b, dyad.frame_b);
  connect(dyad.frame_ia, coupler.frame_a);
  connect(dyad.frame_ib, rocker.frame_a);
""",
        CRANK
        + """
  Joints.Revolute B(phi(start=-0.46)), C(phi(start=1.05)), E(phi(start=1.59));
  Parts.FixedTranslation rod1(r={0.9, 0}), rod2(r={0.8, 0});
equation"""
        + TURN
        + """
  connect(crank.frame_b, B.frame_a);
  connect(B.frame_b, rod1.frame_a);
  connect(B.frame_b, coupler.frame_a);
  connect(rod1.frame_b, C.frame_a);
  connect(D.frame_b, E.frame_a);
  connect(E.frame_b, rod2.frame_a);
  connect(E.frame_b, rocker.frame_a);
  connect(rod2.frame_b, C.frame_b);
""",
        {
            "A.phi": "A.phi",
            "A.frame_a.f[1]": "A.frame_a.f[1]",
            "dyad.frame_a.f[2]": "B.frame_a.f[2]",
            "dyad.f_1[1]": "-C.frame_a.f[1]",
            "dyad.frame_b.f[1]": "E.frame_a.f[1]",
        },
    ),
    "JointRRP and plain joints": (
        CRANK
        + """
  Joints.Assemblies.JointRRP dyad(rRod1_ia={0.9, 0}, rRod2_ib={0.1, 0.2}, n_b={1, 0.1});
equation"""
        + TURN
        + """
  connect(crank.frame_b, dyad.frame_a);
  connect(D.frame_b, dyad.frame_b);
  connect(dyad.frame_ia, coupler.frame_a);
  connect(dyad.frame_ib, rocker.frame_a);
""",
        CRANK
        + """
  Joints.Revolute B(phi(start=-1)), C(phi(start=0));
  Joints.Prismatic E(n={1, 0.1}, s(start=0));
  Parts.FixedTranslation rod1(r={0.9, 0}), arm(r={0.1, 0.2});
equation"""
        + TURN
        + """
  connect(crank.frame_b, B.frame_a);
  connect(B.frame_b, rod1.frame_a);
  connect(B.frame_b, coupler.frame_a);
  connect(rod1.frame_b, C.frame_a);
  connect(D.frame_b, E.frame_a);
  connect(E.frame_b, rocker.frame_a);
  connect(E.frame_b, arm.frame_a);
  connect(arm.frame_b, C.frame_b);
""",
        {
            "A.phi": "A.phi",
            "dyad.s": "E.s",
            "dyad.frame_a.f[2]": "B.frame_a.f[2]",
            "dyad.frame_b.t": "E.frame_a.t",
        },
    ),
    "BodyBox and BodyShape": (
        "Parts.BodyBox bar(r={0.6, 0}, width=0.1, height=0.02, innerWidth=0.05,"
        " innerHeight=0.01, density=5000);" + SHAPE,
        f"Parts.BodyShape bar(r={{0.6, 0}}, m=4.5, I={(6 * 0.37 - 1.5 * 0.3625) / 12});" + SHAPE,
        {"A.phi": "A.phi", "A.frame_a.f[2]": "A.frame_a.f[2]"},
    ),
    "BodyCylinder and BodyShape": (
        "Parts.BodyCylinder bar(r={0.6, 0}, diameter=0.1, innerDiameter=0.06);" + SHAPE,
        "Parts.BodyShape bar(r={0.6, 0},"
        f" m={7700 * 0.6 * np.pi * 0.0016},"
        f" I={7700 * 0.6 * np.pi * (0.0025 * (0.03 + 0.01 / 16) - 0.0009 * (0.03 + 0.0036 / 16))}"
        ");" + SHAPE,
        {"A.phi": "A.phi", "A.frame_a.f[2]": "A.frame_a.f[2]"},
    ),
    "FreeMotion and the states of a body": (
        """
  Joints.FreeMotion free(r_rel_a(start={0.3, 0.4}, each fixed=true),
    v_rel_a(start={1, 0}, each fixed=true), phi_rel(fixed=true), w_rel(start=2, fixed=true));
  Parts.Body body(m=1, r_CM={0.2, 0});
equation
  connect(world.frame_b, free.frame_a);
  connect(free.frame_b, body.frame_a);
""",
        f"Parts.Body body(m=1, r_CM={{0.2, 0}}, enforceStates=true, {FREE}, phi(fixed=true),"
        " w(start=2, fixed=true));",
        {"free.r_rel_a[2]": "body.r[2]", "free.phi_rel": "body.phi"},
    ),
    "Spring between flanges and between frames": (
        f"""
  Parts.PointMass mass(m=1, fixAngle=true, {FREE});
  Forces.LineForceWithMass line;
  Modelica.Mechanics.Translational.Components.SpringDamper inside(c=30, d=0.5, s_rel0=0.2);
equation
  connect(world.frame_b, line.frame_a);
  connect(line.frame_b, mass.frame_a);
  connect(line.flange_a, inside.flange_a);
  connect(inside.flange_b, line.flange_b);
""",
        f"""
  Parts.PointMass mass(m=1, fixAngle=true, {FREE});
  Forces.SpringDamperParallel line(c=30, d=0.5, s_unstretched=0.2);
equation
  connect(world.frame_b, line.frame_a);
  connect(line.frame_b, mass.frame_a);
""",
        {"mass.r[1]": "mass.r[1]", "inside.f": "line.f", "line.frame_a.f[1]": "line.frame_a.f[1]"},
    ),
    "RollingWheel and its parts": (
        """
  Parts.RollingWheel wheel(R=0.3, m=2, I=0.07, rolling(x(fixed=true), v(start=1, fixed=true)));
  Forces.WorldTorque brake;
equation
  connect(brake.frame_b, wheel.frame_a);
  brake.torque = 0.2;
""",
        """
  Joints.RollingJoint rolling(R=0.3, x(fixed=true), v(start=1, fixed=true));
  Parts.Body disc(m=2, I=0.07);
  Forces.WorldTorque brake;
equation
  connect(rolling.frame_a, disc.frame_a);
  connect(brake.frame_b, disc.frame_a);
  brake.torque = 0.2;
""",
        {"wheel.rolling.x": "rolling.x", "wheel.rolling.f_t": "rolling.f_t"},
    ),
    "Discs in contact and a rod between their centres": (
        """
  Joints.CurveCurveJoint link(curve1(R=0.5), curve2(R=0.2), s1(start=1.4), s2(start=1.2));
  Parts.Body disc(m=1, I=0.01, r_CM={0.05, 0}, r(start={0.2, 0.67}, fixed={true, false}),
    v(fixed={true, false}), phi(fixed=true), w(start=1, fixed=true));
equation
  connect(world.frame_b, link.frame_a);
  connect(link.frame_b, disc.frame_a);
""",
        """
  Joints.JointRR link(L=0.7);
  Parts.Body disc(m=1, I=0.01, r_CM={0.05, 0}, r(start={0.2, 0.67}, fixed={true, false}),
    v(fixed={true, false}), phi(fixed=true), w(start=1, fixed=true));
equation
  connect(world.frame_b, link.frame_a);
  connect(link.frame_b, disc.frame_a);
""",
        {"disc.r[1]": "disc.r[1]", "disc.phi": "disc.phi", "link.f_N": "link.frod"},
    ),
}


@pytest.mark.parametrize("name", EQUAL)
def test_two_constructions_move_alike(run: Run, name: str) -> None:
    one, other, pairs = EQUAL[name]
    first, second = run(one), run(other)
    assert first.ended is None and second.ended is None
    for a, b in pairs.items():
        expected = -second[b[1:]] if b.startswith("-") else second[b]
        scale = max(1.0, float(np.max(np.abs(expected))))
        np.testing.assert_allclose(first[a], expected, atol=2e-6 * scale, err_msg=a)


# Closed forms


def test_a_wheel_rolls_up_to_speed(run: Run) -> None:
    """A force F at the centre of a rolling disc: a = F/(m + I/R^2) = 2*F/(3*m)."""
    result = run(
        """
  Parts.RollingWheel wheel(R=0.3, m=2,
    rolling(x(start=1, fixed=true), v(start=-1, fixed=true)));
  Forces.WorldForce push;
equation
  connect(push.frame_b, wheel.frame_a);
  push.force = {6, 0};
"""
    )
    t = result.time
    np.testing.assert_allclose(result["wheel.rolling.x"], 1 - t + t**2, atol=1e-8)
    np.testing.assert_allclose(result["wheel.frame_a.phi"], -result["wheel.rolling.x"] / 0.3)
    np.testing.assert_allclose(result["wheel.rolling.f_t"], -2, atol=1e-9)
    np.testing.assert_allclose(result["wheel.rolling.f_n"], 2 * 9.81, atol=1e-9)


def test_a_stone_falls_through_air(run: Run) -> None:
    """v = v_end*tanh(g*t/v_end), v_end = sqrt(m*g/d)."""
    result = run(
        """
  Parts.PointMass stone(m=2, fixAngle=true);
  Forces.QuadraticDrag air(d=0.5);
equation
  connect(stone.frame_a, air.frame_a);
"""
    )
    end = np.sqrt(2 * 9.81 / 0.5)
    np.testing.assert_allclose(
        result["stone.v[2]"], -end * np.tanh(9.81 * result.time / end), atol=1e-6
    )


def test_a_spring_and_a_damper_in_series_relax(run: Run) -> None:
    """Held at 0.4 m more than its length: f = c*0.4*exp(-c/d*t)."""
    result = run(
        """
  Parts.Fixed stop(r={1.4, 0});
  Forces.SpringDamperSeries mount(c=10, d=5, s_unstretched=1);
equation
  connect(world.frame_b, mount.frame_a);
  connect(mount.frame_b, stop.frame_b);
"""
    )
    np.testing.assert_allclose(result["mount.f"], 4 * np.exp(-2 * result.time), atol=1e-7)
    np.testing.assert_allclose(result["mount.lossPower"], result["mount.f"] ** 2 / 5, atol=1e-7)


def test_a_gear_on_the_ground_turns_both_wheels(run: Run) -> None:
    """(I_a*ratio^2 + I_b)*z_b = ratio*tau_a."""
    result = run(
        """
  Joints.GearConstraint gear(ratio=-3, r_b={1, 0}, phi_b(fixed=true), w_b(fixed=true));
  Parts.Body a(m=1, I=0.2), b(m=1, I=0.7);
  Forces.WorldTorque motor;
equation
  connect(world.frame_b, gear.bearing);
  connect(gear.frame_a, a.frame_a);
  connect(gear.frame_b, b.frame_a);
  connect(motor.frame_b, a.frame_a);
  motor.torque = 0.5;
"""
    )
    expected = -3 * 0.5 / (0.2 * 9 + 0.7) / 2 * result.time**2
    np.testing.assert_allclose(result["b.phi"], expected, atol=1e-8)
    np.testing.assert_allclose(result["a.phi"], -3 * expected, atol=1e-8)


@pytest.mark.parametrize(
    ("joint", "drive", "body"),
    [
        (
            "Joints.Revolute joint(drivenFlange=true, phi(fixed=true), w(fixed=true))",
            "Modelica.Mechanics.Rotational.Sources.ConstantTorque drive(tau_constant=0.5)",
            "Parts.Body body(m=1, I=0.25)",
        ),
        (
            "Joints.Prismatic joint(drivenFlange=true, s(fixed=true), v(fixed=true))",
            "Modelica.Mechanics.Translational.Sources.ConstantForce drive(f_constant=0.5)",
            "Parts.Body body(m=0.25, I=1)",
        ),
    ],
)
def test_a_drive_moves_a_joint_and_pushes_back(run: Run, joint: str, drive: str, body: str) -> None:
    result = run(
        f"""
  {joint};
  {drive};
  {body};
equation
  connect(world.frame_b, joint.frame_a);
  connect(joint.frame_b, body.frame_a);
  connect(drive.flange, joint.axis);
""",
        world="g=0",
    )
    turns = "Revolute" in joint
    np.testing.assert_allclose(
        result["joint.phi" if turns else "joint.s"], result.time**2, atol=1e-9
    )
    force, sign = ("joint.frame_a.t", 1) if turns else ("joint.frame_a.f[1]", 1)
    np.testing.assert_allclose(result[force], sign * 0.5, atol=1e-9)
