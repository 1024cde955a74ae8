"""Energy: closed forms, and a balance that no component may break."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.insight.energy import find_energies
from planarc.insight.values import integral, rate

EXAMPLES = (
    "CurveCurveJoint.CamFollower",
    "CurveCurveJoint.SinusEllipse",
    "Elementary.BouncingMass",
    "Elementary.DrivenPendulum",
    "Elementary.FreeBody",
    "Elementary.LineForceWithTwoMasses",
    "Elementary.PendulumWithSpringDamper",
    "Elementary.PointGravity",
    "Elementary.SpringDamperSystem",
    "Loops.AndrewsSqueezer",
    "Loops.CrankSlider",
    "Loops.FourBar",
    "Loops.PistonEngine",
    "Loops.TwoLoops",
    "Systems.Excavator",
    "Systems.QuickReturn",
)


def energies_of(result: Any) -> Any:
    found = find_energies(result, result.program.mechanism)
    assert found is not None
    return found


@pytest.mark.parametrize("name", EXAMPLES)
def test_energy_is_balanced_in_every_example(name: str, run_of: Callable[..., Any]) -> None:
    result, _ = run_of(name)
    found = energies_of(result)
    assert abs(found.balance).max() < 2e-3 * found.exchanged


def test_a_four_bar_keeps_its_energy_to_the_tolerance_of_the_run(
    run_of: Callable[..., Any],
) -> None:
    errors = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        result, _ = run_of("Loops.FourBar", tolerance=tolerance)
        found = energies_of(result)
        assert not found.supplied.any()
        assert not found.dissipated.any()
        errors.append(abs(found.balance).max() / found.exchanged)
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-6


def test_a_pendulum_has_the_energies_of_its_formulas(run_of: Callable[..., Any]) -> None:
    result, _ = run_of("Elementary.Pendulum")
    found = energies_of(result)
    body = next(p.name for p in result.program.parts if p.class_name.endswith(".Body"))
    m, inertia = result[f"{body}.m"][0], result[f"{body}.I"][0]
    speed = np.hypot(result[f"{body}.v_CM[1]"], result[f"{body}.v_CM[2]"])
    kinetic = m * speed**2 / 2 + inertia * result[f"{body}.w"] ** 2 / 2
    np.testing.assert_allclose(found.kinetic, kinetic, rtol=1e-12)
    height = result[f"{body}.r_0CM[2]"]
    np.testing.assert_allclose(found.potential, m * 9.81 * height, rtol=1e-12, atol=1e-12)


def test_a_damper_turns_all_energy_into_heat() -> None:
    # A mass on a spring and a damper, pulled aside: E(0) = c*x^2/2 is dissipated in the end.
    model = planarc.load(
        """
        model M
          inner PlanarMultiBody.World world(gravityType=
            PlanarMultiBody.Types.GravityTypes.NoGravity);
          PlanarMultiBody.Joints.Prismatic rail(n={1, 0}, s(start=1.5, fixed=true), v(fixed=true));
          PlanarMultiBody.Forces.SpringDamperParallel spring(c=100, d=10, s_unstretched=1);
          PlanarMultiBody.Parts.Body body(m=1, I=0);
        equation
          connect(world.frame_b, rail.frame_a);
          connect(rail.frame_b, body.frame_a);
          connect(world.frame_b, spring.frame_a);
          connect(spring.frame_b, rail.frame_b);
          annotation(experiment(StopTime=5, Interval=0.005, Tolerance=1e-9));
        end M;
        """
    )
    found = energies_of(model.simulate().rows)
    assert found.mechanical[0] == pytest.approx(100 * 0.5**2 / 2, rel=1e-9)
    assert found.dissipated[-1] == pytest.approx(12.5, rel=1e-5)


def test_a_field_of_the_users_own_is_integrated() -> None:
    # Gravity that grows with the height: a = -{0, 2*y}, potential m*y^2.
    model = planarc.load(
        """
        model M
          function field
            extends PlanarMultiBody.Interfaces.partialGravityAcceleration;
          algorithm
            gravity := {0, -2*r[2]};
          end field;
          inner PlanarMultiBody.World world(redeclare function gravityAcceleration = field);
          PlanarMultiBody.Parts.Body body(m=3, I=1, enforceStates=true,
            r(start={0, 1}, each fixed=true), v(each fixed=true), phi(fixed=true), w(fixed=true));
          annotation(experiment(StopTime=3, Interval=0.005, Tolerance=1e-9));
        end M;
        """
    )
    result = model.simulate().rows
    found = energies_of(result)
    expected = 3 * (result["body.r[2]"] ** 2 - 1)
    np.testing.assert_allclose(found.potential, expected, atol=1e-5)
    assert abs(found.balance).max() < 1e-5


def test_the_energy_lost_in_impacts_is_counted(run_of: Callable[..., Any]) -> None:
    result, _ = run_of("Elementary.BouncingMass")
    found = energies_of(result)
    assert found.dissipated[-1] > 0.5 * found.exchanged
    steps = np.flatnonzero(np.diff(found.dissipated) > 1e-9)
    assert all(result.time[s] == result.time[s + 1] for s in steps)


def test_rates_and_integrals_stop_at_jumps() -> None:
    time = np.concatenate([np.linspace(0, 1, 51), np.linspace(1, 2, 51)])
    values = np.where(np.arange(102) < 51, time, 5 - time)
    np.testing.assert_allclose(rate(time, values), np.where(np.arange(102) < 51, 1.0, -1.0))
    np.testing.assert_allclose(integral(time, values)[-1], 0.5 + 3.5, rtol=1e-12)


def test_rates_of_pieces_are_those_of_each_by_itself() -> None:
    random = np.random.default_rng(7)
    counts = [1, 2, 3, 4, 1, 1, 30, 2]
    pieces = [np.cumsum(random.uniform(0.01, 1.0, n)) for n in counts]
    ends = np.concatenate([[0.0], np.cumsum([p[-1] - p[0] for p in pieces])])
    time = np.concatenate([p - p[0] + t for p, t in zip(pieces, ends[:-1], strict=True)])
    values = random.normal(size=len(time))
    alone = []
    for piece in np.split(np.arange(len(time)), np.cumsum(counts)[:-1]):
        order = min(len(piece) - 1, 2)
        alone += (
            np.gradient(values[piece], time[piece], edge_order=order).tolist() if order else [0.0]
        )
    np.testing.assert_allclose(rate(time, values), alone, rtol=1e-11, atol=1e-12)


def test_integrals_have_order_four() -> None:
    errors = []
    for count in (41, 81):
        time = np.linspace(0.0, 2.0, count)
        inner = integral(time, np.cos(3 * time))
        errors.append(abs(inner - np.sin(3 * time) / 3).max())
    assert errors[0] / errors[1] > 12
