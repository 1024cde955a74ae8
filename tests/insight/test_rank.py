"""Dead points: the smallest singular value says where a position is lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import planarc
from planarc.insight.rank import find_closeness

#: A slider driven on its rail turns a crank of length 1 by a rod of length 2.
SLIDER = """
model M
  inner PlanarMultiBody.World world(gravityType=PlanarMultiBody.Types.GravityTypes.NoGravity);
  PlanarMultiBody.Joints.Revolute crankHinge(phi(start=1, fixed=true), w(start=2, fixed=true));
  PlanarMultiBody.Joints.Revolute pin(phi(start=-1.4)), bolt(phi(start=0.4));
  PlanarMultiBody.Joints.Prismatic rail(n={1, 0}, s(start=2.3));
  PlanarMultiBody.Parts.BodyShape crank(r={1, 0}, m=1), rod(r={2, 0}, m=1e-3, I=1e-6);
  PlanarMultiBody.Parts.Body slider(m=1e-3, I=1);
equation
  connect(world.frame_b, crankHinge.frame_a);
  connect(crankHinge.frame_b, crank.frame_a);
  connect(crank.frame_b, pin.frame_a);
  connect(pin.frame_b, rod.frame_a);
  connect(rod.frame_b, bolt.frame_b);
  connect(world.frame_b, rail.frame_a);
  connect(rail.frame_b, bolt.frame_a);
  connect(rail.frame_b, slider.frame_a);
  annotation(experiment(StopTime=3, Interval=0.01, Tolerance=1e-8));
end M;
"""


def test_the_rank_of_a_crank_sliders_loop_is_full_all_the_way() -> None:
    model = planarc.load(SLIDER)
    result = model.simulate().rows
    found = find_closeness(result, model.compiled().load())
    assert found is not None
    assert found.loops.min() > 0.05
    assert found.states == ("crankHinge.phi",)
    assert found.held.min() > 0.05  # the crank determines the rest everywhere


def test_a_flat_parallelogram_is_the_nearest_to_dependent_loops(
    run_of: Callable[..., Any],
) -> None:
    # All bars of the windows lie in one line twice a turn: there the conditions are dependent.
    result, kernel = run_of("Loops.NFourBar")
    found = find_closeness(result, kernel)
    assert found is not None
    nearest = int(np.argmin(found.loops))
    assert found.loops[nearest] < 0.1 * found.loops.max()
    flat = abs(np.sin(result["rev[1].phi"][nearest]))
    assert flat < 0.2


def test_a_chain_has_no_loop_to_lose(run_of: Callable[..., Any]) -> None:
    assert find_closeness(*run_of("Elementary.DoublePendulum")) is None


def test_the_singular_values_are_those_of_the_loops_own_jacobian(
    run_of: Callable[..., Any],
) -> None:
    # By hand: turning by a unit at the hinges A, B, C moves the end D of the chain A-B-C-D
    # across D-A, D-B, D-C. These vectors are the columns of the Jacobian.
    result, kernel = run_of("Loops.FourBar")
    found = find_closeness(result, kernel)
    assert found is not None
    ends = [
        np.stack([1.0 - result[f"{frame}.r[1]"], -result[f"{frame}.r[2]"]])
        for frame in ("crank.frame_a", "crank.frame_b", "rocker.frame_b")
    ]
    jacobians = np.stack(ends, axis=-1).transpose(1, 0, 2)
    sizes = np.linalg.svd(jacobians, compute_uv=False)
    np.testing.assert_allclose(found.loops, sizes[:, -1] / sizes[:, 0], rtol=1e-4)
    held = np.linalg.svd(jacobians[:, :, 1:], compute_uv=False)
    np.testing.assert_allclose(found.held, held[:, -1] / sizes[:, 0], rtol=1e-4)
