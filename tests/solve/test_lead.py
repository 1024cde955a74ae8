"""Starts of equations with several roots: which one, the simplified form says."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import pytest

import planarc
from planarc.core.options import Backend

BACKENDS = pytest.mark.parametrize("backend", [b.value for b in Backend])


def load(text: str, tmp_path: Path, backend: str = "numpy") -> planarc.Model:
    file = tmp_path / "M.mo"
    file.write_text(f"model M\n{text}\nend M;\n")
    return planarc.load(file, backend=backend)


@BACKENDS
@pytest.mark.parametrize(("simplified", "root"), [("x - 3", 2.0), ("-x - 3", -2.0)])
def test_the_root_that_hangs_together_with_the_simple_one(
    simplified: str, root: float, backend: str, tmp_path: Path
) -> None:
    """x^2 = 4 from a start at the other root."""
    text = f"  Real x(start={-root});\nequation\n  homotopy(x^2 - 4, {simplified}) = 0;"
    result = load(text, tmp_path, backend).simulate(1)
    assert result["x"] == pytest.approx(root, abs=1e-9)


LATCH = """
  parameter Real rest = 5 "Output of the simplified amplifier";
  Real u, v;
  Real s(start=0, fixed=true);
equation
  u = v/2 - s/4;
  v = homotopy(smooth(0, if 100*u > 5 then 5 elseif 100*u < -5 then -5 else 100*u), rest);
  der(s) = v - s;"""


@BACKENDS
@pytest.mark.parametrize("rest", [5.0, -5.0])
def test_an_amplifier_with_feedback_starts_at_the_limit_that_is_meant(
    rest: float, backend: str, tmp_path: Path
) -> None:
    """Its third root, v = 0, is not stable; the limit is a parameter that a run may set."""
    result = load(LATCH, tmp_path, backend).simulate(1, parameters={"rest": rest})
    assert result["v"] == pytest.approx(rest, abs=1e-9)
    assert result["s"][-1] == pytest.approx(rest * (1 - math.exp(-1)), rel=1e-5)


@BACKENDS
def test_a_way_that_turns_back_goes_on_elsewhere(backend: str, tmp_path: Path) -> None:
    """way*(x^2 - 4) + (1 - way)*(x + 3) has no root at way = 0.24."""
    result = load(
        "  Real x;\nequation\n  homotopy(x^2 - 4, x + 3) = 0;", tmp_path, backend
    ).simulate(1)
    assert abs(result["x"]) == pytest.approx(2.0, abs=1e-9)


@BACKENDS
def test_the_actual_form_needs_no_value_where_the_way_begins(backend: str, tmp_path: Path) -> None:
    text = "  Real x(start=-1);\nequation\n  homotopy(log(x - 1), x - 3) = 0;"
    result = load(text, tmp_path, backend).simulate(1)
    assert result["x"] == pytest.approx(2.0, abs=1e-9)


@BACKENDS
@pytest.mark.parametrize("rest", [2.0, -2.0])
def test_a_state_of_rest(rest: float, backend: str, tmp_path: Path) -> None:
    """der(x) = x - x^3 rests at 0, 1 and -1; the start value 0 is one of these."""
    text = f"""
  Real x(start=0);
initial equation
  der(x) = 0;
equation
  der(x) = homotopy(x - x^3, {rest} - x);"""
    model = load(text, tmp_path, backend)
    assert model.simulate(1)["x"] == pytest.approx(math.copysign(1, rest), abs=1e-8)
    assert model.linearize().A[0][0] == pytest.approx(-2.0, abs=1e-6)


def test_inputs_and_set_start_values_count_on_the_way(tmp_path: Path) -> None:
    """x^2 = u + s with u and s that only this run gives."""
    text = """
  input Real u(start=4);
  Real x, s(start=0);
equation
  homotopy(x^2 - u - s, -x - u - s) = 0;
  der(s) = 0;"""
    result = load(text, tmp_path).simulate(1, inputs={"u": 9.0}, start={"s": 7.0})
    assert result["x"] == pytest.approx(-4.0, abs=1e-9)


def test_the_run_is_that_of_the_actual_form(tmp_path: Path) -> None:
    """Not even relations of the simplified form are looked at."""
    text = "  Real x(start=1, fixed=true);\nequation\n  der(x) = {};"
    simple = load(text.format("-x"), tmp_path)
    model = load(text.format("homotopy(-x, if x > 0.5 then 1 else 2)"), tmp_path)
    assert model.compiled().code == simple.compiled().code
    assert not model.simulate(2).events
    assert simple.compiled().lead is None


def test_what_leads_is_kept_with_the_model(tmp_path: Path) -> None:
    """By memory on disk, by pickles, and for another back end."""
    for _ in range(2):
        model = load(LATCH, tmp_path)
        copy = pickle.loads(pickle.dumps(model))
        for m in (model, copy):
            for backend in Backend:
                assert m.simulate(0.1, backend=backend)["v"][0] == pytest.approx(5.0)
