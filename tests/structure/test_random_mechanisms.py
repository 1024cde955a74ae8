"""Random trees and loops of hinged bars: accelerations and hinge forces by two formulations."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc.ir.dae import Dae
from planarc.structure.pipeline import structure
from tests.ir.check.sorted import check_sorted

GROUND = -1


class Case:
    """Bars on each other or on the ground; the last ones close loops where they end."""

    def __init__(self, seed: int) -> None:
        rng = random.Random(seed)
        self.rng = rng
        self.loops = rng.randint(0, 3)
        trees = rng.randint(max(1, self.loops), 5)
        self.count = trees + self.loops
        self.angle = np.array([rng.uniform(-3, 3) for _ in range(self.count)])
        self.parent: list[int] = []
        self.rod: list[tuple[float, float]] = []
        self.foot: list[tuple[float, float]] = []  # where a bar stands on the ground
        self.closed: list[tuple[int, int, tuple[float, float]]] = []  # bar, other bar, ground
        for bar in range(self.count):
            self.parent.append(rng.randint(GROUND, bar - 1))
            self.foot.append((rng.uniform(-2, 2), rng.uniform(-2, 2)))
            self.rod.append((rng.uniform(0.3, 1.5), rng.uniform(-0.5, 0.5)))
            if bar >= trees:
                self._close(bar)
        self.mass = [rng.uniform(0.5, 3) for _ in range(self.count)]
        self.inertia = [rng.uniform(0.01, 0.3) for _ in range(self.count)]
        self.centre = [(rng.uniform(-0.4, 0.6), rng.uniform(-0.3, 0.3)) for _ in range(self.count)]
        self.flipped = [rng.random() < 0.5 for _ in range(self.count + self.loops)]

    def _close(self, bar: int) -> None:
        """Make the bar just as long as to end at the tip of another one, or on the ground."""
        others = [b for b in range(bar) if b != self.parent[bar]]
        other = self.rng.choice([GROUND, *others])
        place = (self.rng.uniform(-2, 2), self.rng.uniform(-2, 2))
        end = np.array(place) if other == GROUND else self.tip(other)
        gap = end - self.origin(bar)
        c, s = np.cos(self.angle[bar]), np.sin(self.angle[bar])
        self.rod[bar] = (c * gap[0] + s * gap[1], -s * gap[0] + c * gap[1])
        self.closed.append((bar, other, place))

    def path(self, bar: int) -> list[tuple[int, tuple[float, float]]]:
        """From the ground to the tip, as rotated vectors."""
        found = []
        while bar != GROUND:
            found.append((bar, self.rod[bar]))
            bar = self.parent[bar]
        return found

    def _sum(self, path: list[tuple[int, tuple[float, float]]]) -> np.ndarray:
        turned = [
            np.array([np.cos(a) * x - np.sin(a) * y, np.sin(a) * x + np.cos(a) * y])
            for a, (x, y) in ((self.angle[b], v) for b, v in path)
        ]
        return sum(turned, np.zeros(2))

    def root(self, bar: int) -> int:
        while self.parent[bar] != GROUND:
            bar = self.parent[bar]
        return bar

    def origin(self, bar: int) -> np.ndarray:
        return np.array(self.foot[self.root(bar)]) + self._sum(self.path(self.parent[bar]))

    def tip(self, bar: int) -> np.ndarray:
        return np.array(self.foot[self.root(bar)]) + self._sum(self.path(bar))

    def loop_paths(self) -> list[list[tuple[int, tuple[float, float]]]]:
        return [
            self.path(bar)
            + ([] if other == GROUND else [(b, (-x, -y)) for b, (x, y) in self.path(other)])
            for bar, other, _ in self.closed
        ]

    def model(self, planar: Any) -> Any:
        """The same as components and connections, in random order."""
        m = planar.Mechanism()
        sets: dict[str, list[str]] = {}
        jobs: list[Callable[[], Any]] = []
        for bar in range(self.count):
            jobs += self._bar_jobs(m, bar, sets)
        for i, (bar, other, place) in enumerate(self.closed):
            near, far = f"rod{bar}.b", f"rod{other}.b"
            if other == GROUND:
                far = f"stand{i}.b"
                jobs.append(lambda i=i, p=place: m.fixed(f"stand{i}", *p))
            ends = ("b", "a") if self.flipped[self.count + i] else ("a", "b")
            sets.setdefault(near, []).append(f"loop{i}.{ends[0]}")
            sets.setdefault(far, []).append(f"loop{i}.{ends[1]}")
            jobs.append(lambda i=i: m.revolute(f"loop{i}"))
        self.rng.shuffle(jobs)
        for job in jobs:
            job()
        for frame, others in sets.items():
            m.connect(frame, *others)
        return m

    def _bar_jobs(self, m: Any, bar: int, sets: dict[str, list[str]]) -> list[Callable[[], Any]]:
        below = f"rod{self.parent[bar]}.b"
        if self.parent[bar] == GROUND:
            below = f"ground{bar}.b"
        ends = ("b", "a") if self.flipped[bar] else ("a", "b")
        sets.setdefault(below, []).append(f"rev{bar}.{ends[0]}")
        sets[f"rev{bar}.{ends[1]}"] = [f"rod{bar}.a", f"body{bar}.a"]
        return [
            lambda: m.fixed(f"ground{bar}", *self.foot[bar]) if "ground" in below else None,
            lambda: m.revolute(f"rev{bar}"),
            lambda: m.rod(f"rod{bar}", *self.rod[bar]),
            lambda: m.body(f"body{bar}", self.mass[bar], self.inertia[bar], *self.centre[bar]),
        ]

    def values(self, speed: np.ndarray) -> dict[str, float]:
        """Angles and speeds of all hinges."""
        found = {}
        hinges = [(f"rev{b}", self.parent[b], b, self.flipped[b]) for b in range(self.count)]
        hinges += [
            (f"loop{i}", bar, other, self.flipped[self.count + i])
            for i, (bar, other, _) in enumerate(self.closed)
        ]
        for name, a, b, flipped in hinges:
            sign = -1 if flipped else 1
            for text, of in ((f"{name}.phi", self.angle), (f"der({name}.phi)", speed)):
                relative = (of[b] if b >= 0 else 0.0) - (of[a] if a >= 0 else 0.0)
                found[text] = sign * relative
        return found


def regular_case(planar: Any, seed: int) -> tuple[Case, np.ndarray]:
    """The next mechanism whose loops are independent in its pose, and their Jacobian."""
    while True:
        case = Case(seed)
        rows = [planar.jacobian(p, case.angle) for p in case.loop_paths()]
        constraints = np.vstack([np.zeros((0, case.count)), *rows])
        sizes = np.linalg.svd(constraints, compute_uv=False)
        if not len(sizes) or sizes[-1] > 1e-2:
            return case, constraints
        seed += 1000


@pytest.mark.parametrize("seed", range(100))
def test_a_random_mechanism(planar: Any, make: Callable[..., Dae], point: Any, seed: int) -> None:
    case, constraints = regular_case(planar, seed)
    paths = case.loop_paths()
    free = np.linalg.svd(constraints)[2][len(constraints) :]
    speed = free.T @ np.array([case.rng.uniform(-2, 2) for _ in free])

    m = case.model(planar)
    model = structure(make(*m.finished(), attributes=m.attributes, **m.parameters))
    check_sorted(model)
    assert model.state_count == 2 * (case.count - 2 * case.loops)
    p = point(model, case.values(speed))

    masses = [
        (case.mass[b], [*case.path(case.parent[b]), (b, case.centre[b])]) for b in range(case.count)
    ]
    closed = [(n, path) for path in paths for n in ((1.0, 0.0), (0.0, 1.0))]
    expected, multipliers = planar.accelerations(case.angle, speed, masses, case.inertia, closed)
    scale = 1 + np.max(np.abs(expected))
    got = np.array([p.of(f"body{b}.z") for b in range(case.count)])
    assert np.max(np.abs(got - expected)) < 1e-6 * scale
    forces = [p.of(f"loop{i}.a.{key}") for i in range(case.loops) for key in ("fx", "fy")]
    assert np.abs(forces) == pytest.approx(
        np.abs(multipliers), abs=1e-6 * (1 + np.max(np.abs(multipliers), initial=0))
    )
