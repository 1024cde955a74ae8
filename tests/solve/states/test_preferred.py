"""Variables that are preferred as states are states, also where that takes differentiating."""

from __future__ import annotations

import pytest

import planarc

COUPLED = """
model Coupled "Two masses; how far they are apart, and how fast, is preferred"
  Real s1(start=0, fixed=true), v1(start=1, fixed=true), s2, v2;
  Real apart(start=2, fixed=true, stateSelect=StateSelect.prefer);
  Real rate(start=0, fixed=true, stateSelect=StateSelect.prefer);
equation
  apart = s2 - s1;
  rate = der(apart);
  der(s1) = v1;
  der(s2) = v2;
  der(v1) = 0;
  der(v2) = 0;
  when time > 0.5 then
    reinit(v1, 3);
  end when;
end Coupled;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_reinit_keeps_what_is_preferred(backend: str) -> None:
    """Of v1, v2 and their difference two are free: v1 is set, the difference stays."""
    if backend == "native":
        pytest.importorskip("llvmlite")
    result = planarc.load(COUPLED, backend=backend).simulate(1)
    assert set(result.states[0].states) >= {"apart", "rate", "v1"}
    assert result["rate"][-1] == pytest.approx(0, abs=1e-12)
    assert result["v2"][-1] == pytest.approx(3)
    assert result["s2"][-1] == pytest.approx(2 + 0.5 + 1.5)
