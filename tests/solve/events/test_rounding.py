"""What is at rest but for errors of rounding has no events."""

from __future__ import annotations

import pytest

import planarc
from planarc.instance.reactor import Reactor
from planarc.solve.events import rounding
from planarc.solve.events.rounding import OFTEN, Rough, Rounding
from planarc.solve.events.settling import Settling
from planarc.solve.events.snapshot import Snapshot

#: Four shafts in a row, with three clutches that close one after the other. Behind an open
#: clutch nothing moves: what its relations compare is zero, and solved for with the rest.
SHAFTS = """
model Shafts
  import Modelica.Mechanics.Rotational.Components.*;
  Modelica.Mechanics.Rotational.Sources.Torque drive;
  Inertia J1(J=1, phi(fixed=true, start=0), w(fixed=true, start=10));
  Inertia J2(J=1, phi(fixed=true, start=0), w(fixed=true, start=0));
  Inertia J3(J=1, phi(fixed=true, start=0), w(fixed=true, start=0));
  Inertia J4(J=1, phi(fixed=true, start=0), w(fixed=true, start=0));
  Clutch clutch1(peak=1.1, fn_max=20), clutch2(peak=1.1, fn_max=20), clutch3(peak=1.1, fn_max=20);
equation
  drive.tau = 10*sin(31.41592653589793*time);
  connect(drive.flange, J1.flange_a);
  clutch1.f_normalized = cos(1.2566370614359172*time);
  clutch2.f_normalized = if time < 0.4 then 0 else 1;
  clutch3.f_normalized = if time < 0.9 then 0 else 1;
  connect(J1.flange_b, clutch1.flange_a);
  connect(clutch1.flange_b, J2.flange_a);
  connect(J2.flange_b, clutch2.flange_a);
  connect(clutch2.flange_b, J3.flange_a);
  connect(J3.flange_b, clutch3.flange_a);
  connect(clutch3.flange_b, J4.flange_a);
end Shafts;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_shafts_behind_open_clutches_are_at_rest(backend: str) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    result = planarc.load(SHAFTS, backend=backend).simulate(1.5, tolerance=1e-8)
    assert 48 <= len(result.events) <= 54
    assert result["J1.w"][-1] == pytest.approx(3.24705, abs=1e-4)
    assert result["J4.w"][-1] == pytest.approx(2.46318, abs=1e-4)


@pytest.mark.parametrize(
    ("backend", "solver", "most"),
    [("native", "auto", 3000), ("numpy", "auto", 3000), ("numpy", "lsoda", 1500)],
)
def test_noise_of_what_is_at_rest_does_not_stop_an_integrator(
    backend: str, solver: str, most: int
) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    result = planarc.load(SHAFTS, backend=backend).simulate(1.5, tolerance=1e-8, solver=solver)
    assert result.statistics.steps < most
    assert 48 <= len(result.events) <= 54


@pytest.mark.parametrize("ways", [(0.5, 2.0), (2.0, 0.5)])
def test_rough_numbers_compare_with_plain_ones_on_either_side(ways: tuple[float, float]) -> None:
    a, b = ways
    for left, right in ((Rough(a), b), (a, Rough(b)), (Rough(a), Rough(b))):
        assert (left < right, left <= right) == (a < b, a <= b)


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_formulas_that_are_asked_for_often_give_the_same_bounds(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    found: dict[bool, list[list[float]]] = {True: [], False: []}
    bounds, settle, used = Rounding.bounds, Settling.settle, set[bool]()

    def asked(self: Settling, moved: bool, now: Snapshot) -> bool:
        self.crossings.noise(self.t, self.done.y)  # whether it is in doubt hangs on the processor
        return settle(self, moved, now)

    def noted(self: Rounding, elapsed: float) -> list[float]:
        for each in range(OFTEN):
            first = each < 2
            monkeypatch.setattr(rounding, "OFTEN", 10**9 if first else 1)
            found[first].append(bounds(self, elapsed))
            monkeypatch.setattr(rounding, "OFTEN", OFTEN)
        used.add(bool(self._formulas.prepared))
        return found[False][-1]

    monkeypatch.setattr(Rounding, "bounds", noted)
    monkeypatch.setattr(Settling, "settle", asked)
    monkeypatch.setattr(Reactor, "react", lambda *_: None)  # Python decides
    planarc.load(SHAFTS, backend=backend).simulate(1.5, tolerance=1e-8)
    plain, prepared = found[True][::2], found[False][:: OFTEN - 2]
    assert len(plain) == len(prepared) > 5
    assert prepared == plain
    assert used == {True}
    assert any(max(each) > 0 for each in plain)


def test_roots_of_what_may_be_negative_have_no_value() -> None:
    with pytest.raises(ValueError, match="negative"):
        Rough(-1.0) ** Rough(0.5)
