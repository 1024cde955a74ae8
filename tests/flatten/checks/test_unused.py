"""A parameter that nothing reads and a connection that is there twice are told, and no others."""

from __future__ import annotations

import pytest

import planarc

PART = "Modelica.Blocks.Sources.Step step;"


def told(text: str, code: str = "F338") -> list[str]:
    return [w.message for w in planarc.load(text).warnings if w.code == code]


def test_a_parameter_whose_name_stands_in_texts_alone_is_told() -> None:
    body = f'{PART}\n  parameter Real k=2 "k";\n  // k is meant\n  Real x=3*time "k*time";'
    assert told(f"model M\n  {body}\nend M;\n") == ["nothing uses the parameter `k`"]


def test_a_model_of_numbers_alone_is_an_exercise() -> None:
    assert told("model M\n  parameter Real k=2;\n  Real x=3*time;\nend M;\n") == []


@pytest.mark.parametrize(
    "body",
    [
        "parameter Real k=2; Real x=k*time;",
        "parameter Integer n=2; Real x[n]=fill(time, n);",
        "parameter Boolean on=false; Modelica.Blocks.Sources.Step s if on;",
        "final parameter Real k=2; Real x=time;",
        "constant Real k=2; Real x=time;",
        "parameter Integer n=2; Real x=sum(i*time for i in 1:n);",
    ],
)
def test_what_is_read_or_cannot_be_set_is_not_told(body: str) -> None:
    assert told(f"model M\n  {body}\n  {PART}\nend M;\n") == []


def test_a_parameter_of_a_base_class_is_not_told() -> None:
    base = "partial model B\n  parameter Real k=2;\nend B;\n"
    assert told(f"model M\n{base}  extends B;\n  Real x=k*time;\n  {PART}\nend M;\n") == []


PAIR = """model M
  Modelica.Mechanics.Rotational.Components.Inertia a(J=1, w(start=1, fixed=true)), b(J=1);
equation
  connect(a.flange_b, b.flange_a);
  CONNECT
end M;
"""


def test_a_connection_that_is_there_twice_is_told_either_way_round() -> None:
    for connect in ("connect(a.flange_b, b.flange_a);", "connect(b.flange_a, a.flange_b);"):
        (message,) = told(PAIR.replace("CONNECT", connect), "F228")
        assert message.endswith("are connected twice")
    assert told(PAIR.replace("CONNECT", ""), "F228") == []
