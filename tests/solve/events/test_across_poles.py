"""Relations whose sides have poles, and falls into points: nothing goes on that is no solution."""

from __future__ import annotations

import math

import pytest

import planarc
from planarc.api.result import RunStopped
from planarc.core.diagnostic import PlanarcError


@pytest.mark.parametrize("solver", ["cvode-bdf", "lsoda", "scipy-bdf"])
@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_relation_switches_at_a_pole(backend: str, solver: str) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    model = planarc.load(
        """model M
  Real x(start=0, fixed=true), y(start=0, fixed=true), z(start=0, fixed=true);
  Boolean steep = tan(x) > 1, near = 1/(x - 2) > 10;
equation
  der(x) = 1;
  der(y) = if steep then 1 else 0;
  der(z) = if near then 1 else 0;
end M;""",
        backend=backend,
    )
    result = model.simulate(12.0, solver=solver)
    assert result["y"][-1] == pytest.approx(math.pi, abs=1e-8)
    assert result["z"][-1] == pytest.approx(0.1, abs=1e-8)
    assert len(result.events) == 10


@pytest.mark.parametrize("force", ["1/r^2", "1/r"])
@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_fall_into_a_point_ends_there(backend: str, force: str) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    model = planarc.load(
        f"""model M
  Real r(start=1, fixed=true), v(start=0, fixed=true);
equation
  der(r) = v;
  der(v) = -{force};
end M;""",
        backend=backend,
    )
    with pytest.raises(PlanarcError, match="der\\(v\\) = -1/r") as caught:
        model.simulate(3.0, solver="cvode-bdf")
    assert isinstance(caught.value, RunStopped)
    rows = caught.value.result
    end = math.pi / math.sqrt(8) if force == "1/r^2" else math.sqrt(math.pi / 2)
    assert 0.98 * end < rows.time[-1] <= end
    assert rows["r"].min() > 0
