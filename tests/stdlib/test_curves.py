"""Contact curves: their geometry, their drawing, and what they do in a contact."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import planarc

Run = Callable[..., Any]

ELLIPSE = "Curves.Ellipse curve(a=0.3, b=0.2, {})"
CURVES = {
    "Circle": "Curves.Circle curve(R=0.3, {})",
    "StraightLine": "Curves.StraightLine curve({})",
    "Ellipse": ELLIPSE,
    "SinusEllipse": "Curves.SinusEllipse curve(a=0.3, b=0.2, A=0.05, k=4, {})",
    "Spline": "Curves.Spline curve(points={{{{0.3, 0}}, {{0.1, 0.2}}, {{-0.2, 0.1}},"
    " {{0, -0.2}}}}, {})",
    "open Spline": "Curves.Spline curve(closed=false, points={{{{-0.3, 0}}, {{0, -0.2}},"
    " {{0.3, 0.1}}}}, {})",
    "Polar": "Curves.Polar curve(R=0.2, redeclare function radius=egg, {})",
}
EGG = """
  function egg
    extends Interfaces.partialCurveRadius;
  algorithm
    radius := 0.2 + 0.03*cos(2*phi);
  end egg;
"""
INPUTS = "r_0={0, 0}, phi=0"


def walk(run: Run, curve: str) -> Any:
    """Position, tangent and normal along a curve, from s_min to s_max in one second."""
    return run(
        f"""{EGG}  {curve.format(INPUTS)};
  Real s = curve.s_min + (curve.s_max - curve.s_min)*time;
  Real r[2] = curve.position(s);
  Real t[2] = curve.tangent(s);
  Real n[2] = curve.normal(s);
"""
    )


def vectors(result: Any, name: str) -> Any:
    columns = [np.broadcast_to(result[f"{name}[{i}]"], result.time.shape) for i in (1, 2)]
    return np.array(columns)


@pytest.mark.parametrize("name", CURVES)
def test_the_tangent_is_the_direction_of_the_curve(run: Run, name: str) -> None:
    result = walk(run, CURVES[name])
    r, t, n = (vectors(result, v) for v in "rtn")
    np.testing.assert_allclose(np.linalg.norm(t, axis=0), 1, atol=1e-12)
    np.testing.assert_array_almost_equal(n, [t[1], -t[0]], 12)
    secant = r[:, 2:] - r[:, :-2]
    secant /= np.linalg.norm(secant, axis=0)
    np.testing.assert_allclose(secant, t[:, 1:-1], atol=2e-2)


@pytest.mark.parametrize("name", [n for n in CURVES if n not in ("StraightLine", "open Spline")])
def test_a_closed_curve_closes_and_its_normal_points_outward(run: Run, name: str) -> None:
    result = walk(run, CURVES[name])
    r, t, n = (vectors(result, v) for v in "rtn")
    np.testing.assert_allclose(r[:, 0], r[:, -1], atol=1e-12)
    np.testing.assert_allclose(t[:, 0], t[:, -1], atol=1e-9)
    area = 0.5 * np.sum(r[0, :-1] * r[1, 1:] - r[0, 1:] * r[1, :-1])
    assert area > 0  # counter-clockwise
    assert np.mean(np.sum(r * n, axis=0)) > 0


def test_a_spline_passes_its_points_smoothly(run: Run) -> None:
    points = np.array([[0.3, 0], [0.1, 0.2], [-0.2, 0.1], [0, -0.2]])
    chords = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    at = ", ".join(str(s) for s in np.cumsum([0, *chords]))
    result = run(
        f"""  {CURVES["Spline"].format(INPUTS)};
  parameter Real s[5] = {{{at}}};
  Real r[5, 2] = {{curve.position(s[i]) for i in 1:5}};
  Real before[5, 2] = {{curve.tangent(s[i] - 1e-7) for i in 1:5}};
  Real after[5, 2] = {{curve.tangent(s[i] + 1e-7) for i in 1:5}};
"""
    )

    def table(name: str) -> Any:
        return np.array([[result[f"{name}[{i},{k}]"][0] for k in (1, 2)] for i in range(1, 6)])

    np.testing.assert_allclose(table("r"), [*points, points[0]], atol=1e-12)
    np.testing.assert_allclose(table("before"), table("after"), atol=1e-5)


@pytest.mark.parametrize(("closed", "n"), [("true", 40), ("false", 33), ("false", 17)])
def test_a_spline_through_many_points_passes_them_all(run: Run, closed: str, n: int) -> None:
    """Pieces are looked for in groups; each must be found, and only once."""
    turn = 2 * np.pi * np.arange(n) / (n if closed == "true" else n - 1) * 0.9
    points = np.column_stack([0.3 * np.sin(turn), -0.2 * np.cos(turn)])
    text = ", ".join(f"{{{x}, {y}}}" for x, y in points)
    result = run(
        f"""
  Curves.Spline curve(closed={closed}, points={{{text}}}, {INPUTS});
  Real s = curve.s_min + (curve.s_max - curve.s_min)*time;
  Real r[2] = curve.position(s);
  Real known[2] = curve.position(curve.s_max*0.37);
"""
    )
    chain = np.vstack([points, points[:1]]) if closed == "true" else points
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))])
    law = CubicSpline(s, chain, bc_type="periodic" if closed == "true" else "natural")
    at = np.clip(result["s"], 0, s[-1])
    expected = law(at)
    np.testing.assert_allclose(vectors(result, "r").T, expected, atol=1e-12)
    np.testing.assert_allclose(
        [result[f"known[{i}]"][0] for i in (1, 2)], law(0.37 * s[-1]), atol=1e-12
    )


def cam_follower(run: Run, curve: str, tolerance: float = 1e-7, s1: float = 0.24) -> Any:
    return run(
        f"""
  Joints.Revolute hinge(phi(start=0.8, fixed=true), w(fixed=true));
  Parts.Body cam(m=2, I=0.01, r_CM={{0.2, 0.03}});
  Joints.CurveCurveJoint contact(redeclare Curves.{curve},
    redeclare Curves.StraightLine curve2, s1(start={s1}));
  Joints.Prismatic slide(n={{0, 1}}, s(start=0.12));
  Parts.Body follower(m=0.5);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, cam.frame_a);
  connect(hinge.frame_b, contact.frame_a);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, follower.frame_a);
  connect(slide.frame_b, contact.frame_b);
""",
        tolerance=tolerance,
    )


def test_a_spline_through_the_points_of_an_ellipse_becomes_the_ellipse(run: Run) -> None:
    """The force needs the curvature, whose error falls with the square of the spacing."""
    exact = cam_follower(run, "Ellipse curve1(a=0.15, b=0.08)")
    errors = []
    for n in (12, 24, 48):
        turn = f"2*Modelica.Constants.pi*i/{n}"
        points = f"{{{{0.15*sin({turn}), -0.08*cos({turn})}} for i in 0:{n - 1}}}"
        spline = cam_follower(run, f"Spline curve1(points={points})")
        force = spline["contact.f_N"] - exact["contact.f_N"]
        motion = spline["hinge.phi"] - exact["hinge.phi"]
        errors.append((np.sqrt(np.mean(force**2)), np.max(np.abs(motion))))
    assert errors[0][0] > 3 * errors[1][0] > 9 * errors[2][0]
    assert errors[0][1] > 3 * errors[1][1] > 9 * errors[2][1]
    assert errors[2][1] < 1e-4
    # The force has kinks where the third derivative jumps, and no steps.
    largest = [np.max(np.abs(np.diff(r["contact.f_N"]))) for r in (spline, exact)]
    assert largest[0] < 1.2 * largest[1]


def test_a_polar_circle_is_a_circle_and_an_even_ellipse_too(run: Run) -> None:
    first = cam_follower(run, "Circle curve1(R=0.1)", 1e-9)
    for other in ("Polar curve1(R=0.1)", "Ellipse curve1(a=0.1, b=0.1)"):
        second = cam_follower(run, other, 1e-9)
        np.testing.assert_allclose(second["hinge.phi"], first["hinge.phi"], atol=1e-6)
        np.testing.assert_allclose(second["contact.f_N"], first["contact.f_N"], atol=1e-5)


@pytest.mark.parametrize(("switch", "distance"), [("true", 0.3), ("false", 0.7)])
def test_switching_sides_puts_the_disc_inside(run: Run, switch: str, distance: float) -> None:
    result = run(
        f"""
  Joints.CurveCurveJoint contact(curve1(R=0.5, switchSide={switch}), curve2(R=0.2),
    s1(start=1.2), s2(start={0.48 if switch == "true" else 1.1}));
  Parts.Body disc(m=1, I=0.01, phi(fixed=true), w(fixed=true), r(start={{{distance * 0.7},
    {distance * 0.7}}}, fixed={{true, false}}), v(fixed={{true, false}}));
equation
  connect(world.frame_b, contact.frame_a);
  connect(contact.frame_b, disc.frame_a);
"""
    )
    np.testing.assert_allclose(np.hypot(result["disc.r[1]"], result["disc.r[2]"]), distance)
    x, y = (result[f"contact.normal1[{i}]"] + result[f"contact.normal2[{i}]"] for i in (1, 2))
    np.testing.assert_allclose([x, y], 0, atol=1e-9)


def test_a_contact_sought_on_the_wrong_side_is_found_on_the_right_one(run: Run) -> None:
    """Below the cam the normals point the same way, which `atan2` does not accept."""
    right = cam_follower(run, "Ellipse curve1(a=0.15, b=0.08)")
    wrong = cam_follower(run, "Ellipse curve1(a=0.15, b=0.08)", s1=0.6)
    np.testing.assert_allclose(wrong["slide.s"], right["slide.s"], atol=1e-9)


def test_separation_is_detected_where_the_force_changes_its_sign(run: Run) -> None:
    """A disc on top of a circle leaves it where cos(angle) = 2/3."""
    result = run(
        """
  Joints.CurveCurveJoint contact(curve1(R=0.8), curve2(R=0.2), detectSeparation=true,
    s1(start=0.8*3.24), s2(start=0.02));
  Parts.PointMass disc(m=1, r(start={0.1, 0.995}, fixed={true, false}),
    v(fixed={true, false}));
  Parts.Body wheel(m=0, I=0.01, phi(fixed=true), w(fixed=true));
equation
  connect(world.frame_b, contact.frame_a);
  connect(contact.frame_b, disc.frame_a);
  connect(contact.frame_b, wheel.frame_a);
"""
    )
    assert len(result.events) == 1
    last = np.searchsorted(result.time, result.events[0].time)
    height = result["disc.r[2]"][last]
    assert height == pytest.approx(2 / 3 * np.sqrt(0.99), abs=1e-6)
    assert result["contact.inContact"][0] == 1
    assert result["contact.inContact"][-1] == 0


def test_a_curve_is_drawn_through_its_points(run: Run) -> None:
    from planarc.view.scene import make_scene

    result = run(f"  {ELLIPSE.format(INPUTS + ', ns=5')};")
    (item,) = (i for i in make_scene(result).items if i.points)
    np.testing.assert_allclose(
        item.points, [[0, -0.2], [0.3, 0], [0, 0.2], [-0.3, 0], [0, -0.2]], atol=1e-12
    )


def test_older_names_of_curves_work_and_tell_the_new_ones(tmp_path: Path) -> None:
    file = tmp_path / "old.pmo"
    file.write_text(
        "model M\n"
        "  extends PlanarMultiBody.Examples.CurveCurveJoint.CamFollower(contact(\n"
        "    redeclare PlanarMultiBody.Joints.Internal.Ellipse curve1(a=0.15, b=0.08),\n"
        "    redeclare Flat curve2));\n"
        "  model Flat\n"
        "    extends PlanarMultiBody.Joints.Internal.StraightLine(s_min=-0.1, s_max=0.1);\n"
        "  end Flat;\n"
        "end M;\n",
        "utf-8",
    )
    model = planarc.load(file)
    old = model.simulate(0.2, tolerance=1e-8, intervals=20)
    new = planarc.load("PlanarMultiBody.Examples.CurveCurveJoint.CamFollower").simulate(
        0.2, tolerance=1e-8, intervals=20
    )
    assert np.array_equal(old["contact.f_N"], new["contact.f_N"])
    found = [(d.code, d.span.line, d.hint) for d in model.warnings if d.span is not None]
    assert found == [
        ("F266", 3, "use `PlanarMultiBody.Curves.Ellipse`"),
        ("F266", 6, "use `PlanarMultiBody.Curves.StraightLine`"),
    ]
