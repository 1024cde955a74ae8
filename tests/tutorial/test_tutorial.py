"""Every step of the tutorial runs, and shows what its comment promises."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

TUTORIAL = Path(__file__).parents[2] / "examples" / "tutorial"
STEPS = sorted(TUTORIAL.glob("*.pmo"))
g = 9.81  # m/s^2, of World


@cache
def step(number: int) -> Any:
    from planarc.compiler import simulate

    (path,) = TUTORIAL.glob(f"{number:02}_*.pmo")
    return simulate(path)


def test_there_are_ten_steps_and_the_page_lists_them_in_order() -> None:
    page = (TUTORIAL / "README.md").read_text("utf-8")
    assert [int(p.name[:2]) for p in STEPS] == list(range(1, 11))
    places = [page.index(f"]({p.name})") for p in STEPS]
    assert places == sorted(places)


@pytest.mark.parametrize("path", STEPS, ids=lambda p: p.stem)
def test_a_step_runs_to_its_end_and_says_what_to_see(path: Path) -> None:
    result = step(int(path.name[:2]))
    assert result.ended is None
    assert not result.warnings
    assert result.time[-1] == result.program.experiment.stop
    assert path.read_text("utf-8").splitlines()[1].startswith("  // See: ")


def test_1_the_mass_falls_in_a_parabola() -> None:
    r = step(1)
    assert np.allclose(r["mass.r[2]"], 3 - g * r.time**2 / 2, atol=1e-5)


def test_2_air_makes_the_throw_shorter() -> None:
    r = step(2)
    assert np.allclose(r["free.r[1]"], 10 * r.time, atol=1e-5)
    assert np.all(r["ball.r[1]"][1:] < r["free.r[1]"][1:])


def test_3_the_mass_comes_to_rest_where_the_forces_balance() -> None:
    r = step(3)
    late = r["slide.s"][r.time > 4]
    balance = 0.3 + g / 100
    assert np.all(np.abs(late - balance) < 0.5 * np.max(np.abs(r["slide.s"] - balance)))


def test_4_the_energy_stays_and_the_hinge_is_pulled_most_at_the_bottom() -> None:
    r = step(4)
    assert np.ptp(r["energy"]) < 1e-3
    force = np.hypot(r["hinge.frame_a.f[1]"], r["hinge.frame_a.f[2]"])
    bottom = r["hinge.phi"][np.argmax(force)]
    assert bottom == pytest.approx(-np.pi / 2, abs=0.05)
    # From energy and centripetal force: m*g*(1 + 3/2) for a uniform rod released level.
    assert np.max(force) == pytest.approx(2 * g * 2.5, rel=1e-2)


def test_5_the_two_pendulums_part() -> None:
    r = step(5)
    apart = np.abs(r["difference"])
    assert np.max(apart[r.time < 1]) < 0.01
    assert np.max(apart) > 0.5


def test_6_the_loop_stays_closed_with_one_state() -> None:
    r = step(6)
    assert len(r.states[0].states) == 2  # an angle and its speed
    for k in (1, 2):
        gap = r[f"coupler.frame_b.r[{k}]"] - r[f"rocker.frame_b.r[{k}]"]
        assert np.max(np.abs(gap)) < 1e-8


def test_7_the_slider_follows_the_crank_by_the_closed_form() -> None:
    r = step(7)
    phi = 10 * r.time
    stroke = 0.1 * np.cos(phi) + np.sqrt(0.4**2 - (0.1 * np.sin(phi)) ** 2)
    assert np.allclose(r["cylinder.s"], stroke, atol=1e-4)
    torque = r["motor.flange.tau"]
    assert np.min(torque) < 0 < np.max(torque)


def test_8_each_half_swing_loses_the_same_and_the_carriage_sticks() -> None:
    r = step(8)
    s, v = r["rail.s"] - 0.5, r["rail.v"]
    turns = np.abs(s[np.flatnonzero(np.diff(np.sign(v)) != 0)])
    # A half swing loses 2*f/c = 0.08 m, until the spring is weaker than friction: 0.04 m.
    assert turns[np.argmax(turns < 0.25)] == pytest.approx(0.3 - 0.08, abs=0.005)
    assert abs(s[-1]) <= 2 / 50 + 1e-6
    assert v[-1] == pytest.approx(0, abs=1e-9)


def test_9_the_lift_is_that_of_a_flat_follower_on_an_ellipse() -> None:
    r = step(9)
    phi = r["shaft.phi"]
    lift = np.sqrt((0.15 * np.sin(phi)) ** 2 + (0.08 * np.cos(phi)) ** 2)
    assert np.allclose(r["guide.s"], lift, atol=1e-4)


def test_10_the_bearing_sticks_breaks_loose_and_the_speed_waves() -> None:
    r = step(10)
    w, locked = r["shaft.w"], r["bearing.locked"] > 0.5
    stuck = (r.time > 0.4) & (r.time < 0.9)
    assert np.all(locked[stuck])
    assert np.max(np.abs(w[stuck])) < 1e-6
    late = w[r.time > 4]
    assert np.min(late) > 8
    assert np.ptp(late) > 0.1
    phi = r["shaft.phi"]
    lift = np.sqrt((0.15 * np.sin(phi)) ** 2 + (0.08 * np.cos(phi)) ** 2)
    assert np.allclose(r["guide.s"], lift, atol=1e-4)
