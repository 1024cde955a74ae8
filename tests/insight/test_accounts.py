"""Components that declare energy are checked against their forces, and right ones are not told."""

from __future__ import annotations

import pytest

import planarc

CUSHION = """model Cushion "A mass falls on a cushion, which loses energy"
  model Soft
    extends Modelica.Mechanics.Translational.Interfaces.PartialCompliant;
    Real x(unit="m") = max(0.3 - s_rel, 0);
  equation
    f = -2000*x - 20*der(x);
    annotation(__planarc(energy(potential = 2000*x^2/2, lossPower = LOSS)));
  end Soft;
  import M = Modelica.Mechanics.Translational;
  M.Components.Fixed floor;
  M.Components.Mass mass(m=1, s(start=1, fixed=true), v(fixed=true));
  M.Sources.ConstantForce weight(f_constant=-9.81);
  Soft soft;
equation
  connect(floor.flange, soft.flange_a);
  connect(soft.flange_b, mass.flange_a);
  connect(weight.flange, mass.flange_b);
end Cushion;
"""


def told(loss: str, interval: float) -> list[str]:
    model = planarc.load(CUSHION.replace("LOSS", loss))
    warnings = model.simulate(2.0, interval=interval).warnings
    return [w.message for w in warnings if w.code == "R445"]


@pytest.mark.parametrize("interval", [0.002, 0.004, 0.01])
def test_integrals_over_jumps_are_no_mistake_of_the_account(interval: float) -> None:
    assert told("20*der(x)^2", interval) == []


def test_a_loss_of_the_wrong_sign_is_told() -> None:
    (message,) = told("-20*der(x)^2", 0.002)
    assert message.startswith("the energies that `soft` declares do not fit its forces")
