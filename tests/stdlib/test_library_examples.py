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
    from planarc.request import Request

    program = compile_model(Request(class_name=f"PlanarMultiBody.Examples.{name}"))
    return run(program, RunOptions(backend=Backend(backend)))


@both_backends
@pytest.mark.parametrize("name", NAMES)
def test_an_example_runs_to_its_end_and_is_drawn(name: str, backend: str) -> None:
    from planarc.view.scene import make_scene

    result = example(name, backend)
    assert result.ended is None
    # Contacts are two-sided; a run tells when one pulled, which some examples mean to show.
    assert all("the contact pulls" in w.message for w in result.warnings)
    assert result.time[-1] == result.program.experiment.stop
    scene = make_scene(result)
    assert not scene.notes
    assert scene.items


@pytest.mark.parametrize("name", NAMES)
def test_an_example_says_what_to_plot(name: str) -> None:
    text = (ROOT / (name.replace(".", "/") + ".pmo")).read_text(encoding="utf-8")
    assert "figures={" in text
    result = example(name)
    for curve in text.split("Curve(y=")[1:]:
        variable = curve.split(")")[0]
        assert len(np.broadcast_to(result[variable], result.time.shape)) == len(result.time)


def swings_back(r: Any) -> None:
    speed = np.hypot(r["bob.v_CM[1]"], r["bob.v_CM[2]"])
    energy = speed**2 / 2 + 0.01 * r["bob.w"] ** 2 + 9.81 * r["bob.r_0CM[2]"]
    np.testing.assert_allclose(energy, energy[0], atol=0.01)


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


LAWS: dict[str, Callable[[Any], None]] = {
    "Elementary.Pendulum": swings_back,
    "Elementary.PendulumWithSpringDamper": comes_to_rest,
    "Elementary.PointGravity": keeps_its_orbits,
    "Elementary.SpringDamperSystem": rests_where_the_spring_is_free,
    "Elementary.DrivenPendulum": sticks_and_slides,
    "Elementary.BouncingMass": bounces_lower_each_time,
    "Loops.TwoLoops": holds_its_rods,
    "Loops.TwoLoopsWithRevolutes": moves_like_two_loops,
    "Loops.AndrewsSqueezer": agrees_with_the_test_set,
    "Loops.NFourBar": stays_a_parallelogram,
    "Loops.PistonEngine": loses_energy_to_its_load_only,
    "CurveCurveJoint.CamFollower": follows_the_cam,
    "CurveCurveJoint.SplineCam": follows_the_cam,
    "CurveCurveJoint.CurveCurveJointSwitchSides": stays_on_its_circles,
    "CurveCurveJoint.OwnCurve": touches_the_parabola,
    "Systems.QuickReturn": returns_quickly,
    "Systems.Excavator": reaches_its_lengths,
}


@pytest.mark.parametrize("name", LAWS)
def test_an_example_obeys_its_law(name: str) -> None:
    LAWS[name](example(name))
