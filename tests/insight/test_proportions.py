"""Bars whose numbers contradict each other are told, and no unusual ones."""

from __future__ import annotations

import pytest

import planarc

BAR = """model Bar
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute hinge(phi(start=0.3, fixed=true), w(fixed=true));
  Parts.BodyShape bar(VALUES);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bar.frame_a);
end Bar;
"""


def told(values: str) -> list[str]:
    warnings = planarc.load(BAR.replace("VALUES", values)).warnings
    return [w.message for w in warnings if w.code == "S326"]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ("r={0.3, 0.4}, m=3, I=3*0.5^2/3", "that of a rod about its end"),
        ("r={0.028, 0}, r_CM={0.14, 0}, m=0.015, I=1e-6", "5 times as far"),
        ("r={0, -0.02}, r_CM={0, -0.1}, m=1, I=1e-4", "5 times as far"),
        ("r={0.3, 0.4}, r_CM={-0.2, 0.15}, m=3, I=3*0.5^2/12", "0.25 m beside it"),
        ("r={0.4, 0}, r_CM={0, 0.2}, m=1, I=0.0133", "0.2 m beside it"),
        ("r={0.2, 0}, r_CM={0.1, 0}, m=250, I=8.3e-4", "250 kg, and the inertia of a rod of 0.25"),
    ],
)
def test_a_slip_is_told(values: str, words: str) -> None:
    (message,) = told(values)
    assert words in message


@pytest.mark.parametrize(
    "values",
    [
        "r={0.5, 0}, m=3, I=3*0.5^2/12",  # a rod
        "r={0.1, 0}, m=0.3",  # the default of I, which nobody wrote
        "r={0.1, 0}, m=0.3, I=0.001",  # a round number, m*L^2/3 by chance
        "r={0.5, 0}, r_CM={0.3, 0}, m=3, I=3*0.5^2/3",  # no rod: its centre is not half-way
        "r={0.3, 0}, r_CM={1.5, 0}, m=40, I=30",  # a boom that reaches far beyond its lug
        "r={0.03, 0}, r_CM={0.015, 0.2}, m=5, I=0.01",  # a thigh beside its hip
        "r={0.1, 0}, r_CM={-0.4, 0}, m=2, I=1e-3",  # a counterweight
        "r={0.4, 0}, r_CM={0, 0.2}, m=1, I=0.05",  # an angle plate
        "r={0.4, 0}, r_CM={0, 0.1}, m=1, I=0.0133",
        "r={0.2, 0}, m=250, I=1e-3",  # a heavy mass in the middle
        "r={0, 0}, r_CM={0, 0}, m=1, I=0",
    ],
)
def test_what_may_be_meant_is_not_told(values: str) -> None:
    assert told(values) == []
