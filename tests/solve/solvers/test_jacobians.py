"""A Jacobian serves where it was taken: not beyond a point at which its entries are huge."""

from __future__ import annotations

import numpy as np
import pytest

import planarc

#: The circle x = cos(t + 1), on which `off` is nothing. Beside it, `off` weighs the more the
#: slower x moves, as what a mechanism feels of an error beside a singular position.
BESIDE_A_POLE = """
model BesideAPole
  parameter Real d = 1e-10;
  Real x(start = {cos}, fixed=true), v(start = -{sin}, fixed=true);
  Real off = (x^2 + v^2 - 1)/(v^2 + d)*{factor};
equation
  der(x) = v;
  der(v) = -x - off;
end BesideAPole;
"""


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("factor", ["v/sqrt(v^2 + d)", "noEvent(if v > 0 then 1 else -1)"])
def test_no_jacobian_of_a_pole_freezes_what_moves(factor: str, backend: str) -> None:
    text = BESIDE_A_POLE.format(cos=np.cos(1), sin=np.sin(1), factor=factor)
    result = planarc.load(text, backend=backend).simulate(6, tolerance=1e-9, solver="cvode-bdf")
    assert result["x"] == pytest.approx(np.cos(result.time + 1), abs=1e-5)
