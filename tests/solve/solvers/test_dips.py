"""Relations that hold for less than a step: short pulses of a sine."""

from __future__ import annotations

import numpy as np
import pytest

import planarc

#: The amplitude is 1 however the integrator errs, so that the number of pulses is known.
PULSES = """
model Pulses
  Real phi(start=0, fixed=true), w(start=1, fixed=true);
  discrete Integer n(start=0, fixed=true);
  discrete Real begin(start=0, fixed=true), width(start=0, fixed=true);
equation
  der(phi) = w;
  der(w) = 0;
  when sin(phi) > {height} then
    n = pre(n) + 1;
    begin = time;
  end when;
  when not sin(phi) > {height} then
    width = time - begin;
  end when;
end Pulses;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams"])
@pytest.mark.parametrize("height", [0.9999, 0.999999])
def test_short_pulses_are_found(solver: str, backend: str, height: float) -> None:
    """One pulse in each turn, of 2*acos(height)/w: a hundredth of the steps or less."""
    run = planarc.load(PULSES.format(height=height)).simulate(
        60, solver=solver, backend=backend, intervals=100
    )
    assert run["n"][-1] == 10
    assert run["width"][-1] == pytest.approx(2 * np.arccos(height), rel=1e-6)


def test_integrators_that_step_in_python_find_pulses_too() -> None:
    run = planarc.load(PULSES.format(height=0.9999)).simulate(60, solver="lsoda", intervals=100)
    assert run["n"][-1] == 10


def test_pulses_of_states_are_found_where_an_oscillation_turns() -> None:
    model = planarc.load("""
    model Oscillation
      Real s(start=0, fixed=true), c(start=1, fixed=true);
      discrete Integer n(start=0, fixed=true);
    equation
      der(s) = c;
      der(c) = -s;
      when s > 0.9999 then
        n = pre(n) + 1;
      end when;
    end Oscillation;
    """)
    assert model.simulate(30, tolerance=1e-10)["n"][-1] == 5


def test_what_comes_near_and_turns_has_no_event() -> None:
    model = planarc.load(PULSES.format(height=1.0001))
    assert model.simulate(60)["n"][-1] == 0


def test_both_back_ends_note_the_same() -> None:
    """The march in machine code asks for a search where the one in Python does."""
    model = planarc.load(PULSES.format(height=0.9999))
    native, numpy = (model.simulate(60, backend=b) for b in ("native", "numpy"))
    assert native.statistics.steps == numpy.statistics.steps
    assert native["width"][-1] == pytest.approx(numpy["width"][-1], rel=1e-12)
