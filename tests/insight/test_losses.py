"""Energy that the integrator loses is told, and none that the model takes itself."""

from __future__ import annotations

import pytest

import planarc

SWINGING = """model Swinging
  import M = Modelica.Mechanics.Translational.Components;
  M.Mass mass(m=1, s(start=0.01, fixed=true), v(start=0, fixed=true));
  M.SpringDamper spring(c=1e6, d=DAMPING, s_rel0=0, stateSelect=StateSelect.default);
  M.Fixed fixed(s0=0);
equation
  connect(fixed.flange, spring.flange_a);
  connect(spring.flange_b, mass.flange_a);
end Swinging;
"""


def told(damping: float, backend: str = "native", **options: float) -> list[planarc.Diagnostic]:
    text = SWINGING.replace("DAMPING", repr(damping))
    warnings = planarc.load(text, backend=backend).simulate(2.0, **options).warnings
    return [w for w in warnings if w.code == "R429"]


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_energy_lost_by_the_steps(backend: str) -> None:
    (found,) = told(0.0, backend)
    assert "the run lost 1.6" in found.message
    assert "% of the energy that was exchanged" in found.message
    assert "lower `--tolerance`, for example to 1e-08" in str(found.hint)


def test_nothing_is_told_where_little_is_lost() -> None:
    assert told(0.0, tolerance=1e-9) == []


@pytest.mark.parametrize("damping", [1.0, 100.0])
def test_what_the_model_takes_is_not_lost(damping: float) -> None:
    assert told(damping) == []
