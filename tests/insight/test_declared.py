"""What components declare: a user's own spring counts, and what nobody tells is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.flatten.tree import naming
from planarc.insight.energy import find_energies
from planarc.insight.facts import energy_facts

SPRING = "__planarc(energy(potential = k*x^2/2 + k3*x^4/4))"
DAMPER = "__planarc(energy(lossPower = b*der(x)^2))"

MODEL = """
model Swing
  model Hard "A spring that gets stiffer"
    extends PlanarMultiBody.Interfaces.PartialLineForce;
    parameter Real k(unit = "N/m") = 40;
    parameter Real k3(unit = "N/m3") = 300;
    Modelica.Units.SI.Length x = s - 0.5;
  equation
    f = k*x + k3*x^3;
    annotation({spring});
  end Hard;
  partial model Rubbing
    Modelica.Units.SI.Length x;
    parameter Real b(unit = "N.s/m") = 0.7;
    annotation({damper});
  end Rubbing;
  model Damp
    extends PlanarMultiBody.Interfaces.PartialLineForce;
    extends Rubbing;
  equation
    x = s;
    f = b*der(x);
  end Damp;
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start = 0.3, fixed = true), w(fixed = true));
  PlanarMultiBody.Parts.BodyShape rod(r = {{1, 0}}, m = 1, I = 0.1);
  PlanarMultiBody.Parts.Fixed hook(r = {{1, 1}});
  Hard spring[2](k = {{30, 10}});
  Damp damper;
  Damp absent(b = 100) if false;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  for i in 1:2 loop
    connect(hook.frame_b, spring[i].frame_a);
    connect(rod.frame_b, spring[i].frame_b);
  end for;
  connect(hook.frame_b, damper.frame_a);
  connect(rod.frame_b, damper.frame_b);
  annotation(experiment(StopTime = 4, Interval = 0.004, Tolerance = 1e-9));
end Swing;
"""


def energies_of(result: Any) -> Any:
    return find_energies(result, result.program.mechanism)


def test_a_users_own_spring_and_damper_close_the_balance() -> None:
    result = planarc.load(MODEL.format(spring=SPRING, damper=DAMPER)).simulate().rows
    found = energies_of(result)
    assert abs(found.balance).max() < 2e-3 * found.exchanged
    assert not found.strangers
    springs = sum(
        result[f"spring[{i}].k"] * result[f"spring[{i}].x"] ** 2 / 2
        + 300 * result[f"spring[{i}].x"] ** 4 / 4
        for i in (1, 2)
    )
    gravity = 9.81 * result["rod.body.r_0CM[2]"]
    np.testing.assert_allclose(found.potential, gravity + springs, rtol=1e-12)
    assert found.dissipated[-1] > 0.1 * found.exchanged


def test_what_nobody_declares_is_told_and_not_taken_for_a_drive() -> None:
    result = planarc.load(MODEL.format(spring="", damper=DAMPER)).simulate().rows
    found = energies_of(result)
    assert abs(found.balance).max() > 0.1 * found.exchanged
    assert set(found.strangers) == {"spring[1]", "spring[2]"}
    assert not found.supplied.any()
    facts = dict(energy_facts(found))
    assert "`spring[1]`, `spring[2]`" in facts["energy not told"]
    np.testing.assert_allclose(found.balance, found.untold, atol=2e-3 * found.exchanged)


def test_an_energy_may_be_told_by_its_rate() -> None:
    rate = "__planarc(energy(potential(rate = f*der(s))))"
    result = planarc.load(MODEL.format(spring=rate, damper=DAMPER)).simulate().rows
    found = energies_of(result)
    assert abs(found.balance).max() < 2e-3 * found.exchanged


def test_a_class_takes_the_place_of_what_its_base_declares() -> None:
    model = planarc.load(
        """
        model M
          model Base Real x = time; annotation(__planarc(energy(kinetic = x)));
          end Base;
          model Own extends Base; annotation(__planarc(energy(kinetic = 5*x)));
          end Own;
          model Other extends Base; annotation(__planarc(energy(potential = -4*x)));
          end Other;
          Own own;
          Other other;
          Real y(start = 0, fixed = true);
        equation
          der(y) = 1;
        end M;
        """
    )
    found = energies_of(model.simulate().rows)
    assert (found.kinetic[-1], found.potential[-1]) == (6.0, -4.0)


LIBRARY = """
package Modelica "A library in the place of planarc's own"
  package Mechanics package Rotational
    package Interfaces
      connector Flange_a Real phi(unit = "rad"); flow Real tau(unit = "N.m"); end Flange_a;
    end Interfaces;
    package Components
      model Inertia
        Interfaces.Flange_a flange_a;
        Interfaces.Flange_a flange_b;
        parameter Real J(unit = "kg.m2") = 1;
        Real w(unit = "rad/s", start = 3, fixed = true);
        Real phi(unit = "rad", fixed = true);
      equation
        phi = flange_a.phi; phi = flange_b.phi; w = der(phi);
        J*der(w) = flange_a.tau + flange_b.tau;
        annotation(Icon());
      end Inertia;
      model Spring "With other names than planarc's own class has"
        Interfaces.Flange_a flange_a;
        Real stiffness = 4;
      equation
        flange_a.tau = stiffness*flange_a.phi;
      end Spring;
      model LossyGear "Of a kind that planarc does not have"
        extends Modelica.Thermal.HeatTransfer.Interfaces.PartialElementaryConditionalHeatPort;
        Interfaces.Flange_a flange_a;
      equation
        flange_a.tau = 0.5*der(flange_a.phi);
        lossPower = flange_a.tau*der(flange_a.phi);
      end LossyGear;
    end Components;
  end Rotational; end Mechanics;
  package Thermal package HeatTransfer package Interfaces
    partial model PartialElementaryConditionalHeatPort Real lossPower(unit = "W");
    end PartialElementaryConditionalHeatPort;
  end Interfaces; end HeatTransfer; end Thermal;
end Modelica;
"""

USER = """
model Wheel
  Modelica.Mechanics.Rotational.Components.Inertia wheel(J = 2);
  Modelica.Mechanics.Rotational.Components.Spring spring;
  Modelica.Mechanics.Rotational.Components.LossyGear gear;
equation
  connect(wheel.flange_a, spring.flange_a);
  connect(wheel.flange_a, gear.flange_a);
end Wheel;
"""


def test_planarcs_own_classes_declare_for_those_of_their_name(tmp_path: Path) -> None:
    (tmp_path / "Modelica").mkdir()
    (tmp_path / "Modelica" / "package.mo").write_text(LIBRARY)
    (tmp_path / "Wheel.pmo").write_text(USER)
    model = planarc.load(tmp_path / "Wheel.pmo", libraries=[tmp_path])
    found = energies_of(model.simulate().rows)
    assert found.kinetic[0] == pytest.approx(9.0)
    assert found.dissipated[-1] > 0.5
    assert set(found.strangers) == {"spring"}  # it has no variables `c` and `phi_rel`


ELASTIC = """
      model Elastic "Declares its loss alone"
        extends Modelica.Thermal.HeatTransfer.Interfaces.PartialElementaryConditionalHeatPort;
        Interfaces.Flange_a flange_a;
      equation
        flange_a.tau = 4*flange_a.phi + 0.5*der(flange_a.phi);
        lossPower = 0.5*der(flange_a.phi)^2;
      end Elastic;
    end Components;
    package Examples model Swing
      Components.Inertia wheel;
      Components.Elastic elastic;
    equation
      connect(wheel.flange_a, elastic.flange_a);
    end Swing; end Examples;
  end Rotational;"""


def test_what_planarc_says_of_another_librarys_class_is_no_account_of_its_own(
    tmp_path: Path,
) -> None:
    """A model of that library is told of nothing that it has not written."""
    (tmp_path / "Modelica").mkdir()
    text = LIBRARY.replace("    end Components;\n  end Rotational;", ELASTIC)
    (tmp_path / "Modelica" / "package.mo").write_text(text)
    name = "Modelica.Mechanics.Rotational.Examples.Swing"
    result = planarc.load(name, libraries=[tmp_path]).simulate(2.0)
    assert result.rows.program.name == name
    assert [w.message for w in result.warnings if w.code == "R445"] == []


def test_what_the_library_in_front_lacks_is_not_looked_for_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hint that nobody sees took a second with the whole of the standard library."""
    (tmp_path / "Modelica").mkdir()
    (tmp_path / "Modelica" / "package.mo").write_text(LIBRARY)
    (tmp_path / "Wheel.pmo").write_text(USER)
    asked: list[str] = []

    def elsewhere(library: Any, name: str) -> None:
        asked.append(name)

    monkeypatch.setattr(naming, "_elsewhere", elsewhere)
    planarc.load(tmp_path / "Wheel.pmo", libraries=[tmp_path])
    assert asked == []
    (tmp_path / "Wheel.pmo").write_text(USER.replace("equation", "  c own;\nequation"))
    with pytest.raises(planarc.PlanarcError, match="unknown name `c`"):
        planarc.load(tmp_path / "Wheel.pmo", libraries=[tmp_path])
    assert asked == ["c"]
