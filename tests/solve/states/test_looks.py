"""Machine code measures the choice of states at every step as Python does, and acts on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.ir.newton import WORST
from planarc.solve.solvers.cvode import Cvode
from planarc.solve.solvers.integrator import March, Outcome
from planarc.solve.states.selector import Selector

#: A crank without a drive; the slider is the state as long as it can be one.
SLIDER = """
model Slider
  parameter Real r = 0.3;
  Real phi(start = 0.4, fixed = true, stateSelect = StateSelect.avoid);
  Real w(start = 3, fixed = true, stateSelect = StateSelect.avoid);
  Real s(start = 1.27, stateSelect = StateSelect.prefer);
  Real v(stateSelect = StateSelect.prefer);
  Real x = s - r*cos(phi);
  Real f;
equation
  der(phi) = w;
  der(s) = v;
  x^2 + (r*sin(phi))^2 = 1;
  der(w) = f*s*r*sin(phi);
  0.1*der(v) = f*x;
end Slider;
"""

#: Two of them side by side, which come to their dead centres at different times.
TWO = f"""
{SLIDER}
model Two
  Slider a;
  Slider b(r = 0.8, w(start = 2), s(start = 1.687));
end Two;
"""


def simulate(text: str, tolerance: float = 1e-9, stop: float = 5.0) -> Any:
    model = planarc.load(text, "Two" if "Two" in text else "Slider", backend="native")
    return model.simulate(stop, tolerance=tolerance, solver="cvode-bdf")


def energy(result: Any) -> np.ndarray:
    return 0.5 * result["w"] ** 2 + 0.05 * result["v"] ** 2


@pytest.mark.parametrize("text", [SLIDER, TWO], ids=["one", "two"])
def test_both_back_ends_measure_the_same(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the end of every short march: the largest sensitivity, and the scales."""
    plain, seen = Cvode.march, []

    def march(cvode: Cvode, limit: float, recorder: Any, watch: Any, steps: int) -> March:
        found = plain(cvode, limit, recorder, watch, 1)
        if found.outcome in (Outcome.BUDGET, Outcome.LOOK):
            selector = selectors[0]
            scales = watch.scales.copy()
            x = np.concatenate([np.ravel(x) for x in selector._sensitivities()])
            assert np.allclose(watch.scales, scales, rtol=1e-6)
            worst = float(np.max(x))
            seen.append(worst)
            if found.outcome is Outcome.LOOK:
                assert worst > WORST * (1 - 1e-6)
            else:
                assert worst <= watch.bound * (1 + 1e-6)
        return found

    selectors: list[Selector] = []
    choose = Selector.choose

    def chosen(selector: Selector, *given: Any) -> Any:
        selectors.append(selector)
        return choose(selector, *given)

    monkeypatch.setattr(Cvode, "march", march)
    monkeypatch.setattr(Selector, "choose", chosen)
    result = simulate(text, 1e-6)
    assert result.ended is None
    assert max(seen) > WORST
    assert min(seen) < 1


def test_a_state_gives_way_before_its_dead_centre() -> None:
    result = simulate(SLIDER)
    assert result.ended is None
    assert [s.states[0] for s in result.states] == ["s", "phi"]
    assert np.ptp(energy(result)) < 1e-6 * 4.5
    numpy = planarc.load(SLIDER, backend="numpy").simulate(5.0, tolerance=1e-9)
    assert np.max(np.abs(result["phi"] - numpy["phi"])) < 1e-5


def test_a_look_that_came_too_late_is_made_good(
    made_late: Callable[[], list[tuple[float, float]]],
) -> None:
    """The run goes back one step; no row is lost or taken twice."""
    plain = simulate(SLIDER)
    times = made_late()
    result = simulate(SLIDER)
    assert result.ended is None
    ((there, here),) = times
    assert there - 0.1 < here < there
    assert [s.states for s in result.states] == [s.states for s in plain.states]
    assert result.time.tolist() == plain.time.tolist()
    assert np.max(np.abs(result["phi"] - plain["phi"])) < 1e-5


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_long_steps_do_not_pass_a_dead_centre_unseen(tolerance: float) -> None:
    """The crank goes on turning, as its energy says, whatever the steps."""
    result = simulate(SLIDER, tolerance, 20.0)
    assert result.ended is None
    assert np.all(np.diff(result["phi"]) > 0)
