"""A drive between two free bodies: what it does to one, it undoes on the other.

`BorneDrive` accounts for the power of drives that do not react on their hinge.
"""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc.insight.energy import find_energies

#: A base, and a load on a hinge about the centres of both; a motor on the base drives the hinge.
DRIVE = """
model Drive
  import PlanarMultiBody.*;
  import Modelica.Mechanics.Rotational;
  inner World world(gravityType=Types.GravityTypes.NoGravity);
  Parts.Body base(m=1, I=0.5, r(each fixed=true), v(each fixed=true), phi(fixed=true),
    w(fixed=true));
  Joints.Revolute hinge(drivenFlange=true, {HINGE} phi(fixed=true), w(fixed=true));
  Parts.Body load(m=1, I=0.2);
  Rotational.Sources.ConstantTorque motor(useSupport={MOUNTED}, tau_constant=1);
  {PARTS}
equation
  connect(base.frame_a, hinge.frame_a);
  connect(hinge.frame_b, load.frame_a);
  {CONNECTIONS}
  annotation(experiment(StopTime=1, Tolerance=1e-9));
end Drive;
"""
MOUNTING = "Parts.Mounting1D housing;"
ON_BASE = "connect(base.frame_a, housing.frame_a); connect(housing.flange_b, motor.support);"
STRAIGHT = "connect(motor.flange, hinge.axis);"
GEARED = """connect(base.frame_a, rotor.frame_a); connect(housing.flange_b, gear.support);
  connect(motor.flange, rotor.flange_a); connect(rotor.flange_b, gear.flange_a);
  connect(gear.flange_b, hinge.axis);"""


def drive(reacts: bool, mounted: bool, geared: bool = False) -> str:
    parts = """Parts.Rotor1D rotor(J=0.01);
  Rotational.Components.IdealGear gear(ratio=5, useSupport=true);"""
    given = {
        "HINGE": "" if reacts else "driveReacts=false,",
        "MOUNTED": str(mounted).lower(),
        "PARTS": MOUNTING * mounted + parts * geared,
        "CONNECTIONS": ON_BASE * mounted + (GEARED if geared else STRAIGHT),
    }
    text = DRIVE
    for name, value in given.items():
        text = text.replace(f"{{{name}}}", value)
    return text


@pytest.mark.parametrize("mounted", [False, True])
def test_a_motor_turns_the_base_back(mounted: bool) -> None:
    """1 N.m for 1 s on 0.2 and on 0.5 kg.m2, mounted or not; nothing is warned of."""
    r = planarc.load(drive(not mounted, mounted)).simulate()
    assert not r.warnings
    assert r["load.w"][-1] == pytest.approx(5, rel=1e-7)
    assert r["base.w"][-1] == pytest.approx(-2, rel=1e-7)


def test_a_rotor_and_its_gear_turn_as_lagrange_says() -> None:
    """Angles of base, hinge and rotor th, phi and 5*phi, the inertia of the base with the rotor's:
    T = (0.5*th'^2 + J*(25*phi'^2 + 10*th'*phi') + 0.2*(th' + phi')^2)/2, Q = 5 N.m on phi."""
    j, ratio = 0.01, 5.0
    mass = np.array([[0.5 + 0.2, j * ratio + 0.2], [j * ratio + 0.2, j * ratio**2 + 0.2]])
    th, phi = np.linalg.solve(mass, [0.0, ratio])
    r = planarc.load(drive(False, True, geared=True)).simulate()
    assert r["base.w"][-1] == pytest.approx(th, rel=1e-7)
    assert r["hinge.w"][-1] == pytest.approx(phi, rel=1e-7)
    momentum = 0.5 * r["base.w"] + j * r["rotor.w"] + 0.2 * r["load.w"]
    assert abs(momentum).max() < 1e-9
    found = find_energies(r.rows, r.rows.program.mechanism)
    assert found is not None and not found.strangers
    assert abs(found.balance).max() < 1e-3 * found.exchanged


def test_a_drive_on_the_ground_may_be_mounted() -> None:
    """What a drive does to the ground twice changes nothing."""
    text = drive(True, True).replace(
        "base.frame_a, housing.frame_a", "world.frame_b, housing.frame_a"
    )
    assert not planarc.load(text).simulate().warnings
