"""The balance of components that no example holds: each declares all that it exchanges."""

from __future__ import annotations

import pytest

import planarc
from planarc.insight.energy import find_energies

ROT = "Modelica.Mechanics.Rotational"
TRA = "Modelica.Mechanics.Translational"
MODELS = {
    "a rotor in a swinging housing": """
      inner PlanarMultiBody.World world;
      PlanarMultiBody.Joints.Revolute hinge(phi(start=0.5, fixed=true), w(fixed=true));
      PlanarMultiBody.Parts.Body body(m=1, I=0.3, r_CM={0.4, 0});
      PlanarMultiBody.Parts.Rotor1D rotor(J=0.1, exact=true, w(start=2, fixed=true),
        phi(fixed=true));
      PlanarMultiBody.Parts.Mounting1D mounting;
      {ROT}.Sources.ConstantTorque motor(useSupport=true, tau_constant=0.7);
    equation
      connect(world.frame_b, hinge.frame_a);
      connect(hinge.frame_b, body.frame_a);
      connect(hinge.frame_b, rotor.frame_a);
      connect(hinge.frame_b, mounting.frame_a);
      connect(mounting.flange_b, motor.support);
      connect(motor.flange, rotor.flange_a);
    """,
    "a body in the wind": """
      inner PlanarMultiBody.World world;
      PlanarMultiBody.Parts.Body body(m=1, I=0.1, enforceStates=true, r(each fixed=true),
        v(start={1, 2}, each fixed=true), phi(fixed=true), w(fixed=true));
      PlanarMultiBody.Forces.QuadraticDrag air(d=0.3, v_medium={4, 1});
    equation
      connect(body.frame_a, air.frame_a);
    """,
    "forces and torques from outside": """
      inner PlanarMultiBody.World world;
      PlanarMultiBody.Parts.Body one(m=1, I=0.1, enforceStates=true, r(each fixed=true),
        v(start={1, 2}, each fixed=true), phi(fixed=true), w(fixed=true));
      PlanarMultiBody.Parts.Body two(m=2, I=0.3, enforceStates=true,
        r(start={1, 1}, each fixed=true), v(each fixed=true), phi(fixed=true), w(fixed=true));
      PlanarMultiBody.Forces.WorldForceAndTorque push(force={1, time}, torque=0.2);
      PlanarMultiBody.Forces.ForceAndTorque between(force={0.5, 1}, torque=0.1);
      PlanarMultiBody.Forces.Torque twist(torque=0.3);
    equation
      connect(push.frame_b, one.frame_a);
      connect(between.frame_a, one.frame_a);
      connect(between.frame_b, two.frame_a);
      connect(twist.frame_a, one.frame_a);
      connect(twist.frame_b, two.frame_a);
    """,
    "a spring and a damper in a row": """
      inner PlanarMultiBody.World world;
      PlanarMultiBody.Parts.PointMass mass(m=1, fixAngle=true, r(start={0, -1}, each fixed=true),
        v(start={1, 0}, each fixed=true));
      PlanarMultiBody.Forces.SpringDamperSeries series(c=60, d=8, s_unstretched=0.8);
    equation
      connect(world.frame_b, series.frame_a);
      connect(series.frame_b, mass.frame_a);
    """,
    "shafts with backlash": """
      {ROT}.Components.Inertia one(J=1, phi(fixed=true), w(start=3, fixed=true));
      {ROT}.Components.Inertia two(J=2, phi(fixed=true), w(fixed=true));
      {ROT}.Components.ElastoBacklash mesh(c=200, d=0.5, b=0.1);
      {ROT}.Components.SpringDamper shaft(c=20, d=0.1);
      {ROT}.Components.Fixed fixed;
      {ROT}.Sources.Torque2 both(tau=sin(3*time));
    equation
      connect(one.flange_b, mesh.flange_a);
      connect(mesh.flange_b, two.flange_a);
      connect(two.flange_b, shaft.flange_a);
      connect(shaft.flange_b, fixed.flange);
      connect(both.flange_a, one.flange_a);
      connect(both.flange_b, two.flange_b);
    """,
    "a carriage against a stop": """
      {TRA}.Components.Mass mass(m=1, s(start=1, fixed=true), v(start=-3, fixed=true));
      {TRA}.Components.ElastoGap stop(c=300, d=2, n=1.5);
      {TRA}.Components.Spring spring(c=5);
      {TRA}.Components.Damper damper(d=0.2);
      {TRA}.Components.Fixed wall;
      {TRA}.Sources.Force push(f=-0.5);
    equation
      connect(wall.flange, stop.flange_a);
      connect(stop.flange_b, mass.flange_a);
      connect(wall.flange, spring.flange_a);
      connect(spring.flange_b, mass.flange_a);
      connect(wall.flange, damper.flange_a);
      connect(damper.flange_b, mass.flange_b);
      connect(push.flange, mass.flange_b);
    """,
}


@pytest.mark.parametrize("name", MODELS)
def test_the_balance_closes(name: str) -> None:
    text = MODELS[name].replace("{ROT}", ROT).replace("{TRA}", TRA)
    end = "annotation(experiment(StopTime=3, Interval=0.003, Tolerance=1e-8)); end M;"
    result = planarc.load(f"model M {text} {end}").simulate().rows
    found = find_energies(result, result.program.mechanism)
    assert found is not None
    assert abs(found.balance).max() < 1e-3 * found.exchanged
    assert not found.strangers
