"""Errors of states where these determine others: they stay near the tolerance through exchanges."""

from __future__ import annotations

import numpy as np
import pytest

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


#: A point on a sphere that keeps very nearly to one of its great circles.
SPHERE = """
model Sphere
  Real x(start = {x}, fixed = true);
  Real y;
  Real z(start = {z}, fixed = true);
  Real vx;
  Real vy(start = 0, fixed = true);
  Real vz(start = 0, fixed = true);
  Real F;
equation
  x^2 + y^2 + z^2 = 1;
  der(x) = vx;
  der(y) = vy;
  der(z) = vz;
  der(vx) = -F*x;
  der(vy) = -F*y - 9.81;
  der(vz) = -F*z;
end Sphere;
"""


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize(("x", "z"), [(1, 1e-7), (0.9, 1e-7), (0.9, 1e-5)])
def test_what_is_next_to_zero_is_not_determined_by_the_others(
    x: float, z: float, backend: str
) -> None:
    # Its square is lost beside theirs: z = sqrt(1 - x^2 - y^2) would be rounding.
    run = planarc.load(SPHERE.format(x=x, z=z), backend=backend).simulate(20, tolerance=1e-6)
    assert len(run.states) > 10
    assert all("z" in choice.states for choice in run.states)
    assert np.max(np.abs(run["z"])) < 2 * z
