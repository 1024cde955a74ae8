"""A limiter that is at its limit nearly all the while is told, and none that is there at times."""

from __future__ import annotations

import pytest

import planarc

SIGNAL = """model M
  Modelica.Blocks.Sources.Sine sine(amplitude=A, f=1, offset=OFFSET);
  Modelica.Blocks.Nonlinear.Limiter limiter(uMax=1, uMin=LEAST);
equation
  connect(sine.y, limiter.u);
end M;
"""


def told(
    amplitude: float, offset: float = 0.0, least: float = -1.0, stop: float = 2.0
) -> list[str]:
    text = SIGNAL.replace("OFFSET", repr(offset)).replace("LEAST", repr(least))
    warnings = planarc.load(text.replace("A,", f"{amplitude},")).simulate(stop).warnings
    return [w.message for w in warnings if w.code == "R454"]


def test_the_share_is_that_of_the_closed_form() -> None:
    """|10*sin| is above 1 but for 4*asin(0.1) of each turn, 6.4 % of it."""
    (message,) = told(10.0)
    assert message == "`limiter` is at its limit `uMax` or the other one for 94% of the run"


def test_a_single_limit_is_named_alone() -> None:
    (message,) = told(2.0, offset=2.5, least=-9.0)
    assert message.startswith("`limiter` is at its limit `uMax` for 7")


@pytest.mark.parametrize("values", [(1.2,), (0.5,), (0.1, 5.0)])
def test_what_is_there_at_times_or_always_is_not_told(values: tuple[float, ...]) -> None:
    """A signal that is constant behind its limiter was hardly to be limited."""
    assert told(*values) == []


def test_a_run_of_no_time_says_nothing() -> None:
    assert told(10.0, stop=0.0) == []
