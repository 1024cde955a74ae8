"""Variables that become inputs, by what is left of the equations."""

from __future__ import annotations

import pytest

from planarc import stages
from planarc.core.diagnostic import PlanarcError
from planarc.ir.dae import Dae
from planarc.ir.expr import text
from planarc.request.request import Request, open_target

MODEL = """
model M
  parameter Real k=3;
  Real x(start=1, fixed=true), v(start=0, fixed=true), f, g, h, wave;
  input Real u;
equation
  der(x) = v;
  der(v) = f + g + h + u;
  f = 2*k;
  g = f;
  h = -x;
  wave = sin(time);
end M;
"""


def opened(*names: str) -> Dae:
    model = stages.flatten(open_target(Request(text=MODEL)))
    return stages.to_dae(model, inputs=names)


def left(dae: Dae) -> list[str]:
    return [f"{text(e.left)} = {text(e.right)}" for e in dae.equations]


def test_the_equation_that_gives_the_value_is_left_out() -> None:
    dae = opened("f")
    assert [v.name for v in dae.inputs] == ["u", "f"]
    assert "f = 2*k" not in left(dae) and len(dae.equations) == len(dae.variables) == 5
    assert text(dae.inputs[1].start) == "2*k"


def test_an_equal_variable_keeps_its_own_value() -> None:
    dae = opened("g")
    assert "g = f" not in left(dae) and "f = 2*k" in left(dae)
    assert text(dae.inputs[1].start) == "2*k"


def test_a_formula_of_time_gives_no_start() -> None:
    assert opened("wave").inputs[1].start is None


def test_an_input_stays_one() -> None:
    assert [v.name for v in opened("u").inputs] == ["u"]


def test_what_follows_from_states_is_refused() -> None:
    with pytest.raises(PlanarcError, match=r"(?s)C301.*choose `f` or `g` or `wave`"):
        opened("h")
