"""Energy that the integrator loses is told, and none that the model takes itself."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

import planarc
from planarc.insight.losses import judge_losses

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
    assert "the run lost 1.26" in found.message
    assert "% of the energy that was exchanged" in found.message
    assert "lower `--tolerance`, for example to 1e-08" in str(found.hint)


def test_nothing_is_told_where_little_is_lost() -> None:
    assert told(0.0, tolerance=1e-9) == []


@pytest.mark.parametrize("damping", [1.0, 100.0])
def test_what_the_model_takes_is_not_lost(damping: float) -> None:
    assert told(damping) == []


LOOPS = "PlanarMultiBody.Examples.Loops"
FLAT = f"{LOOPS}.NFourBar"


def energy(result: planarc.Result, n: int) -> np.ndarray:
    """Of n + 1 cranks and n couplers, which only shift; in joule."""
    w, height = result["rev[1].w"], np.sin(result["rev[1].phi"])
    found: np.ndarray = ((n + 1) / 3 + n) / 2 * w**2 + 9.81 * (1.5 * n + 0.5) * height
    return found


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_runs_over_dead_points_keep_their_energy_or_tell(n: int, backend: str) -> None:
    windows = f"model Windows = {FLAT}(N={n});"
    model = planarc.load(windows, backend=backend)
    for tolerance in np.logspace(-5, -10.3, 150 if backend == "native" else 5).tolist():
        try:
            result = model.simulate(tolerance=tolerance)
        except planarc.RunStopped:
            continue
        total = energy(result, n)
        change = float(np.abs(total - total[0]).max())
        usual = 1e5 * tolerance * 19.62 * (1.5 * n + 0.5)
        assert change < usual or any(w.code == "R429" for w in result.warnings), tolerance


def judged(factor: float, near: bool = True) -> planarc.Diagnostic | None:
    """The warning where speeds are `factor` times as large from 3 s on."""
    rows = planarc.load(FLAT).simulate(tolerance=1e-9).rows
    data = rows.data.copy()
    speeds = [c.slot for c in rows.program.columns if c.unit == "rad/s" and c.slot in rows.stored]
    data[rows.time >= 3.0, [[rows.stored[slot]] for slot in set(speeds)]] *= factor
    return judge_losses(replace(rows, data=data, near_singular=near), 1e-9)


def test_energy_that_changes_at_a_dead_point_is_told_with_its_time() -> None:
    found = judged(1.001)
    assert found is not None
    assert found.message.startswith("from about t = 3 s on the run has 0.")
    assert "a loop came near to a pose in which it can go on in several ways" in found.message
    assert "try another `--tolerance`, for example 5e-10" in str(found.hint)


def test_energy_is_looked_at_where_loops_came_near_to_dead_points_alone() -> None:
    assert judged(1.0) is None
    assert judged(1.001, near=False) is None


@pytest.mark.parametrize(
    ("name", "near"), [(FLAT, True), *((f"{LOOPS}.{n}", False) for n in ("FourBar", "TwoLoops"))]
)
@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_loops_that_come_near_to_dead_points_are_known(name: str, near: bool, backend: str) -> None:
    model = planarc.load(name, backend=backend)
    assert model.simulate(tolerance=1e-9).rows.near_singular == near


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_pair_of_unknowns_is_known_to_be_near_to_one(backend: str) -> None:
    model = planarc.load(f"model Window = {FLAT}(N=1);", backend=backend)
    for angle, near in ((0.5, False), (1e-3, True)):
        result = model.simulate(1e-6, start={"rev[1].phi": angle})
        assert result.rows.near_singular == near
