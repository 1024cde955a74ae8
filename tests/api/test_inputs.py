"""Inputs of every kind, and whole arrays of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model

KINDS = """package Kinds
  type Mode = enumeration(slow, fast);
  connector Switch = input Boolean;
  model Top
    input Boolean on;
    input Integer n(start=1);
    input Mode mode(start=Mode.slow);
    Switch c[2];
    input Real u[2];
    input Real m[2, 2];
    Real x(start=0, fixed=true);
    Real y = u[1] + 10*u[2] + (if c[1] then 100 else 0) + (if c[2] then 1000 else 0);
    Real z = m[1, 1] + 2*m[1, 2] + 3*m[2, 1] + 4*m[2, 2];
    discrete Integer risen(start=0, fixed=true);
  equation
    der(x) = (if on then 1 else 0)*n*(if mode == Mode.fast then 2 else 1);
    when on then risen = pre(risen) + 1; end when;
  end Top;
end Kinds;
"""


@pytest.fixture(scope="module")
def kinds() -> Model:
    return planarc.load(KINDS, "Kinds.Top")


def test_all_inputs_are_listed(kinds: Model) -> None:
    reals = ("u[1]", "u[2]", "m[1,1]", "m[1,2]", "m[2,1]", "m[2,2]")
    assert kinds.inputs == (*reals, "on", "n", "mode", "c[1]", "c[2]")


@pytest.mark.parametrize(
    ("given", "slope"),
    [
        ({}, 0),
        ({"on": True}, 1),
        ({"on": 1, "n": 3}, 3),
        ({"on": np.bool_(True), "n": np.int64(2), "mode": "fast"}, 4),
        ({"on": True, "mode": "Mode.fast"}, 2),
        ({"on": True, "mode": 2, "u": [1, 1]}, 2),
    ],
)
def test_inputs_that_are_no_reals_are_held(
    kinds: Model, given: dict[str, Any], slope: float
) -> None:
    assert kinds.simulate(1, inputs=given)["x"][-1] == pytest.approx(slope)


def test_arrays_take_a_value_for_each_element(kinds: Model) -> None:
    result = kinds.simulate(1, inputs={"u": [5, 1], "m": np.eye(2), "c": [True, False]})
    assert (result["y"][-1], result["z"][-1]) == (115, 5)
    result = kinds.simulate(1, inputs={"u": [math.sin, 0.1], "u[2]": ([0, 1], [0, 3])})
    assert result["y"][-1] == pytest.approx(math.sin(1) + 30)


def test_a_held_input_counts_more_than_its_start_value(kinds: Model) -> None:
    assert kinds.simulate(1, start={"on": False}, inputs={"on": True})["x"][-1] == pytest.approx(1)


def test_an_analysis_takes_them() -> None:
    model = planarc.load(
        "model L input Boolean on; input Real u; output Real y = x; Real x(start=0, fixed=true);"
        " equation der(x) = (if on then 2 else 1)*u - x; end L;"
    )
    found = model.linearize(inputs={"on": True, "u": 0}, outputs=["y"])
    assert (found.inputs, found.B[0, 0]) == (("u",), pytest.approx(2))


def test_a_stepper_sets_them_between_steps(kinds: Model) -> None:
    with kinds.stepper(0.5, stop_time=3) as run:
        assert run.inputs == kinds.inputs
        run.step()
        assert (run["x"], run["risen"]) == (0, 0)
        run["on"], run["mode"] = True, "fast"
        run.step()
        assert (run["x"], run["risen"], run["mode"]) == (pytest.approx(1), 1, 2)
        run["on"] = False
        run.step()
        run["on"], run["n"] = True, 3
        run.step()
        assert (run["x"], run["risen"]) == (pytest.approx(4), 2)
        with pytest.raises(planarc.UsageError, match="true or false"):
            run["on"] = 0.5


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"on": 0.5}, "`on` takes true or false, not 0.5"),
        ({"n": 1.5}, "`n` takes an integer"),
        ({"n": True}, "`n` takes an integer"),
        ({"mode": 3}, "no literal number 3"),
        ({"mode": "fats"}, "did you mean `fast`"),
        ({"on": lambda t: t > 1}, "`on` is a Boolean: it takes one value for the whole run"),
        ({"n": ([0, 1], [0, 1])}, "`n` is an Integer: it takes one value"),
        ({"u": [1, 2, 3]}, "`u` takes 2 numbers"),
        ({"u": 3}, "`u` takes 2 numbers"),
        ({"u[3]": 3}, "no input `u\\[3\\]`"),
        ({"x": 3}, "no input `x`"),
        ({3: 3}, "is a text"),
    ],
    ids=lambda part: part if isinstance(part, str) else "given",
)
def test_what_an_input_does_not_take_is_refused(kinds: Model, given: Any, words: str) -> None:
    with pytest.raises(planarc.UsageError, match=words):
        kinds.simulate(1, inputs=given)


def test_an_input_is_no_parameter(kinds: Model) -> None:
    with pytest.raises(planarc.UnknownName, match="`on` is an input, not a parameter"):
        kinds.simulate(1, parameters={"on": True})
