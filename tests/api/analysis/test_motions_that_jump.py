"""Motions that jump are refused, and such as only move fast are not."""

from __future__ import annotations

from math import radians, tanh

import pytest

import planarc

PENDULUM = "PlanarMultiBody.Examples.Elementary.Pendulum"


def test_a_motion_whose_branches_do_not_meet() -> None:
    def motion(t: float) -> float:
        return radians(30 * t * t) if t < 1 else 30.0

    with pytest.raises(planarc.UsageError, match=r"jumps from 0.5236 to 30 at t = 1 s") as caught:
        planarc.load(PENDULUM).drive("hinge.phi", motion, stop_time=2)
    assert caught.value.diagnostics[0].code == "C217"


def test_a_fast_motion_is_none_that_jumps() -> None:
    driven = planarc.load(PENDULUM).drive("hinge.phi", lambda t: tanh(200 * (t - 1)), stop_time=2)
    assert driven["hinge.phi"][-1] == pytest.approx(1.0)


def test_a_motion_that_stands_still() -> None:
    driven = planarc.load(PENDULUM).drive("hinge.phi", lambda t: 0.5, stop_time=1)
    assert driven["hinge.phi"] == pytest.approx(0.5)
