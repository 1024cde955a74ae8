"""Errors of states where these determine others: they stay near the tolerance through exchanges."""

from __future__ import annotations

import numpy as np

import planarc

#: A point on a circle, in coordinates of which either may be the state, that turns round and round.
CIRCLE = """
model Circle
  Real x(start = 1.5, fixed = true);
  Real y;
  Real vx;
  Real vy(start = -9, fixed = true);
  Real F;
equation
  x^2 + y^2 = 2.25;
  der(x) = vx;
  der(y) = vy;
  der(vx) = -F*x;
  der(vy) = -F*y - 9.81;
end Circle;
"""


def test_a_free_state_gives_way_before_its_errors_are_multiplied_by_twenty() -> None:
    # The energy says how far velocities are off: an error of x enters them with (x/y)^2.
    model = planarc.load(CIRCLE)
    lost = []
    for tolerance in np.geomspace(0.7e-6, 1.4e-6, 8):
        run = model.simulate(3, tolerance=float(tolerance))
        assert len(run.states) > 10
        energy = (run["vx"] ** 2 + run["vy"] ** 2) / 2 + 9.81 * run["y"]
        lost.append(np.max(np.abs(energy - energy[0])) / 40.5)
    assert np.exp(np.mean(np.log(lost))) < 4.5e-4
