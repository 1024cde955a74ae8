"""Every example of the library runs as it stands, with both back ends, and obeys its law."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from planarc.core.resources import stdlib

ROOT = stdlib() / "PlanarMultiBody" / "Examples"
NAMES = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in ROOT.rglob("*.pmo")
    if path.stem != "package"
)

both_backends = pytest.mark.parametrize("backend", ["native", "numpy"])


@cache
def example(name: str, backend: str = "native") -> Any:
    from planarc.compiler import compile_model, run
    from planarc.core.options import Backend, RunOptions
    from planarc.request.request import Request

    program = compile_model(Request(class_name=f"PlanarMultiBody.Examples.{name}"))
    return run(program, RunOptions(backend=Backend(backend)))


@both_backends
@pytest.mark.parametrize("name", NAMES)
def test_an_example_runs_to_its_end_is_drawn_and_obeys_its_law(name: str, backend: str) -> None:
    from planarc.view.scene import make_scene

    result = example(name, backend)
    assert result.ended is None
    # Contacts are two-sided; a run tells when one pulled, which some examples mean to show.
    assert all("the contact pulls" in w.message for w in result.warnings)
    assert result.time[-1] == result.program.experiment.stop
    scene = make_scene(result)
    assert not scene.notes
    assert scene.items
    LAWS[name](result)


@pytest.mark.parametrize("name", NAMES)
def test_values_lie_between_the_limits_that_their_variables_declare(name: str) -> None:
    result = example(name)
    shown = {c.name for c in result.program.columns}
    wrong = []
    for told in (told for told in result.program.limits if told.name in shown):
        values = result[told.name]
        near, (low, high) = 1e-6 * np.abs(values).max(), told.numbers
        below = low is not None and values.min() < low - near
        if below or (high is not None and values.max() > high + near):
            wrong.append(told.name)
    assert not wrong


@pytest.mark.parametrize("name", NAMES)
def test_an_example_says_what_to_plot(name: str) -> None:
    text = (ROOT / (name.replace(".", "/") + ".pmo")).read_text(encoding="utf-8")
    assert "figures={" in text
    result = example(name)
    for curve in text.split("Curve(y=")[1:]:
        variable = curve.split(")")[0]
        assert len(np.broadcast_to(result[variable], result.time.shape)) == len(result.time)


def energy(r: Any, bodies: dict[str, tuple[float, float]]) -> Any:
    """Kinetic energy and that in the field of the earth; mass and inertia of each body."""
    total = 0.0
    for name, (mass, inertia) in bodies.items():
        speed = np.hypot(r[f"{name}.v_CM[1]"], r[f"{name}.v_CM[2]"])
        total = total + mass / 2 * speed**2 + mass * 9.81 * r[f"{name}.r_0CM[2]"]
        total = total + inertia / 2 * r[f"{name}.w"] ** 2
    return total


def lost(r: Any, power: Any) -> Any:
    """The energy that a power took since the start, by Simpson's rule on every second row."""
    from scipy.integrate import cumulative_simpson

    return cumulative_simpson(power, x=r.time, initial=0)


def swings_back(r: Any) -> None:
    total = energy(r, {"bob": (1, 0.02)})
    np.testing.assert_allclose(total, total[0], atol=1e-3)


def keeps_the_energy_of_both_links(r: Any) -> None:
    total = energy(r, {"upper.body": (1, 0.021), "lower.body": (0.8, 0.024)})
    np.testing.assert_allclose(total, total[0], atol=1e-3)


def follows_its_springs(r: Any) -> None:
    """What the springs hold and the damper takes is what the body loses."""
    pulls = []
    total = energy(r, {"body.body": (1, 0.02)})
    for spring, anchor, x in (("springLeft", "frame_a", -0.6), ("springRight", "frame_b", 0.6)):
        d = np.array([r[f"body.{anchor}.r[1]"] - x, r[f"body.{anchor}.r[2]"] - 0.5])
        length = np.hypot(*d)
        total += 30 * (length - 0.4) ** 2
        pulls.append(-r[f"{spring}.f"] * d / length)
    loss = lost(r, r["springRight.lossPower"])
    assert loss[-1] > 0.1
    np.testing.assert_allclose(total + loss, total[0], atol=1e-3)
    for i, gravity in ((0, 0.0), (1, 9.81)):
        acceleration = r[f"body.body.a_CM[{i + 1}]"] + gravity
        np.testing.assert_allclose(acceleration, pulls[0][i] + pulls[1][i], atol=1e-6)


def gives_its_energy_to_the_gas(r: Any) -> None:
    """Flap and both masses of the cylinder, the spring in it, and what its damper takes."""
    total = energy(r, {"flap.body": (4, 0.33)}) + 75 * (r["gas.s_rel"] - 1) ** 2
    for end, mass in (("a", 0.6), ("b", 0.3)):
        speed = np.hypot(r[f"cylinder.v_CM_{end}[1]"], r[f"cylinder.v_CM_{end}[2]"])
        total += mass / 2 * speed**2 + mass * 9.81 * r[f"cylinder.r_CM_{end}[2]"]
    loss = lost(r, 30 * r["gas.v_rel"] ** 2)
    assert loss[-1] > 0.1
    np.testing.assert_allclose(total + loss, total[0], atol=2e-3)
    # The gas springs from L_a on the line to the lug.
    np.testing.assert_allclose(r["gas.s_rel"], r["cylinder.s"], atol=1e-9)


def keeps_the_energy_of_its_bars(r: Any) -> None:
    bars = {"crank.body": (1, 0.0134), "coupler.body": (2, 0.14), "rocker.body": (1.5, 0.08)}
    total = energy(r, bars)
    np.testing.assert_allclose(total, total[0], rtol=5e-4)


def slides_by_its_formula(r: Any) -> None:
    phi = r["main.phi"]
    expected = 0.3 * np.cos(phi) + np.sqrt(0.8**2 - (0.3 * np.sin(phi)) ** 2)
    np.testing.assert_allclose(r["dyad.s"], expected, atol=1e-9)
    total = energy(r, {"crank.body": (1.2, 0.009), "rod": (2, 0.1), "slider": (1.5, 0.001)})
    np.testing.assert_allclose(total, total[0], atol=1e-3)


def lifts_with_the_power_of_its_drive(r: Any) -> None:
    """The cam is balanced and turns evenly: all power raises and speeds up the roller."""
    np.testing.assert_allclose(r["hinge.phi"], 4 * r.time, atol=1e-6)
    power = 0.4 * (r["slide.a"] + 9.81) * r["slide.v"]
    assert np.ptp(power) > 1
    np.testing.assert_allclose(4 * r["hinge.tau"], power, atol=1e-6 * np.max(np.abs(power)))


def comes_to_rest(r: Any) -> None:
    assert abs(r["hinge.w"][-1]) < 0.05
    carried = r["strut.frame_b.f[2]"][-1] * np.cos(r["hinge.phi"][-1])
    carried -= r["strut.frame_b.f[1]"][-1] * np.sin(r["hinge.phi"][-1])
    # The strut's moment about the hinge holds the weight at 0.4 m.
    assert -carried * 0.8 == pytest.approx(9.81 * 0.4 * np.cos(r["hinge.phi"][-1]), abs=0.1)


def keeps_its_orbits(r: Any) -> None:
    np.testing.assert_allclose(r["circle.r[1]"], np.cos(r.time), atol=1e-5)
    area = r["ellipse.r[1]"] * r["ellipse.v[2]"] - r["ellipse.r[2]"] * r["ellipse.v[1]"]
    np.testing.assert_allclose(area, area[0], atol=1e-6)


def rests_where_the_spring_is_free(r: Any) -> None:
    assert r["rail.s"][-1] == pytest.approx(0.5, abs=2e-3)


def sticks_and_slides(r: Any) -> None:
    stuck = np.abs(r["hinge.w"]) < 1e-9
    assert 0.05 < np.mean(stuck) < 0.95
    assert np.max(np.abs(r["bearing.tau"])) <= 1.8 + 1e-6


def bounces_lower_each_time(r: Any) -> None:
    """Impacts at t1*(1 + 2e + 2e^2 + ...), t1 = sqrt(2h/g)."""
    first = np.sqrt(2 / 9.81)
    times = [first * (1 + 2 * sum(0.8**k for k in range(1, n + 1))) for n in range(6)]
    np.testing.assert_allclose([e.time for e in r.events], times, atol=1e-5)


def holds_its_rods(r: Any) -> None:
    for rod, length in (("rod1", 1.3), ("rod2", 1.4)):
        d = [r[f"{rod}.frame_b.r[{i}]"] - r[f"{rod}.frame_a.r[{i}]"] for i in (1, 2)]
        np.testing.assert_allclose(np.hypot(*d), length, atol=1e-8)


def moves_like_two_loops(r: Any) -> None:
    other = example("Loops.TwoLoops")
    for joint in ("revA", "revD", "revG"):
        np.testing.assert_allclose(r[f"{joint}.phi"], other[f"{joint}.phi"], atol=2e-3)


def agrees_with_the_test_set(r: Any) -> None:
    """beta at 0.03 s, E. Hairer and G. Wanner, section VI.9."""
    assert r["beta.phi"][-1] == pytest.approx(15.81077, abs=5e-3)


def stays_a_parallelogram(r: Any) -> None:
    for i in (2, 3):
        np.testing.assert_allclose(r[f"rev[{i}].phi"], r["rev[1].phi"], atol=1e-5)


def follows_the_cam(r: Any) -> None:
    phi = r["hinge.phi"]
    lift = np.sqrt((0.15 * np.sin(phi)) ** 2 + (0.08 * np.cos(phi)) ** 2)
    np.testing.assert_allclose(r["slide.s"], lift, atol=2e-4)


def stays_on_its_circles(r: Any) -> None:
    np.testing.assert_allclose(np.hypot(r["outer_.r[1]"], r["outer_.r[2]"]), 0.7, atol=1e-9)
    np.testing.assert_allclose(np.hypot(r["inner_.r[1]"], r["inner_.r[2]"] - 1.2), 0.3, atol=1e-9)


def touches_the_parabola(r: Any) -> None:
    x, y = r["contact.s1"], 0.8 * r["contact.s1"] ** 2
    slope = np.hypot(1, 1.6 * x)
    np.testing.assert_allclose(r["disc.r[1]"], x - 0.2 * 1.6 * x / slope, atol=1e-9)
    np.testing.assert_allclose(r["disc.r[2]"], y + 0.2 / slope, atol=1e-9)


def returns_quickly(r: Any) -> None:
    late = r.time > 3
    v = r["ramSlide.v"][late]
    assert np.mean(v > 0) < 0.45  # the way back takes less time
    assert np.mean(r["rotor.w"][late]) == pytest.approx(60, abs=1.5)


def reaches_its_lengths(r: Any) -> None:
    assert r["boomCylinder.s"][-1] == pytest.approx(1.3, abs=2e-3)
    assert r["stickCylinder.s"][-1] == pytest.approx(1.6, abs=2e-3)


def loses_energy_to_its_load_only(r: Any) -> None:
    assert 0 < r["main.w"][-1] < r["main.w"][0]
    np.testing.assert_allclose(r["dyad.s"], r["piston.r[1]"], atol=1e-12)


def bounces_until_it_rolls(r: Any) -> None:
    rest = r["contact.rigid[1].rest"][-1]
    assert rest == pytest.approx((1 + 0.7) / (1 - 0.7) * np.sqrt(2 / 9.81), rel=1e-6)
    assert r["contact.touches[1]"][-1] == 1
    assert r["ball.v[1]"][-1] == pytest.approx(0.6 / 1.4, rel=1e-6)
    assert r["ball.w"][-1] == pytest.approx(-6 / 1.4, rel=1e-6)


def yields_where_it_lands(r: Any) -> None:
    gap = r["contact.gap[1]"]
    assert -0.005 < gap.min() < 0
    speeds = r["ball.v[2]"]
    below = gap < 0
    first = np.flatnonzero(np.diff(below.astype(int)))[:2]
    ratio = -speeds[first[1] + 1] / speeds[first[0] + 1]
    assert ratio == pytest.approx(0.7, abs=0.05)


def falls_off_its_ledge(r: Any) -> None:
    touched = np.flatnonzero(r["contact.touches[1]"])
    assert r["ball.v[1]"][touched].min() == pytest.approx(1 / 1.4, rel=1e-5)
    assert np.abs(r["contact.gap[1]"][touched]).max() < 1e-6
    assert 1 < r["ball.r[1]"][touched].max() < 1.101
    assert r["ball.r[2]"][-1] < 0


def rocks_from_corner_to_corner(r: Any) -> None:
    times = [e.time for e in r.events]
    known = [0.563675757046, 1.253475910082, 1.799165833335, 2.256553860618]
    np.testing.assert_allclose(times, known, atol=1e-4)


def rolls_in_its_bowl(r: Any) -> None:
    lean = np.arctan2(r["body.r[1]"], -r["body.r[2]"])
    np.testing.assert_allclose(r["body.phi"], -0.69 / 0.31 * lean, atol=1e-5)
    np.testing.assert_allclose(np.hypot(r["body.r[1]"], r["body.r[2]"]), 0.69, atol=1e-6)
    assert lean.min() < -0.29 and not r.events


def passes_the_blow_on(r: Any) -> None:
    assert r["hinge[5].phi"].max() == pytest.approx(0.5, abs=1e-3)
    assert r["hinge[1].phi"].min() == pytest.approx(-0.5, abs=1e-3)
    assert max(np.abs(r[f"hinge[{i}].phi"]).max() for i in (2, 3, 4)) < 1e-5


def closes_on_its_stop(r: Any) -> None:
    """About the spring's rest at -1 rad the door swings with sqrt(c/I), whatever it struck."""
    swing = np.sqrt(2 / (1.1 + 20 * 0.4**2))
    radius = np.hypot(1, 4 / swing)
    opens = np.arcsin(2.5 / radius) - np.arcsin(1 / radius)
    back = 0.4 * np.sqrt(radius**2 - 2.5**2)
    radius = np.hypot(2.5, back)
    times = [opens, opens + np.arccos(1 / radius) - np.arctan2(back, 2.5)]
    speed = np.sqrt(radius**2 - 1)
    for _ in range(6):
        speed *= 0.4
        times.append(times[-1] + 2 * np.arctan(speed))
    np.testing.assert_allclose([e.time for e in r.events][:8], np.array(times) / swing, atol=1e-6)
    assert r["hinge.phi"][-1] == pytest.approx(0, abs=1e-9)
    assert r["stops.tau"][-1] == pytest.approx(2, rel=1e-9)


def rattles_in_its_clearance(r: Any) -> None:
    away = np.hypot(r["hinge.d[1]"], r["hinge.d[2]"])
    assert away.max() == pytest.approx(2e-3, abs=1e-6)
    assert away[r["hinge.f[1]"] != 0] == pytest.approx(2e-3, abs=1e-6)
    turn = 20 * r["time"]
    ideal = 0.1 * np.cos(turn) + np.sqrt(0.09 - 0.01 * np.sin(turn) ** 2)
    assert 2e-3 < np.abs(r["guide.s"] - ideal).max() < 2.2e-3
    assert sum("impact" in e.causes[0] for e in r.events) > 10


def rattles_where_the_load_cannot_follow(r: Any) -> None:
    """The motor slows down faster than the bar does, whose weight turns the wheel, too."""
    from scipy.optimize import brentq

    falls = 9.81 * 0.5 / (0.5 + 0.01 / 0.05**2)
    part = 0.05 / 2  # height of the bar by the motor's angle
    parts = np.arcsin(falls / (part * 0.3 * 20**2)) / 20

    def drive(t: Any) -> Any:
        return part * (5 * t + 0.3 * np.sin(20 * t))

    def play(t: float) -> float:
        speed = part * (5 + 6 * np.cos(20 * parts))
        flight = drive(parts) + speed * (t - parts) - falls / 2 * (t - parts) ** 2
        return float(2e-3 - 2 * (flight - drive(t)))  # at the pitch circle

    assert r.events[0].causes == ("`gear.ahead` of `shaft1` and `wheel`: lets go",)
    assert r.events[0].time == pytest.approx(parts, abs=1e-6)
    meets = brentq(lambda t: play(t) + 2e-3, parts + 1e-3, 0.12)
    assert r.events[1].causes[0].startswith("`gear.behind` of `shaft1` and `wheel`: impact")
    assert r.events[1].time == pytest.approx(meets, abs=1e-6)
    held = r["gear.f"] < -1e-6  # N
    np.testing.assert_allclose(r["slide.s"][held], drive(r["time"])[held], atol=1e-7)


def runs_down_and_sticks(r: Any) -> None:
    assert abs(r["shaft.w"][-1]) < 1e-6
    taken = sum(r[f"{joint}.lossPower"] for joint in ("pin", "hinge", "guide"))
    assert taken.min() > -1e-9
    height = 9.81 * (r["crank.body.r_0CM[2]"] + 0.5 * r["rod.body.r_0CM[2]"])
    pieces = (("crank", 1, 0.05), ("rod", 0.5, 0.004), ("slider", 1, 0.01))
    energy = height[0] - height[-1]
    for name, mass, inertia in pieces:
        body = name if name == "slider" else f"{name}.body"
        speed = r[f"{body}.v_CM[1]"][0] ** 2 + r[f"{body}.v_CM[2]"][0] ** 2
        energy += mass * speed / 2 + inertia * r[f"{body}.w"][0] ** 2 / 2
    assert np.trapezoid(taken, r["time"]) == pytest.approx(energy, rel=2e-3)
    assert any("sticks" in cause for cause in r.events[-1].causes)


def rests_on_the_floor_of_its_box(r: Any) -> None:
    weight = 24 * 9.81
    assert np.mean(r["crowd.f_b[2]"][-50:]) == pytest.approx(-weight, rel=0.02)
    assert max(abs(r[f"body[{i}].v[2]"][-1]) for i in range(1, 25)) < 0.05
    energy = sum(
        (r[f"body[{i}].v[1]"] ** 2 + r[f"body[{i}].v[2]"] ** 2) / 2
        + 0.001 * r[f"body[{i}].w"] ** 2
        + 9.81 * r[f"body[{i}].r[2]"]
        for i in range(1, 25)
    )
    assert np.diff(energy).max() < 1e-4 * energy[0]


LAWS: dict[str, Callable[[Any], None]] = {
    "Elementary.Pendulum": swings_back,
    "Elementary.DoublePendulum": keeps_the_energy_of_both_links,
    "Elementary.FreeBody": follows_its_springs,
    "Elementary.LineForceWithTwoMasses": gives_its_energy_to_the_gas,
    "Elementary.PendulumWithSpringDamper": comes_to_rest,
    "Elementary.PointGravity": keeps_its_orbits,
    "Elementary.SpringDamperSystem": rests_where_the_spring_is_free,
    "Elementary.DrivenPendulum": sticks_and_slides,
    "Elementary.BouncingMass": bounces_lower_each_time,
    "Contacts.BouncingBall": bounces_until_it_rolls,
    "Contacts.SoftLanding": yields_where_it_lands,
    "Contacts.OffTheLedge": falls_off_its_ledge,
    "Contacts.RockingBlock": rocks_from_corner_to_corner,
    "Contacts.RockerInBowl": rolls_in_its_bowl,
    "Contacts.NewtonsCradle": passes_the_blow_on,
    "Contacts.SwingDoor": closes_on_its_stop,
    "Contacts.WornSliderCrank": rattles_in_its_clearance,
    "Contacts.RattlingGears": rattles_where_the_load_cannot_follow,
    "Contacts.FullBox": rests_on_the_floor_of_its_box,
    "Loops.FourBar": keeps_the_energy_of_its_bars,
    "Loops.CrankSlider": slides_by_its_formula,
    "Loops.RubbingCrankSlider": runs_down_and_sticks,
    "Loops.TwoLoops": holds_its_rods,
    "Loops.TwoLoopsWithRevolutes": moves_like_two_loops,
    "Loops.AndrewsSqueezer": agrees_with_the_test_set,
    "Loops.NFourBar": stays_a_parallelogram,
    "Loops.PistonEngine": loses_energy_to_its_load_only,
    "CurveCurveJoint.CamFollower": follows_the_cam,
    "CurveCurveJoint.SplineCam": follows_the_cam,
    "CurveCurveJoint.SinusEllipse": lifts_with_the_power_of_its_drive,
    "CurveCurveJoint.CurveCurveJointSwitchSides": stays_on_its_circles,
    "CurveCurveJoint.OwnCurve": touches_the_parabola,
    "Systems.QuickReturn": returns_quickly,
    "Systems.Excavator": reaches_its_lengths,
}
