"""Every example runs as it stands, with both back ends, and obeys its laws."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import planarc
from tests.stdlib.small import BEGINNINGS

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = sorted(EXAMPLES.glob("*.pmo"))

both_backends = pytest.mark.parametrize("backend", ["native", "numpy"])


@cache
def example(name: str, backend: str) -> Any:
    from planarc.compiler import simulate
    from planarc.core.options import Backend, RunOptions

    stop = BEGINNINGS.get(name) if backend == "numpy" else None
    options = RunOptions(stop=stop, backend=Backend(backend))
    return simulate(EXAMPLES / f"{name}.pmo", options=options)


@both_backends
@pytest.mark.parametrize("name", [path.stem for path in FILES])
def test_an_example_runs_to_its_end_and_is_drawn(name: str, backend: str) -> None:
    from planarc.view.scene import make_scene

    result = example(name, backend)
    assert result.ended is None
    assert not result.warnings
    stop = BEGINNINGS.get(name) if backend == "numpy" else None
    assert result.time[-1] == (stop or result.program.experiment.stop)
    scene = make_scene(result)
    assert not scene.notes
    assert scene.items


@both_backends
def test_the_pendulum_keeps_its_energy(backend: str) -> None:
    energy = example("pendulum", backend)["energy"]
    np.testing.assert_allclose(energy, energy[0], atol=0.02)


@both_backends
def test_the_links_of_the_double_pendulum_keep_their_length(backend: str) -> None:
    result = example("double_pendulum", backend)
    for link, length in (("upper", 0.5), ("lower", 0.6)):
        x, y = (result[f"{link}.frame_b.r[{i}]"] - result[f"{link}.frame_a.r[{i}]"] for i in (1, 2))
        np.testing.assert_allclose(np.hypot(x, y), length, atol=1e-12)


@both_backends
def test_the_slider_stays_on_its_line_on_the_side_where_it_started(backend: str) -> None:
    result = example("crank_slider", backend)
    phi, s = result["main.phi"], result["slide.s"]
    expected = 0.3 * np.cos(phi) + np.sqrt(0.8**2 - (0.3 * np.sin(phi)) ** 2)
    np.testing.assert_allclose(s, expected, atol=1e-6)
    np.testing.assert_allclose(result["slider.frame_a.r[2]"], 0, atol=1e-12)


@both_backends
def test_the_four_bar_is_closed_and_does_not_change_its_branch(backend: str) -> None:
    result = example("four_bar", backend)
    crank, coupler, rocker = (result[f"{bar}Body.phi"] for bar in ("crank", "coupler", "rocker"))
    gap = 0.4 * np.exp(1j * crank) + 0.9 * np.exp(1j * coupler) - 1 - 0.8 * np.exp(1j * rocker)
    assert np.max(np.abs(gap)) < 1e-6
    b, c = 0.4 * np.exp(1j * crank), 1 + 0.8 * np.exp(1j * rocker)
    left_of_bd = ((1 - b).conj() * (c - b)).imag
    assert np.min(left_of_bd) > 0


@both_backends
def test_the_cam_loses_its_follower_where_nothing_presses_it(backend: str) -> None:
    """At the first angle at which s'*w' + s''*w^2 = -g, s = sqrt(a^2*sin^2 + b^2*cos^2)."""
    result = example("cam_lift_off", backend)
    times = np.linspace(2, 4, 2_000_001)
    phi, a2, b2 = 2 * times**2, 0.15**2, 0.1**2
    s = np.sqrt(a2 * np.sin(phi) ** 2 + b2 * np.cos(phi) ** 2)
    rate = (a2 - b2) / 2 * np.sin(2 * phi) / s
    bend = ((a2 - b2) * np.cos(2 * phi) - rate**2) / s
    first = times[np.argmax(rate * 4 + bend * (4 * times) ** 2 < -9.81)]
    off, on = result.events[:2]
    assert off.causes == ("`contact` of `bearing` and `follower`: lets go",)
    assert off.time == pytest.approx(first, abs=2e-6)
    assert "impact" in on.causes[0]
    assert result["contact.gap"].min() > -1e-6
    flights = [e for e in result.events if "lets go" in e.causes[0]]
    assert len(flights) > 3


@pytest.mark.usual
@both_backends
def test_the_geneva_drive_steps_by_its_closed_form_within_its_play(backend: str) -> None:
    result = example("geneva_drive", backend)
    theta, part = result["shaft.phi"], np.sin(np.pi / 4)
    turns = np.round(theta / (2 * np.pi))
    a = theta - 2 * np.pi * turns
    driven = np.arctan2(part * np.sin(a), 1 - part * np.cos(a))
    wheel = np.where(np.abs(a) < np.pi / 4, -driven, -np.sign(a) * np.pi / 4) - turns * np.pi / 2
    off = 0.1 * part * (result["axis.phi"] - wheel + wheel[0])  # at the rim
    assert np.abs(off).max() == pytest.approx(1e-4, abs=1e-7)
    # The pin drives on one wall, brakes on the other one, and rests on neither.
    force = result["geneva.f"]
    np.testing.assert_allclose(off[force > 1e-6], -1e-4, atol=1e-7)
    np.testing.assert_allclose(off[force < -1e-6], 1e-4, atol=1e-7)
    assert (force == 0).any()
    impacts = [e.causes[0].split()[0].rstrip(":") for e in result.events if "impact" in e.causes[0]]
    assert set(impacts[:5]) == {"`geneva.ahead`"}
    assert set(impacts[5:10]) == {"`geneva.behind`"}


@both_backends
def test_the_pawl_keeps_whole_teeth_of_each_push(backend: str) -> None:
    result = example("ratchet_and_pawl", backend)
    wheel, pawl = result["shaft.phi"], result["hinge.phi"]
    rests = [int(np.searchsorted(result["time"], t)) for t in (0.29, 1.29, 2.29)]
    np.testing.assert_allclose(np.diff(wheel[rests]), np.pi / 3, atol=1e-6)
    # There the nose lies 1.5 mm from the face, which is radial: behind it on the wheel.
    nose = 0.07 - 0.07 * np.cos(pawl) + 1j * (0.055 - 0.07 * np.sin(pawl))
    seen = np.abs(nose) * np.exp(1j * (np.angle(nose) - wheel))
    turn = np.exp(2j * np.pi / 12 * np.ceil(np.angle(seen) / (2 * np.pi / 12)))
    np.testing.assert_allclose(-(seen / turn).imag[rests], 0.0015, atol=1e-8)
    # Held by the face, the pawl bears the load of 0.1 N.m about the shaft.
    force = result["ratchet.f[1]"] + 1j * result["ratchet.f[2]"]
    np.testing.assert_allclose((nose.conjugate() * force).imag[rests], -0.1, rtol=1e-6)
    # Falling in, it strikes twice in each push; its weight alone moves it in between.
    flies = np.abs(force) < 1e-9
    bends = result["hinge.z"][flies]
    weight = 0.05 * 9.81 * 0.035 / (2e-5 + 0.05 * 0.035**2)
    np.testing.assert_allclose(bends, weight * np.cos(pawl[flies]), rtol=1e-6)
    assert flies.sum() > 20


@both_backends
def test_the_escapement_gives_a_tooth_a_swing_and_what_the_air_takes(backend: str) -> None:
    """A tooth a period, T = 2*pi*sqrt(l/g)*(1 + lift^2/16) but for what the pushes change; at rest
    whatever the pendulum does beyond. The weight's work is in pendulum, air and impacts."""
    from planarc.insight.energy import find_energies

    r = example("escapement", backend)
    told = [(e.time, e.causes[0].split("`")[1]) for e in r.events if "impact" in e.causes[0]]
    # It catches up with the slope that it pushes, and drops onto the other pallet.
    assert [name for _, name in told] == ["entry", "exit", "exit", "entry"] * 3
    drops = [t for t, _ in told[1::2]]
    times = np.array(drops[1::2])
    period = 2 * np.pi * np.sqrt(0.25 / 9.81) * (1 + 0.07**2 / 16)
    np.testing.assert_allclose(np.diff(times), period, rtol=6e-3)
    rests = r["arbor.phi"][np.searchsorted(r.time, times + 0.05)]
    np.testing.assert_allclose(np.diff(rests), -2 * np.pi / 15, atol=1e-6)
    for t in drops[:-1]:
        locked = (r.time > t + 1e-6) & (r.time < t + 0.2)
        assert np.abs(r["arbor.w"][locked]).max() < 1e-6
        assert np.ptp(r["axis.phi"][locked]) > 0.01
    energies = find_energies(r, r.program.mechanism)
    assert energies is not None
    assert np.abs(energies.balance).max() < 1e-3 * energies.exchanged


@both_backends
def test_the_dominoes_fall_one_by_the_other_and_lean_on_each_other(backend: str) -> None:
    """The first one turns about its lower edge: phi' = sqrt(w0^2 + 2*m*g*r*(cos(a0) - cos(a))/I).
    In the end each leans where the next one's face is: cos(phi) = b/(b + gap)."""
    r = example("dominoes", backend)
    h, b, gap = 0.05, 0.01, 0.03
    reach, start = np.hypot(h, b) / 2, -np.arctan(b / h)
    a = start + np.linspace(0, np.arcsin(gap / h), 100_001)
    rate = np.sqrt(25 + 6 * 9.81 * reach * (np.cos(start) - np.cos(a)) / (h**2 + b**2))
    strikes = [
        next(e.time for e in r.events if f"`front[{i}]`" in str(e.causes)) for i in range(1, 5)
    ]
    assert strikes[0] == pytest.approx(np.trapezoid(1 / rate, a), rel=1e-6)
    assert (np.diff(strikes) > 0.01).all()
    energy = 0.0
    for i in range(1, 6):
        v2 = r[f"domino[{i}].v[1]"] ** 2 + r[f"domino[{i}].v[2]"] ** 2
        turns = (h**2 + b**2) / 12 * r[f"domino[{i}].w"] ** 2
        energy = energy + 0.02 * (v2 / 2 + turns / 2 + 9.81 * r[f"domino[{i}].r[2]"])
        assert abs(r[f"domino[{i}].w"][-1]) < 1e-3
    assert np.diff(energy).max() < 1e-6 * energy[0]
    for i in (1, 2, 3):
        assert r[f"domino[{i}].phi"][-1] == pytest.approx(-np.arccos(b / (b + gap)), abs=2e-3)
    assert r["domino[5].phi"][-1] == pytest.approx(-np.pi / 2, abs=1e-6)


@both_backends
def test_the_gripper_holds_what_both_sides_of_its_jaws_bear(backend: str) -> None:
    """m*(g + a) = 2*mu*F at the limit; below, the box lags by (2*mu*F/m - g - a)*t^2/2. On the
    floor nothing needs the jaws' friction: it must wake when they begin to lift."""
    r = example("gripper", backend)
    assert np.abs(r["box.r[2]"] - r["lift.s"] - 0.05).max() < 1e-6
    assert r["box.r[2]"][-1] == pytest.approx(0.05 + 0.18, abs=1e-6)
    model = planarc.load(EXAMPLES / "gripper.pmo", backend=backend)
    limit = (9.81 + 2) / 40
    for part, holds in ((1.001, True), (0.999, False), (0.95, False)):
        r = model.simulate(0.6, parameters={"mu": part * limit}, tolerance=1e-10)
        t = r.time[-2] - 0.3
        lag = (r["box.r[2]"] - r["lift.s"] - 0.05)[-2]
        law = 0.0 if holds else (part - 1) * 40 * limit / 2 * t**2
        assert lag == pytest.approx(law, abs=1e-5)


def test_the_chain_runs_over_the_peg_as_a_limp_one_and_falls_freely() -> None:
    """x'' = 2*g/L*x for half of what one side is longer; blows of links on the peg take less than
    a hundredth of what the fall gives; the chain that has left the peg falls with g."""
    r = example("chain_over_peg", "native")
    number, left, bends, link, mass, g = 30, 10, 5, 0.04, 0.02, 9.81
    energy, momentum = 0.0 * r["time"], 0.0 * r["time"]
    for i in range(1, number + 1):
        fast = r[f"link[{i}].v_CM[1]"] ** 2 + r[f"link[{i}].v_CM[2]"] ** 2
        energy = energy + mass * (fast / 2 + link**2 / 24 * r[f"link[{i}].w"] ** 2)
        energy = energy + mass * g * r[f"link[{i}].r_0CM[2]"]
        momentum = momentum + mass * r[f"link[{i}].v_CM[2]"]
    assert np.diff(energy).max() < 1e-4
    longer = (number - 2 * left - bends - 1) * link / 2
    runs = r["time"] < 0.4
    law = longer * (np.cosh(np.sqrt(2 * g / (number * link)) * r["time"][runs]) - 1)
    rises = r["link[1].r[2]"] - r["link[1].r[2]"][0]
    np.testing.assert_allclose(rises[runs], law, atol=0.03 * law.max())
    assert 0 < energy[0] - energy[-1] < 0.01 * np.ptp(momentum) ** 2 / (2 * number * mass)
    free = r["time"] > 0.666
    gain = np.diff(momentum[free]) / np.diff(r["time"][free])
    np.testing.assert_allclose(gain, -number * mass * g, rtol=1e-4)


@both_backends
def test_the_pendulum_is_balanced_as_its_equations_and_its_program_say(backend: str) -> None:
    """Lagrange's equations of cart and pole, integrated from tick to tick, and the computer's
    program as a loop."""
    m, mass, length, inertia, g, interval = 0.2, 1.2, 0.3, 0.006 + 0.2 * 0.3**2, 9.81, 0.02

    def rates(_: float, x: np.ndarray, force: float) -> list[float]:
        sin, cos = np.sin(x[1]), np.cos(x[1])
        a = [[mass, -m * length * cos], [-m * length * cos, inertia]]
        b = [force - m * length * x[3] ** 2 * sin, m * g * length * sin]
        return [x[2], x[3], *np.linalg.solve(a, b)]

    model = planarc.load(EXAMPLES / "balanced_pendulum.pmo", backend=backend)
    r = model.simulate(8, tolerance=1e-11)
    gains, goal = np.array([-3.8, 40, -5.1, 7.9]), 0.0
    x, before = np.array([0, 1.45 - np.pi / 2, 0, 0]), np.zeros(2)
    for tick in range(400):
        if tick % 25 == 0:
            goal = 0.0 if tick * interval < 5 else 0.5
        speeds = (x[:2] - before) / interval if tick else np.zeros(2)
        before = x[:2]
        force = -gains @ [x[0] - goal, x[1], *speeds]
        shown = [r.at(n, (tick + 0.5) * interval) for n in ("place", "tilt", "push")]
        np.testing.assert_allclose(shown, [*before, force], atol=1e-6)
        x = solve_ivp(rates, (0, interval), x, args=(force,), rtol=1e-10, atol=1e-12).y[:, -1]
    assert x[0] == pytest.approx(0.5, abs=0.01)
