"""Equilibria and linear models against closed forms."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc import Model, PlanarcError, UsageError, load
from planarc.core.options import Backend

G = 9.81
#: Squares of the frequencies around the lower equilibrium, V''/M.
PENDULUM = 2 * G * 0.7 / (0.3 + 2 * 0.7**2)
PARALLELOGRAM = (
    G * (1 * 0.25 + 3 * 0.25 + 2 * 0.5) / (0.1 + 0.25**2 + 0.3 + 3 * 0.25**2 + 2 * 0.5**2)
)
#: At phi = -90 deg the rod does not turn: it and the slider move with the crank's pin.
SLIDER = G * (1 + 2) * 0.1 / (0.01 + 0.1**2 + (2 + 3) * 0.2**2)

CASES = [
    ("pendulum", "hinge", PENDULUM),
    ("parallelogram", "A", PARALLELOGRAM),
    ("slider", "main", SLIDER),
]


@pytest.mark.parametrize(("name", "joint", "square"), CASES)
def test_a_mechanism_hangs_down_and_swings(
    name: str, joint: str, square: float, request: pytest.FixtureRequest
) -> None:
    model: Model = request.getfixturevalue(name)
    rest = model.equilibrium()
    assert rest.stable
    assert math.cos(rest[f"{joint}.phi"] + math.pi / 2) == pytest.approx(1, abs=1e-12)
    assert abs(rest[f"{joint}.z"]) < 1e-8
    linear = model.linearize("equilibrium")
    (mode,) = linear.modes
    assert mode.natural_frequency == pytest.approx(math.sqrt(square), rel=1e-8)
    assert mode.frequency == pytest.approx(math.sqrt(square) / (2 * math.pi), rel=1e-8)
    assert abs(mode.damping) < 1e-8
    assert linear.stable
    assert np.ptp(model.simulate(1, start=rest.start)[f"{joint}.phi"]) < 1e-6


@pytest.mark.parametrize("start", [0.5, 1.5, 1.6, 3.0, -3.0, 9.0])
def test_the_way_leads_down_from_wherever_it_starts(pendulum: Model, start: float) -> None:
    rest = pendulum.equilibrium(start={"hinge.phi": start})
    assert rest.stable
    assert math.sin(rest["hinge.phi"]) == pytest.approx(-1, abs=1e-12)
    assert abs(rest["hinge.phi"] - start) < 2 * math.pi


def test_an_unstable_equilibrium_is_kept_and_told(pendulum: Model) -> None:
    up = pendulum.equilibrium(start={"hinge.phi": math.pi / 2})
    assert (up["hinge.phi"], up.stable) == (pytest.approx(math.pi / 2), False)
    linear = pendulum.linearize(up.start)
    assert not linear.stable
    assert sorted(linear.eigenvalues.real) == pytest.approx(
        [-math.sqrt(PENDULUM), math.sqrt(PENDULUM)], rel=1e-8
    )


def test_nothing_to_rest_on_is_said() -> None:
    model = load(
        "model Falls inner PlanarMultiBody.World world; PlanarMultiBody.Parts.Body b(m=1, I=1);"
        " PlanarMultiBody.Joints.Prismatic j(n={0, 1});"
        " equation connect(world.frame_b, j.frame_a); connect(j.frame_b, b.frame_a); end Falls;"
    )
    with pytest.raises(PlanarcError, match="no equilibrium"):
        model.equilibrium()


def test_matrices_of_a_filter_are_its_own(lag: Model) -> None:
    linear = lag.linearize(parameters={"T": 4, "c": [3, 5]}, inputs={"u": 2})
    assert (linear.states, linear.inputs, linear.outputs) == (("x",), ("u",), ("x", "y"))
    for found, exact in (
        (linear.A, [[-0.25]]),
        (linear.B, [[0.25]]),
        (linear.C, [[1], [3]]),
        (linear.D, [[0], [5]]),
    ):
        assert np.allclose(found, exact, atol=1e-11)
    assert linear.modes[0].damping == pytest.approx(1)
    assert linear.values["u"] == 2


def test_what_has_neither_states_nor_inputs_has_an_empty_linear_model() -> None:
    model = load("model Root\n  output Real z(start=1);\nequation\n  z + exp(z) = 2;\nend Root;")
    linear = model.linearize()
    assert (linear.states, linear.inputs, linear.outputs) == ((), (), ("z",))
    assert (linear.A.shape, linear.C.shape, linear.D.shape) == ((0, 0), (1, 0), (1, 0))
    assert linear.stable


FLAP = """
model Flap
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.RevoluteWithFriction hinge(mu=0.3, R=0.05,
    phi(start=1.5, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.Body flap(m=2, I=0.1, r_CM={0.5, 0});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, flap.frame_a);
end Flap;
"""


def test_what_dry_friction_holds_is_told() -> None:
    """The moment 2*G*0.5*cos(phi) is held up to 2*G*R*sin(atan(mu))."""
    model = load(FLAP)
    end, within = model.equilibrium(), model.equilibrium(start={"hinge.phi": -1.56})
    limit = math.acos(0.05 * math.sin(math.atan(0.3)) / 0.5)
    assert end.start["hinge.phi"] == pytest.approx(-limit, abs=1e-6)
    assert within.start["hinge.phi"] == -1.56
    slides, sticks = model.linearize("equilibrium"), model.linearize({"hinge.phi": -1.56})
    for found, words in (
        (end, "an end of a range"),
        (within, "one of a range"),
        (slides, "sliding one way"),
        (sticks, "lets nothing move it"),
    ):
        (told,) = found.warnings
        assert told.code == "R475"
        assert words in told.message
        assert told.span is not None and told.span.text.startswith("hinge(")


def test_friction_that_has_its_sign_is_not_spoken_of() -> None:
    model = load(FLAP)
    assert not model.linearize(0.5).warnings
    free = model.linearize("equilibrium", parameters={"hinge.mu": 0})
    assert not free.warnings
    assert free.modes[0].natural_frequency == pytest.approx(math.sqrt(G / (0.5 + 0.1)), rel=1e-6)


def test_a_time_is_a_point_of_the_run(pendulum: Model) -> None:
    linear = pendulum.linearize(0.3, outputs=["hinge.z"])
    run = pendulum.simulate(0.3)
    phi = run["hinge.phi"][-1]
    assert linear.values["hinge.phi"] == pytest.approx(phi, abs=1e-9)
    assert linear.A[1, 0] == pytest.approx(PENDULUM * math.sin(phi), rel=1e-6)
    assert np.allclose(linear.C, linear.A[1:])


def test_the_shape_of_a_mode_moves(pendulum: Model, tmp_path: Path) -> None:
    linear = pendulum.linearize("equilibrium")
    motion = linear.motion(0, amplitude=0.3)
    angle = motion["hinge.phi"]
    assert np.ptp(motion["hinge.w"]) == pytest.approx(0.6)
    assert np.ptp(angle) == pytest.approx(0.6 / math.sqrt(PENDULUM), rel=1e-3)
    assert np.allclose(np.hypot(motion["bob.r_0CM[1]"], motion["bob.r_0CM[2]"]), 0.7)
    assert "canvas" in linear.animate(0).text
    picture = linear.animate(0, path=tmp_path / "mode.svg", width=200)
    assert "animateTransform" in picture.read_text("utf-8")


def test_a_linear_model_goes_to_another_process(pendulum: Model, bowl: Model) -> None:
    one_way = load("model M input Real u; Real x = 2*u; end M;")
    for model, at in ((pendulum, "equilibrium"), (bowl, "start"), (one_way, "start")):
        linear = model.linearize(at=at)
        copy = pickle.loads(pickle.dumps(linear))
        assert np.array_equal(copy.A, linear.A)
        assert copy.values == linear.values
        if linear.modes:
            moves, moved = (each.motion(0) for each in (linear, copy))
            assert np.array_equal(moves.rows.data, moved.rows.data)


def test_a_copy_has_the_states_that_the_run_had_taken_on() -> None:
    """A point on a circle: x and y change places as states."""
    circle = load("""model C
      Real x(start=1), y(start=0.1), u, v(start=5, fixed=true), f;
    equation
      der(x) = u; der(y) = v; x^2 + y^2 = 1; der(u) = -f*x; der(v) = -f*y - 1;
    end C;""")
    first, last = (circle.linearize(at=t) for t in (0, 0.3))
    assert first.states != last.states
    for linear in (first, last):
        copy = pickle.loads(pickle.dumps(linear))
        moves, moved = (each.motion(0, 0.01) for each in (linear, copy))
        assert np.allclose(moves.rows.data, moved.rows.data, rtol=0, atol=1e-12)


def test_a_mode_that_is_not_there_is_refused(pendulum: Model) -> None:
    linear = pendulum.linearize("equilibrium")
    for mode in (1, -2, "first"):
        with pytest.raises(UsageError, match="has 1"):
            linear.motion(mode)  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="finite"):
        linear.motion(0, amplitude=math.nan)
    assert np.array_equal(linear.motion(-1)["hinge.phi"], linear.motion(0)["hinge.phi"])


WRONG: list[tuple[Any, str]] = [
    ("rest", "equilibrium"),
    (-1.0, "before the start"),
    ({"hinge.fi": 1}, "no variable"),
    (math.nan, "finite"),
]


@pytest.mark.parametrize(("at", "words"), WRONG)
def test_a_wrong_point_is_refused(pendulum: Model, at: Any, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        pendulum.linearize(at)
    assert words in f"{caught.value} {caught.value.diagnostics[0].hint}"
    with pytest.raises(UsageError, match="no variable"):
        pendulum.linearize(outputs=["tau"])


@pytest.mark.parametrize("backend", list(Backend))
def test_formulas_give_the_matrices(
    four_bar: Model, backend: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same as differences do, also of forces as outputs; where there is no formula,
    differences are taken and said."""
    model = Model(four_bar.request, backend)
    asked = ["revC.frame_a.f[1]", "revD.phi"]
    found = model.linearize(0.3, outputs=asked)
    assert found.derivatives == "formulas"
    monkeypatch.setattr("planarc.api.analysis.linearize._by_formulas", lambda *_: None)
    same = model.linearize(0.3, outputs=asked)
    assert same.derivatives == "differences"
    for name in "ABCD":
        a, b = getattr(found, name), getattr(same, name)
        assert a.shape == b.shape
        assert np.allclose(a, b, rtol=1e-8, atol=1e-8)


def test_an_input_of_a_mechanism() -> None:
    """A torque at a hinge: B = 1/(I + m*l^2), and the hinge's reaction feels it at once."""
    model = load(
        """model M
          inner PlanarMultiBody.World world(g=0);
          input Real u;
          PlanarMultiBody.Joints.Revolute hinge(drivenFlange=true, phi(fixed=true), w(fixed=true));
          PlanarMultiBody.Parts.Body bob(m=2, I=0.3, r_CM={0.7, 0});
          Modelica.Mechanics.Rotational.Sources.Torque drive;
        equation
          drive.tau = u;
          connect(drive.flange, hinge.axis);
          connect(world.frame_b, hinge.frame_a);
          connect(hinge.frame_b, bob.frame_a);
        end M;"""
    )
    found = model.linearize(outputs=["der(hinge.w)", "hinge.frame_b.f[2]"])
    inertia = 0.3 + 2 * 0.7**2
    assert found.derivatives == "formulas"
    assert found.B[found.states.index("hinge.w"), 0] == pytest.approx(1 / inertia, rel=1e-12)
    assert found.D[0, 0] == pytest.approx(1 / inertia, rel=1e-12)
    assert abs(found.D[1, 0]) == pytest.approx(2 * 0.7 / inertia, rel=1e-12)


BOWL = """model Bowl "A disc rolls at the bottom of a bowl"
  import PlanarMultiBody.*;
  inner World world;
  input Real u;
  parameter Real mu = 0.5;
  Parts.Body disc(m=2, I=0.01, r(start={0, -0.9}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=1, inside=true), mu=mu);
  Forces.WorldTorque push;
equation
  push.torque = u;
  connect(push.frame_b, disc.frame_a);
  connect(disc.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
end Bowl;"""


@pytest.fixture(scope="module")
def bowl() -> Model:
    return load(BOWL)


def test_what_keeps_a_contact_closed_is_no_mode(bowl: Model) -> None:
    """Rolling leaves x, phi and the spin: w^2 = g/((R - r)*(1 + I/(m*r^2)))."""
    rolling = bowl.linearize(outputs=["disc.v[1]"])
    assert rolling.holding == ("`contact`",)
    assert rolling.states == ("disc.frame_a.r[1]", "disc.frame_a.phi", "disc.w")
    still, swing = rolling.modes
    assert abs(still.eigenvalue) < 1e-9
    assert swing.eigenvalue == pytest.approx(1j * math.sqrt(G / (0.9 * 1.5)), abs=1e-8)
    torque = rolling.B[:, 0]
    assert torque == pytest.approx([0, 0, 1 / (0.01 + 2 * 0.1**2)], abs=1e-9)
    assert pytest.approx(np.array([[0, 0, -0.1]]), abs=1e-9) == rolling.C  # it rolls
    sliding = bowl.linearize(parameters={"mu": 0})
    assert len(sliding.states) == 4
    assert sliding.modes[-1].eigenvalue == pytest.approx(1j * math.sqrt(G / 0.9), abs=1e-8)


def test_states_that_follow_move_with_a_mode(bowl: Model) -> None:
    motion = bowl.linearize().motion(1, amplitude=1e-3)
    x, phi, spin = (motion[n] for n in ("disc.r[1]", "disc.phi", "disc.w"))
    assert np.ptp(spin) == pytest.approx(2e-3)
    assert np.ptp(x) == pytest.approx(0.1 * np.ptp(phi))
    assert np.ptp(motion["disc.v[1]"]) == pytest.approx(2e-4)
    assert np.ptp(motion["disc.r[2]"]) < 1e-12


def test_a_block_at_rest_has_no_modes_but_its_place() -> None:
    """Both corners are held, and one of them sticks: the other slip tells nothing new."""
    model = load("""model Block
      import PlanarMultiBody.*;
      inner World world;
      Parts.Body box(m=1, I=0.1, r(start={0, 0.1}, each fixed=true), v(each fixed=true),
        phi(fixed=true), w(fixed=true));
      Contacts.Contact contact(mu=0.5, redeclare Contacts.Polygon contour1(
          vertices={{-0.2, -0.1}, {0.2, -0.1}, {0.2, 0.1}, {-0.2, 0.1}}),
        redeclare Contacts.HalfPlane contour2);
    equation
      connect(box.frame_a, contact.frame_a);
      connect(world.frame_b, contact.frame_b);
    end Block;""")
    found = model.linearize()
    assert found.states == ("box.frame_a.r[1]",)
    assert abs(found.A).max() < 1e-12


def test_a_joint_that_sticks_is_no_mode() -> None:
    model = load("""model Held
      import PlanarMultiBody.*;
      inner World world;
      Joints.RevoluteWithFriction hinge(mu=0.5, R=0.2, phi(start=-1.57, fixed=true), w(fixed=true));
      Parts.Body bob(m=1, I=0.1, r_CM={0.1, 0});
    equation
      connect(world.frame_b, hinge.frame_a);
      connect(hinge.frame_b, bob.frame_a);
    end Held;""")
    found = model.linearize()
    assert (found.holding, found.states) == (("`hinge`",), ("hinge.phi",))
