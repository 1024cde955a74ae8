"""Mechanisms sorted and evaluated, against an independent formulation (see `planar.py`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from planarc.ir.dae import Dae
from planarc.ir.sorted import Block, SortedDae
from planarc.structure.pipeline import structure
from tests.ir.check.sorted import check_sorted

Make = Callable[..., Dae]


def _sorted(make: Make, m: Any) -> SortedDae:
    dae = make(*m.finished(), attributes=m.attributes, **m.parameters)
    model = structure(dae)
    check_sorted(model)
    return model


def _residual_counts(model: SortedDae) -> list[int]:
    return [
        sum(len(s.residuals) for s in level.steps if isinstance(s, Block)) for level in model.levels
    ]


def _candidates(model: SortedDae) -> list[str]:
    return [c.display for c in model.candidates]


# The mechanisms -------------------------------------------------------------------------------


def test_pendulum(planar: Any, make: Make, point: Any) -> None:
    model = _sorted(make, planar.pendulum())
    assert _candidates(model) == ["rev.phi", "rev.w"]
    assert _residual_counts(model) == [0, 0, 1]
    p = point(model, {"rev.phi": 0.4, "der(rev.phi)": 1.5})
    arm = 2.0 * 0.7
    assert p.of("rev.z") == pytest.approx(-arm * 9.81 * np.cos(0.4) / (0.3 + arm * 0.7), rel=1e-12)
    assert p.of("bob.w") == 1.5
    assert p.of("ground.b.fy") == pytest.approx(-p.of("bob.a.fy"))


def test_chain_of_three(planar: Any, make: Make, point: Any) -> None:
    model = _sorted(make, planar.chain(3))
    names = [f"rev{i}" for i in range(3)]
    assert _candidates(model) == [f"{n}.phi" for n in names] + [f"{n}.w" for n in names]
    assert _residual_counts(model) == [0, 0, 3]
    q, w = np.array([0.3, -0.5, 1.1]), np.array([0.7, -1.2, 0.4])
    relative = np.diff(q, prepend=0), np.diff(w, prepend=0)
    states = {f"{n}.phi": a for n, a in zip(names, relative[0], strict=True)}
    states |= {f"der({n}.phi)": a for n, a in zip(names, relative[1], strict=True)}
    p = point(model, states)
    tips = [(1.0, [(k, (1.0, 0.0)) for k in range(i + 1)]) for i in range(3)]
    expected, _ = planar.accelerations(q, w, tips, [0.1] * 3, [])
    got = np.cumsum([p.of(f"{n}.z") for n in names])
    assert got == pytest.approx(expected, rel=1e-9)


def _four_bar_reference(
    planar: Any, q: np.ndarray, w: np.ndarray, driven: Sequence[int] = ()
) -> tuple[np.ndarray, np.ndarray]:
    masses: list[tuple[float, Any]] = [
        (1.0, [(0, (0.2, 0.0))]),
        (2.0, [(0, (0.4, 0.0)), (1, (0.45, 0.1))]),
        (1.5, [(2, (0.4, 0.0))]),
    ]
    loop: Any = [(0, (0.4, 0.0)), (1, (0.9, 0.0)), (2, (-0.8, 0.0))]
    closed = [((1.0, 0.0), loop), ((0.0, 1.0), loop)]
    return planar.accelerations(q, w, masses, [0.0134, 0.14, 0.08], closed, driven)


@pytest.mark.parametrize("state", ["revA.phi", "revB.phi", "revC.phi"])
def test_four_bar_with_any_angle_as_the_state(
    planar: Any, make: Make, point: Any, state: str
) -> None:
    model = _sorted(make, planar.four_bar())
    assert model.state_count == 2
    assert len(model.candidates) == 6
    assert _residual_counts(model) == [2, 2, 5]
    guesses = {"revA.phi": 1.0, "revB.phi": -0.46, "revC.phi": 1.05}
    first = point(model, {"revA.phi": 1.0, "der(revA.phi)": 2.0}, guesses)
    angle, speed = first.of(state), first.of(state.replace(".phi", ".w"))
    p = point(model, {state: angle, f"der({state})": speed}, guesses)
    q = np.array([p.of(f"{bar}.a.phi") for bar in ("crank", "coupler", "rocker")])
    w = np.array([p.of(f"{bar}Body.w") for bar in ("crank", "coupler", "rocker")])
    expected, multipliers = _four_bar_reference(planar, q, w)
    got = [p.of(f"{bar}Body.z") for bar in ("crank", "coupler", "rocker")]
    assert got == pytest.approx(expected, rel=1e-6)
    # The multipliers are the force of hinge C on the coupler, reversed.
    force = [p.of("revC.a.fx"), p.of("revC.a.fy")]
    assert np.abs(force) == pytest.approx(np.abs(multipliers), rel=1e-6)


def test_crank_slider(planar: Any, make: Make, point: Any) -> None:
    model = _sorted(make, planar.crank_slider())
    assert model.state_count == 2
    phi, w = 0.8, 3.0
    p = point(
        model,
        {"revA.phi": phi, "der(revA.phi)": w},
        {"revB.phi": -1.1, "slide.s": 1.0},
    )
    rod = np.arcsin(-0.3 * np.sin(phi) / 0.8)
    assert p.of("slide.s") == pytest.approx(0.3 * np.cos(phi) + 0.8 * np.cos(rod), rel=1e-10)
    rod_w = -0.3 * np.cos(phi) * w / (0.8 * np.cos(rod))
    end: Any = [(0, (0.3, 0.0)), (1, (0.8, 0.0))]
    masses: list[tuple[float, Any]] = [
        (1.0, [(0, (0.15, 0.0))]),
        (1.5, [(0, (0.3, 0.0)), (1, (0.4, 0.0))]),
        (2.0, end),
    ]
    expected, multipliers = planar.accelerations(
        np.array([phi, rod]), np.array([w, rod_w]), masses, [0.02, 0.05], [((0, 1), end)]
    )
    assert p.of("revA.z") == pytest.approx(expected[0], rel=1e-6)
    assert p.of("revB.z") == pytest.approx(expected[1] - expected[0], rel=1e-6)
    assert abs(p.of("slide.b.fy")) == pytest.approx(abs(multipliers[0]), rel=1e-6)


def test_a_driven_four_bar_has_no_states(planar: Any, make: Make, point: Any) -> None:
    m = planar.four_bar()
    m.equations.remove("revA.tau = 0")
    m.equations.append("revA.phi = 1 + 2*time")
    model = _sorted(make, m)
    assert model.state_count == 0
    p = point(model, {}, {"revB.phi": -0.46, "revC.phi": 1.05})
    q = np.array([p.of(f"{bar}.a.phi") for bar in ("crank", "coupler", "rocker")])
    w = np.array([p.of(f"{bar}Body.w") for bar in ("crank", "coupler", "rocker")])
    assert p.of("revA.w") == 2
    assert p.of("revA.z") == 0
    expected, multipliers = _four_bar_reference(planar, q, w, driven=[0])
    got = [p.of(f"{bar}Body.z") for bar in ("crank", "coupler", "rocker")]
    assert got == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert abs(p.of("revA.tau")) == pytest.approx(abs(multipliers[2]), rel=1e-6)


def test_a_ladder_of_loops_has_one_degree_of_freedom(planar: Any, make: Make) -> None:
    model = _sorted(make, planar.ladder(3))
    assert model.state_count == 2
    assert _residual_counts(model)[:2] == [6, 6]


def test_velocities_are_torn_like_positions(planar: Any, make: Make) -> None:
    for m in (planar.four_bar(), planar.crank_slider(), planar.ladder(2)):
        model = _sorted(make, m)
        position, velocity = (
            [t.name for s in level.steps if isinstance(s, Block) for t in s.tears]
            for level in model.levels[:2]
        )
        assert position == velocity
        assert all(s.linear for s in model.levels[1].steps if isinstance(s, Block) if s.residuals)


def test_the_same_model_is_sorted_alike_however_it_is_read(planar: Any, make: Make) -> None:
    first, again = (_sorted(make, planar.four_bar()) for _ in range(2))
    assert repr(first.levels) == repr(again.levels)


def test_work_grows_with_the_size_of_a_chain(planar: Any, make: Make) -> None:
    sizes = []
    for count in (10, 20):
        m = planar.chain(count)
        dae = make(*m.finished(), attributes=m.attributes, **m.parameters)
        structure(dae)
        sizes.append(len(dae.table.all))
    assert sizes[1] < 2.1 * sizes[0]
