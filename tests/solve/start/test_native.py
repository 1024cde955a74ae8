"""What machine code does of a start is what NumPy does of it, and it leaves the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.core.options import RunOptions
from planarc.solve.opened import open_program
from planarc.solve.start import newton
from planarc.solve.start.stage import Part
from planarc.solve.start.system import System

EXAMPLES = Path(__file__).parents[3] / "examples"
FOUR_BAR = EXAMPLES / "four_bar.pmo"
PART = 1e-5


def system_of(model: planarc.Model) -> tuple[System, np.ndarray]:
    compiled = model.compiled()
    program, kernel = compiled.program, compiled.load()
    open_program(program, kernel, RunOptions(stop=0.0))
    return System(program, kernel, 0.0), np.array([kernel.w[c.start] for c in program.candidates])


def spread(basis: np.ndarray) -> np.ndarray:
    """The projection on what a basis spans, whichever basis it is."""
    return basis @ basis.T


@pytest.mark.parametrize("name", ["four_bar", "crank_slider", "gripper", "double_pendulum"])
def test_motions_are_those_of_singular_values(name: str) -> None:
    system, u = system_of(planarc.load(EXAMPLES / f"{name}.pmo"))
    for place in (u, u + 0.1):
        slopes, found = system.slopes(place), system.motions(place, PART)
        assert slopes is not None and found is not None
        assert spread(found) == pytest.approx(spread(newton.kernel_of(slopes, PART)), abs=1e-9)
        assert found.T @ found == pytest.approx(np.eye(found.shape[1]), abs=1e-14)


@pytest.mark.parametrize("distance", np.geomspace(1e-12, 1e-1, 23))
def test_near_a_flat_position_the_rank_is_right_or_not_told(distance: float) -> None:
    system, _ = system_of(planarc.load(FOUR_BAR))
    flat = dict.fromkeys(("revA.phi", "revB.phi", "revD.phi"), 0.0)
    flat["revB.phi"] = distance
    place = np.array([flat.get(c.display, 0.0) for c in system.program.candidates])
    slopes, found = system.slopes(place), system.motions(place, PART)
    assert slopes is not None
    if found is not None:
        assert found.shape == newton.kernel_of(slopes, PART).shape


class Plain:
    """A function without what finds its root straight on."""

    def __init__(self, part: Part) -> None:
        self._part, self.slopes = part, part.slopes

    def __call__(self, z: np.ndarray) -> np.ndarray | None:
        return self._part(z)


@pytest.mark.parametrize("turn", [0.0, 0.1, 0.2, 0.7, 1.3, 2.0, -0.9, -2.4])
def test_a_root_is_the_one_of_newton_s_method(turn: float) -> None:
    system, u = system_of(planarc.load(FOUR_BAR))
    rows, columns = system.stages[0]
    free = [c for c in columns if not system.program.candidates[c].fixed]
    assert len(free) == len(rows)
    u[free] += turn
    part = Part(system, u, rows, free)
    plain = newton.solve(Plain(part), u[free])
    straight = part.root(u[free])
    if straight is None:  # it needs more than steps that are shortened
        assert not newton.solve_near(Plain(part), u[free], 60).converged
        return
    assert straight is not None and plain.converged and straight.converged
    assert straight.point == pytest.approx(plain.point, abs=1e-13)
    assert abs(straight.residuals).max() < 1e-14
