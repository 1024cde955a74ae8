"""The start, sentence by sentence of what is promised of it, in both back ends."""

from __future__ import annotations

import numpy as np
import pytest

import planarc


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def run(body: str, backend: str, stop: float = 1.0) -> planarc.Result:
    text = f"model M\n{body}\nend M;"
    return planarc.load(text, backend=backend).simulate(stop, tolerance=1e-9)


def test_a_steady_state_stays(backend: str) -> None:
    """0 = -x + 2y and 0 = x - 3y + 1 at x = 2, y = 1."""
    result = run(
        """
  Real x(start=5), y(start=-3);
equation
  der(x) = -x + 2*y;
  der(y) = x - 3*y + 1;
initial equation
  der(x) = 0;
  der(y) = 0;""",
        backend,
    )
    assert result["x"] == pytest.approx(2.0, abs=1e-8)
    assert result["y"] == pytest.approx(1.0, abs=1e-8)


def test_homotopy_leads_where_newton_does_not(backend: str) -> None:
    """From x = 5 Newton's steps on atan(x - 2) grow without end; the simple form is solved at
    once and leads to the other."""
    result = run(
        """
  Real x(start=5);
  Real z(start=0, fixed=true);
equation
  homotopy(atan(x - 2), 0.3*(x - 2)) = 0;
  der(z) = x;""",
        backend,
    )
    assert result["x"] == pytest.approx(2.0, abs=1e-8)
    assert result["z"][-1] == pytest.approx(2.0, abs=1e-8)


def test_a_distance_that_is_held_says_where_a_body_is(backend: str) -> None:
    """The place of a bead on a straight rail is differentiated twice, its distances along and
    across a turned frame once: they are of another level."""
    result = run(
        """
  Real x, y, vx = der(x), vy = der(y), push;
  Real along(start=0.5, fixed=true), across, speed(start=0, fixed=true), drift;
equation
  0.8*y - 0.6*x = 0.4;
  der(vx) = -0.6*push;
  der(vy) = 0.8*push - 9.81;
  x - 0.2 = 0.8*along - 0.6*across;
  y + 0.1 = 0.6*along + 0.8*across;
  speed = der(along);
  drift = der(across);""",
        backend,
        stop=0.1,
    )
    expected = {"along": 0.5, "across": 0.6, "x": 0.24, "y": 0.68, "speed": 0.0}
    start = {name: result.at(name, 0.0) for name in expected}
    assert start == pytest.approx(expected, abs=1e-12)


def test_what_is_fixed_twice_and_agrees_is_accepted(backend: str) -> None:
    result = run(
        """
  Real x(start=2, fixed=true), y(start=4, fixed=true), v(start=1, fixed=true);
equation
  y = 2*x;
  der(x) = v;
  der(v) = -x;""",
        backend,
    )
    exact = 2 * np.cos(result.time) + np.sin(result.time)
    assert result["x"] == pytest.approx(exact, abs=1e-7)


def test_what_is_fixed_twice_and_does_not_agree_names_both(backend: str) -> None:
    with pytest.raises(planarc.PlanarcError, match="R411") as caught:
        run(
            """
  Real x(start=2, fixed=true), y(start=5, fixed=true);
equation
  y = 2*x;
  der(x) = -x;""",
            backend,
        )
    told = str(caught.value)
    assert "`x`" in told
    assert "`y`" in told


def test_the_initial_system_is_solved_whatever_its_order(backend: str) -> None:
    """Nonlinear, in a ring and with a parameter: a^2 + b = 7, b*c = 6, c - a = 0 at (2, 3, 2)."""
    equations = ["a^2 + b = 7", "b*c = 6", "c - a = p"]
    for turn in range(3):
        order = equations[turn:] + equations[:turn]
        result = run(
            f"""
  parameter Real p=0;
  Real a(start=1.8), b(start=2.9), c(start=2.1);
equation
  der(a) = -a;
  der(b) = a - b;
  der(c) = b - c;
initial equation
  {"; ".join(order)};""",
            backend,
        )
        found = [result[name][0] for name in "abc"]
        assert found == pytest.approx([2, 3, 2], abs=1e-8)


def test_initial_equations_are_met_far_from_their_guesses(backend: str) -> None:
    """x + y = 1550 and x*y = 6e5 for 750 and 800; at the guesses, zeros, slopes are singular."""
    result = run(
        """
  Real x, y;
initial equation
  x*y = 6e5;
  x + y = 1550;
equation
  der(x) = 0;
  der(y) = 0;""",
        backend,
    )
    assert sorted([result["x"][0], result["y"][0]]) == pytest.approx([750, 800], rel=1e-9)


def test_start_values_beside_enough_initial_equations_are_guesses(backend: str) -> None:
    """The double root x = y = 1 of x + y = 2 and x*y = 1 leaves a direction open; it is no freedom
    in which x = 0 could be held."""
    result = run(
        """
  Real x(start=0), y(start=0);
initial equation
  x*y = 1;
  x + y = 2;
equation
  der(x) = -x;
  der(y) = -y;""",
        backend,
    )
    assert [result["x"][0], result["y"][0]] == pytest.approx([1, 1], abs=1e-4)


@pytest.mark.parametrize(
    ("equations", "start", "root"),
    [
        ("x = y + 1; x - 1 = sin(y);", (1, 0), (1, 0)),  # a triple root, from itself
        ("y*(x^2 + 1) = 0; y*x = y^2;", (3, 0), (3, 0)),  # every x solves them
        ("(x - 2*y)^2 = 0; (x - y)^2 = 0;", (1, 1), (0, 0)),  # slopes end with the residuals
    ],
)
def test_roots_where_slopes_vanish(
    equations: str, start: tuple[float, float], root: tuple[float, float], backend: str
) -> None:
    text = f"  Real x(start={start[0]}), y(start={start[1]});\nequation\n  {equations}"
    result = run(text, backend, stop=0.0)
    assert [result["x"][0], result["y"][0]] == pytest.approx(root, abs=1e-4)


def test_a_power_of_zero_has_a_slope_where_its_exponent_is_sought(backend: str) -> None:
    """x + y = x^(1 + y) is solved by y = 0; by y, x^(1 + y) has the slope x^(1 + y)*log(x)."""
    result = run(
        """
  Real x(start=0, fixed=true, stateSelect=StateSelect.always), y(start=0), v;
equation
  der(x) = 1;
  x + y = x^(1 + y);
  v = der(y);""",
        backend,
        stop=0.5,
    )
    assert result["y"] == pytest.approx(0, abs=1e-9)
    assert result["v"] == pytest.approx(0, abs=1e-8)
