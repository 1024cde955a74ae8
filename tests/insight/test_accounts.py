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


STOP = """model Stop "A mass of one's own loses its velocity at an instant, and one with it"
  model Weight
    extends Modelica.Mechanics.Translational.Interfaces.PartialRigid;
    parameter Modelica.Units.SI.Mass m = 2;
    Modelica.Units.SI.Velocity v = der(s);
  equation
    m*der(v) = flange_a.f + flange_b.f;
    annotation(__planarc(energy(kinetic = FACTOR*m*v^2/2)));
  end Weight;
  model Stopped
    extends Weight(s(stateSelect=StateSelect.always), v(stateSelect=StateSelect.always));
  equation
    when s > 1 then
      reinit(v, 0);
    end when;
  end Stopped;
  import M = Modelica.Mechanics.Translational;
  Stopped a(s(start=0, fixed=true), v(start=1, fixed=true));
  Weight b(m=1);
  M.Sources.ConstantForce push(f_constant=1);
equation
  connect(push.flange, a.flange_a);
  connect(a.flange_b, b.flange_a);
end Stop;
"""


@pytest.mark.parametrize(("factor", "told"), [("1", []), ("2", ["a", "b"])])
def test_what_an_impact_takes_is_no_mistake_of_the_account(factor: str, told: list[str]) -> None:
    model = planarc.load(STOP.replace("FACTOR", factor))
    warnings = model.simulate(2.0, interval=0.01).warnings
    found = [w.message.split("`")[1] for w in warnings if w.code == "R445"]
    assert found == told
