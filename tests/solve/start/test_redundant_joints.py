"""Redundant joints accepted: the motion is that without them, the forces are of least squares."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.solve.kernels.numpy.kernel import NumpyKernel

G = 9.81


def bars(
    places: Sequence[float],
    *,
    lengths: Sequence[float] | None = None,
    centre: float = 0.5,
    start: str = "phi(start=0.3, fixed=true), w(start=0.5, fixed=true)",
    order: int | None = None,
) -> str:
    """A beam of 2 kg on massless bars of 1 m, hinged to the ground at some places; `order`
    shuffles components and connections, and which end of a hinge comes first."""
    rng = random.Random(order)
    lengths = lengths or [1.0] * len(places)
    parts = [
        "P.Parts.Fixed g;",
        f"P.Parts.Body beam(m=2, I=0.3, r_CM={{{centre}, 0.1}});",
    ]
    ties = []
    for i, (x, length) in enumerate(zip(places, lengths, strict=True)):
        first = f"({start})" if i == 0 else "(phi(start=0.3))"
        ends = ("frame_a", "frame_b")
        if order is not None and i and rng.random() < 0.5:
            first, ends = "(phi(start=-0.3))", ("frame_b", "frame_a")
        parts += [
            f"P.Joints.Revolute low{i}{first};",
            f"P.Joints.Revolute high{i};",
            f"P.Parts.FixedTranslation bar{i}(r={{0, {length}}});",
            f"P.Parts.FixedTranslation base{i}(r={{{x}, 0}});",
            f"P.Parts.FixedTranslation top{i}(r={{{x}, 0}});",
        ]
        ties += [
            f"connect(g.frame_b, base{i}.frame_a);",
            f"connect(base{i}.frame_b, low{i}.{ends[0]});",
            f"connect(low{i}.{ends[1]}, bar{i}.frame_a);",
            f"connect(bar{i}.frame_b, high{i}.frame_a);",
            f"connect(high{i}.frame_b, top{i}.frame_b);",
            f"connect(top{i}.frame_a, beam.frame_a);",
        ]
    if order is not None:
        rng.shuffle(parts)
        rng.shuffle(ties)
    body = "\n  ".join(["inner P.World world;", *parts])
    return f"model M\n  import P = PlanarMultiBody;\n  {body}\nequation\n  {' '.join(ties)}\nend M;"


def accepted(text: str, backend: str | None = None) -> planarc.Model:
    return planarc.load(text, redundant="accept", backend=backend)


def code_of(result: Any) -> list[str]:
    return [w.code for w in result.warnings]


@pytest.fixture(scope="module")
def three() -> planarc.Result:
    return accepted(bars([0, 1, 2], centre=1.0)).simulate(1.0, tolerance=1e-9)


def on_beam(result: planarc.Result, i: int) -> np.ndarray:
    """The force of bar i on the beam, a row for each time."""
    return -np.asarray(result[f"high{i}.frame_b.f"])


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_third_massless_bar_does_not_change_the_motion(backend: str) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    options: dict[str, Any] = {"tolerance": 1e-9, "intervals": 50}
    two = planarc.load(bars([0, 1]), backend=backend).simulate(1.0, **options)
    more = accepted(bars([0, 1, 2]), backend).simulate(1.0, **options)
    for name in ("low0.phi", "low0.w", "beam.r_0CM[1]", "beam.a_CM[2]", "high1.phi"):
        np.testing.assert_allclose(more[name], two[name], rtol=1e-6, atol=1e-7)
    # The bars that were there before and the new one carry together what two carried.
    held = on_beam(two, 0) + on_beam(two, 1)
    np.testing.assert_allclose(sum(on_beam(more, i) for i in range(3)), held, rtol=1e-6)


def test_it_says_which_joints_share_and_that_the_motion_does_not_depend_on_it(
    three: planarc.Result,
) -> None:
    (note,) = three.warnings
    assert note.code == "R416"
    assert note.severity.value == "note"
    for i in range(3):
        assert f"`low{i}`" in note.message
        assert f"`high{i}`" in note.message
    assert "1 of their forces and torques is not determined" in note.message
    assert "the motion does not depend on them" in note.message


def test_bars_that_lie_symmetrically_carry_the_same(three: planarc.Result) -> None:
    """The centre of mass is above the middle bar, and the beam does not turn; what the lever
    of 0.1 m makes of the forces along the bars is shared as +d, 0, -d."""
    left, middle, right = (on_beam(three, i) for i in range(3))
    np.testing.assert_allclose(left + right, 2 * middle, rtol=1e-6, atol=1e-6)
    level = accepted(bars([0, 1, 2], centre=1.0).replace("{1.0, 0.1}", "{1.0, 0}"))
    run = level.simulate(0.3)
    np.testing.assert_allclose(on_beam(run, 0), on_beam(run, 2), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(on_beam(run, 0), on_beam(run, 1), rtol=1e-8, atol=1e-8)


def test_momentum_and_energy_are_balanced(three: planarc.Result) -> None:
    total = sum(on_beam(three, i) for i in range(3))
    a = np.asarray(three["beam.a_CM"])
    np.testing.assert_allclose(total, 2 * (a + np.array([0, G])), rtol=1e-8, atol=1e-8)
    v, y = np.asarray(three["beam.v_CM"]), three["beam.r_0CM[2]"]
    energy = (v * v).sum(axis=1) + 2 * G * y
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)


@pytest.mark.parametrize("places", [[0, 1, 2, 3], [0, 0.7, 2, 2.5, 4]])
def test_more_bars_share_linearly_in_their_places(places: list[float]) -> None:
    """Forces N along parallel bars have a given sum and a given moment. Their least squares are
    N_i = p + q*x_i."""
    run = accepted(bars(places)).simulate(0.5, intervals=20)
    assert code_of(run) == ["R416"]
    along = np.array([on_beam(run, i)[:, 1] for i in range(len(places))])
    for column in along.T:
        fit = np.polyfit(places, column, 1)
        np.testing.assert_allclose(np.polyval(fit, places), column, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("order", range(4))
def test_the_order_of_components_does_not_matter(order: int, three: planarc.Result) -> None:
    text = bars([0, 1, 2], centre=1.0, order=order)
    run = accepted(text).simulate(1.0, tolerance=1e-9, intervals=4)
    for i in range(3):
        sign = 1 if f"base{i}.frame_b, low{i}.frame_a" in text else -1
        found = np.asarray(run[f"low{i}.frame_{'b' if sign > 0 else 'a'}.f"])
        known = np.asarray(three[f"low{i}.frame_b.f"])[::125]
        np.testing.assert_allclose(found, known, rtol=1e-6, atol=1e-6)


SLIDES = """
model Slides "A carriage of 2 kg on two rails along y, 1 m apart, pushed by 3 N across"
  import P = PlanarMultiBody;
  inner P.World world;
  P.Parts.Fixed left(r={-0.5, 0}), right(r={0.5, 0});
  P.Joints.Prismatic a(n={0, 1}, s(start=1, fixed=true), v(fixed=true)), b(n={0, 1});
  P.Parts.FixedTranslation toA(r={-0.5, 0}), toB(r={0.5, 0});
  P.Parts.Body body(m=2, I=0.1);
  P.Forces.WorldForce push;
equation
  push.force = {3, 0};
  connect(left.frame_b, a.frame_a);
  connect(right.frame_b, b.frame_a);
  connect(a.frame_b, toA.frame_b);
  connect(b.frame_b, toB.frame_b);
  connect(toA.frame_a, body.frame_a);
  connect(toB.frame_a, body.frame_a);
  connect(push.frame_b, body.frame_a);
end Slides;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_two_slides_side_by_side_share_by_halves(backend: str) -> None:
    """By hand: the push is shared by halves, f = -3/2 on each slide's far end. It acts on one
    line with them, so that the torques t at both far ends add to nothing; those at the near
    ends are -t - s*3/2 and -(-t) - s*3/2. The sum of squares is least for t = 0."""
    if backend == "native":
        pytest.importorskip("llvmlite")
    run = accepted(SLIDES, backend).simulate(0.5, tolerance=1e-9)
    assert "2 of their forces and torques are not determined" in run.warnings[0].message
    np.testing.assert_allclose(run["a.s"], 1 - G / 2 * run.time**2, atol=1e-6)
    for slide in "ab":
        np.testing.assert_allclose(run[f"{slide}.frame_b.f[1]"], 1.5, rtol=1e-9)
        np.testing.assert_allclose(run[f"{slide}.frame_b.t"], 0, atol=1e-9)
        np.testing.assert_allclose(run[f"{slide}.frame_a.t"], 1.5 * run["a.s"], rtol=1e-6)


PLATE = """
model Plate "A plate of 3 kg on two pins, 1 m apart, pushed by 4 N along the line between them"
  import P = PlanarMultiBody;
  inner P.World world;
  P.Parts.Fixed left, right(r={1, 0});
  P.Joints.Revolute p, q;
  P.Parts.FixedTranslation arm(r={WIDE, 0});
  P.Parts.Body plate(m=3, I=0.1, r_CM={0.25, 0.2});
  P.Forces.WorldForce push;
equation
  push.force = {4, 0};
  connect(left.frame_b, p.frame_a);
  connect(p.frame_b, arm.frame_a);
  connect(arm.frame_b, q.frame_b);
  connect(q.frame_a, right.frame_b);
  connect(plate.frame_a, arm.frame_a);
  connect(push.frame_b, plate.frame_a);
end Plate;
"""


def test_two_pins_of_a_plate_share_what_acts_between_them() -> None:
    run = accepted(PLATE.replace("WIDE", "1")).simulate(1.0, intervals=2)
    weight = 3 * G
    np.testing.assert_allclose(run["p.frame_b.f"], [[2, -0.75 * weight]] * 3, rtol=1e-12)
    np.testing.assert_allclose(run["q.frame_b.f"], [[2, -0.25 * weight]] * 3, rtol=1e-12)


def test_rigid_parts_that_close_a_loop_without_a_joint_share_too() -> None:
    text = """
    model Frame
      import P = PlanarMultiBody;
      inner P.World world;
      P.Joints.Revolute hinge(phi(start=1, fixed=true), w(fixed=true));
      P.Parts.FixedTranslation one(r={1, 0}), two(r={1, 0});
      P.Parts.Body body(m=1, I=0.1);
    equation
      connect(world.frame_b, hinge.frame_a);
      connect(hinge.frame_b, one.frame_a);
      connect(hinge.frame_b, two.frame_a);
      connect(one.frame_b, body.frame_a);
      connect(two.frame_b, body.frame_a);
    end Frame;
    """
    run = accepted(text).simulate(0.5, intervals=10, tolerance=1e-9)
    assert "`one` and `two`" in run.warnings[0].message
    np.testing.assert_allclose(run["one.frame_b.f"], run["two.frame_b.f"], rtol=1e-9)
    np.testing.assert_allclose(run["one.frame_b.t"], run["two.frame_b.t"], atol=1e-9)
    alone = planarc.load(
        text.replace("connect(hinge.frame_b, two.frame_a);", "")
        .replace("connect(two.frame_b, body.frame_a);", "")
        .replace(", two(r={1, 0})", "")
    ).simulate(0.5, intervals=10, tolerance=1e-9)
    np.testing.assert_allclose(run["hinge.phi"], alone["hinge.phi"], atol=1e-6)


def test_a_driven_mechanism_is_accepted_where_it_stays_redundant() -> None:
    text = bars([0, 1, 2], start="drivenFlange=true, phi(start=0.3)").replace(
        "equation",
        "Modelica.Mechanics.Rotational.Sources.Position drive(exact=true);\n"
        "Modelica.Blocks.Sources.Sine sine(amplitude=1, f=0.5, phase=0.3);\n"
        "equation connect(sine.y, drive.phi_ref); connect(drive.flange, low0.axis);",
        1,
    )
    run = accepted(text).simulate(1.0, intervals=20)
    assert code_of(run) == ["R416"]
    np.testing.assert_allclose(run["low2.phi"], np.sin(np.pi * run.time + 0.3), atol=1e-9)
    torque = -run["low0.frame_b.t"]  # the beam is carried parallel to itself
    a, way = np.asarray(run["beam.a_CM"]) + np.array([0, G]), np.asarray(run["bar1.r_0"])
    np.testing.assert_allclose(torque, 2 * (way[:, 0] * a[:, 1] - way[:, 1] * a[:, 0]), atol=1e-8)


def test_two_motors_that_drive_the_same_motion_share_their_torque() -> None:
    """What the motors' signal is stays said; the loop gives way. Of the hinges' torques, whose
    sum is given, and the bars' forces, those of least squares differ little by halves: the
    beam's load is nearer to the first bar."""
    text = bars([0, 1], start="drivenFlange=true, phi(start=0.3)").replace(
        "low1(phi(start=0.3))", "low1(drivenFlange=true, phi(start=0.3))"
    )
    text = text.replace(
        "equation",
        "Modelica.Mechanics.Rotational.Sources.Position d0(exact=true), d1(exact=true);\n"
        "Modelica.Blocks.Sources.Sine sine(amplitude=1, f=0.5, phase=0.3);\n"
        "equation connect(sine.y, d0.phi_ref); connect(sine.y, d1.phi_ref);\n"
        "connect(d0.flange, low0.axis); connect(d1.flange, low1.axis);",
        1,
    )
    run = accepted(text).simulate(0.5, intervals=5)
    assert code_of(run) == ["R416"]
    a, way = np.asarray(run["beam.a_CM"]) + np.array([0, G]), np.asarray(run["bar1.r_0"])
    together = -(run["low0.frame_b.t"] + run["low1.frame_b.t"])
    wanted = 2 * (way[:, 0] * a[:, 1] - way[:, 1] * a[:, 0])
    np.testing.assert_allclose(together, wanted, atol=1e-8)
    np.testing.assert_allclose(run["low0.frame_b.t"], run["low1.frame_b.t"], rtol=0.2)


# What is not accepted ------------------------------------------------------------------------


def refused(text: str) -> planarc.Diagnostic:
    with pytest.raises(planarc.PlanarcError) as caught:
        accepted(text).simulate(0.1)
    return caught.value.diagnostics[0]


def test_without_the_option_the_joints_are_refused_and_the_option_is_named() -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(bars([0, 1, 2])).simulate(0)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R415"
    assert "--redundant accept" in (diagnostic.hint or "")
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(SLIDES)
    assert "--redundant accept" in (caught.value.diagnostics[0].hint or "")


def test_a_plate_that_does_not_fit_its_pins_is_told_with_the_length() -> None:
    found = refused(PLATE.replace("WIDE", "1.02"))
    assert found.code == "R417"
    assert "`p` and `q` do not fit" in found.message
    assert "off by -0.02" in found.message


def test_a_fourth_bar_of_another_length_is_told() -> None:
    found = refused(bars([0, 1, 2, 3], lengths=[1, 1, 1, 1.2], start="phi(start=0.3)"))
    assert found.code == "R417"
    assert "`high3`" in found.message


def test_a_third_bar_of_another_length_makes_a_truss_of_which_a_warning_tells() -> None:
    model = accepted(bars([0, 1, 2], lengths=[1, 1, 1.2], start="phi(start=0.3)"))
    assert model.program.sharing is None
    (warning,) = model.warnings
    assert warning.code == "R419"
    assert "nothing can move" in warning.message
    assert "`high2`" in warning.message


def test_bars_that_meet_in_one_line_by_accident_hold_nothing_twice() -> None:
    """Left out, one condition would let them move."""
    text = """
    model Line
      import P = PlanarMultiBody;
      inner P.World world;
      P.Parts.Fixed far(r={2, 0});
      P.Joints.Revolute a, b, c;
      P.Parts.BodyShape one(r={1, 0}, m=1), two(r={1, 0}, m=1);
    equation
      connect(world.frame_b, a.frame_a);
      connect(a.frame_b, one.frame_a);
      connect(one.frame_b, b.frame_a);
      connect(b.frame_b, two.frame_a);
      connect(two.frame_b, c.frame_a);
      connect(c.frame_b, far.frame_b);
    end Line;
    """
    model = accepted(text)
    assert model.program.sharing is None
    assert model.program.state_count == 0


@pytest.mark.parametrize("angle", [0.3, np.pi / 2])
def test_two_bars_are_none_too_many_not_even_in_one_line(angle: float) -> None:
    model = accepted(bars([0, 1], start=f"phi(start={angle})"))
    assert model.program.sharing is None
    assert [w.code for w in model.warnings] == ["R419"]


def test_another_length_set_for_a_run_does_not_fit() -> None:
    model = accepted(bars([0, 1, 2]))
    same = {f"bar{i}.r[2]": 1.3 for i in range(3)}
    assert code_of(model.simulate(0.1, parameters=same)) == ["R416"]
    with pytest.raises(planarc.PlanarcError) as caught:
        model.simulate(0.1, parameters={"bar2.r[2]": 1.3})
    assert caught.value.diagnostics[0].code in ("R411", "R412", "R417")


RUBBING = """
model Rubbing "The rails of `Slides`, and friction on one of them"
  extends Slides(a(drivenFlange=true));
  Modelica.Mechanics.Translational.Sources.Force rub;
equation
  rub.f = LAW;
  connect(rub.flange, a.axis);
end Rubbing;
"""


@pytest.mark.parametrize(
    ("law", "code"), [("0.2*a.frame_b.f[1]", "R418"), ("0.2*abs(a.frame_b.f[1])", "S316")]
)
def test_friction_that_depends_on_how_forces_are_shared_is_refused(law: str, code: str) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        text = SLIDES + RUBBING.replace("LAW", law)
        planarc.load(text, "Rubbing", redundant="accept").simulate(0.1)
    assert caught.value.diagnostics[0].code == code
    assert "the motion depends on how they" in caught.value.diagnostics[0].message


# On the way ----------------------------------------------------------------------------------


def test_a_loop_closes_on_the_side_on_which_the_redundant_bar_fits() -> None:
    """With this guess two bars alone close crossed; the third bar fits the open side only."""
    crossed = bars([0, 2]).replace("low1(phi(start=0.3))", "low1(phi(start=-2.2))")
    two = planarc.load(crossed).simulate(0)
    assert abs(np.cos(two["low1.phi"][0] - 0.3)) < 0.9
    more = bars([0, 2, 4]).replace("low1(phi(start=0.3))", "low1(phi(start=-2.2))")
    run = accepted(more).simulate(0)
    assert run["low1.phi"][0] == pytest.approx(0.3, abs=1e-9)
    assert run["$misfit[1]"][0] == pytest.approx(0, abs=1e-9)


def test_a_condition_that_ceases_to_follow_ends_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    model = accepted(bars([0, 1, 2]), "numpy")
    outputs = NumpyKernel.outputs
    slot = next(c.slot for c in model.program.columns if c.name == "$misfit[1]")

    def grown(self: NumpyKernel, t: float, y: Sequence[float]) -> int:
        flag = outputs(self, t, y)
        self.w[slot] += max(0.0, t - 0.5)
        return flag

    monkeypatch.setattr(NumpyKernel, "outputs", grown)
    with pytest.raises(planarc.RunStopped) as caught:
        model.simulate(1.0, intervals=10)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R417"
    assert "at t = 0.6 s" in diagnostic.message
    assert "off by 0.1" in diagnostic.message


def test_simulate_takes_the_option_and_other_analyses_go_on_from_it() -> None:
    model = planarc.load(bars([0, 1, 2]))
    assert code_of(model.simulate(0.1, redundant="accept")) == ["R416"]
    with pytest.raises(planarc.PlanarcError):
        model.simulate(0.1)
    text = bars([0, 1, 2], start="phi(start=3.1)").replace("phi(start=0.3)", "phi(start=3.1)")
    same = accepted(text)
    point = same.linearize("equilibrium")
    assert point.values["low0.phi"] == pytest.approx(np.pi, abs=1e-6)
    # Carried parallel to itself, the beam swings like a point mass on a string of 1 m.
    assert np.abs(np.linalg.eigvals(point.A).imag).max() == pytest.approx(np.sqrt(G), rel=1e-6)
    assert not any(name.startswith("$") for name in (*same.parameters, *same.variables))


def test_the_way_to_rest_does_not_cross_the_bars_where_they_lie_flat() -> None:
    """Beyond that position two bars alone could go on crossed; the third one cannot."""
    model = planarc.load(bars((0.0, 0.5, 1.0)), redundant="accept")
    try:
        found = model.equilibrium().start
    except planarc.PlanarcError as problem:
        assert problem.diagnostics[0].code == "R471"
    else:
        assert found["low0.phi"] == pytest.approx(found["low1.phi"], abs=1e-6)
    hanging = {f"low{i}.phi": 2.5 for i in range(3)} | {"high0.phi": -2.5}
    rest = model.equilibrium(start=hanging).start
    angles = [rest[f"low{i}.phi"] for i in range(3)]
    assert angles == pytest.approx([np.pi] * 3, abs=1e-6)


PLANETARY = """model Planetary
  import P = PlanarMultiBody;
  inner P.World world;
  HINGE
  P.Joints.Revolute carrierHinge(phi(fixed=true), w(start=0.3, fixed=true));
  P.Parts.Body sun(m=1, I=0.1), carrier(m=1, I=0.2), planet(m=0.1, I=0.01);
  P.Joints.GearConstraint mesh(ratio=-2, r_b={0.3, 0}, w_b(start=-0.35));
equation
  TIES
  connect(world.frame_b, carrierHinge.frame_a);
  connect(carrierHinge.frame_b, carrier.frame_a);
  connect(mesh.bearing, carrier.frame_a);
  connect(mesh.frame_a, sun.frame_a);
  connect(mesh.frame_b, planet.frame_a);
end Planetary;"""


def test_a_sun_on_a_bearing_of_its_own_turns_as_one_that_its_gear_bears() -> None:
    hinge = "P.Joints.Revolute sunHinge(phi(fixed=true), w(start=1, fixed=true));"
    ties = "connect(world.frame_b, sunHinge.frame_a); connect(sunHinge.frame_b, sun.frame_a);"
    borne = PLANETARY.replace("HINGE", hinge).replace("TIES", ties)
    alone = PLANETARY.replace("HINGE", "").replace("TIES", "")
    alone = alone.replace("w_b(start=-0.35)", "phi_b(fixed=true), w_b(start=-0.35, fixed=true)")
    twice = planarc.load(borne, redundant="accept").simulate(2, tolerance=1e-10)
    once = planarc.load(alone).simulate(2, tolerance=1e-10)
    for name in ("sun.w", "carrier.w", "mesh.w_b"):
        assert np.max(np.abs(twice[name] - once[name])) < 1e-7
