"""Mechanisms with joints that repeat others, and their forces of least squares.

A joint is repeated without changing what can move: a hinge by another one about the same point, a
slide by one beside it with the same direction, a pair of parallel rods by a third one. Then the
multipliers of `multipliers.py` are not unique. Of all that fit, those are taken whose forces and
torques at both ends of all joints have the smallest sum of squares.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Any

import numpy as np
from agreement import usable
from mechanism import Joint, Mechanism, Point, draw, turned
from multipliers import Reference


def redundant(seed: int) -> tuple[Mechanism, int]:
    """A mechanism, and how many conditions of its joints follow from others."""
    rng = random.Random(seed)
    while True:
        m = draw(seed)
        if rng.random() < 0.4:
            m = _with_rods(rng, m)
        if _repeatable(m) and usable(m):
            break
        seed += 100_000
    found = 0
    for _ in range(rng.choice((1, 1, 2))):
        m, more = _repeated(rng, m)
        found += more
    return m, found


def _repeated(rng: random.Random, m: Mechanism) -> tuple[Mechanism, int]:
    """One joint more, at a random place among the closing ones."""
    rods = [j for j in _repeatable(m) if j.kind == "rod"]
    others = [j for j in _repeatable(m) if j.kind != "rod"]
    old = rng.choice(rods or others) if rng.random() < 0.5 else rng.choice(others or rods)
    if old.kind == "revolute":
        new, count = old, 2
    elif old.kind == "prismatic":
        aside, along = _near(rng), rng.uniform(-0.5, 0.5)
        at_a = old.at_a[0] + aside[0], old.at_a[1] + aside[1]
        # b's angle plus `turn` is that of a: so much b sees a's directions turned.
        shift = turned((aside[0] + along * old.axis[0], aside[1] + along * old.axis[1]), old.turn)
        at_b = old.at_b[0] + shift[0], old.at_b[1] + shift[1]
        new, count = replace(old, at_a=at_a, at_b=at_b), 2
    else:
        new, count = _beside(rng, m, old), 1
    place = rng.randint(len(m.bodies), len(m.joints))
    return replace(m, joints=(*m.joints[:place], new, *m.joints[place:])), count


def _repeatable(m: Mechanism) -> list[Joint]:
    return [j for j in m.joints if j.kind != "rod" or _is_one_of_two(m, j)]


def _near(rng: random.Random) -> Point:
    return rng.uniform(-0.8, 0.8), rng.uniform(-0.8, 0.8)


def _with_rods(rng: random.Random, m: Mechanism) -> Mechanism:
    """Two parallel rods of equal length between two bodies that nothing else ties."""
    free = [i for i, j in enumerate(m.joints[: len(m.bodies)]) if j.kind == "rod"]
    if not free:
        return m
    old = m.joints[rng.choice(free)]
    return replace(m, joints=(*m.joints, _beside(rng, m, old)))


def _beside(rng: random.Random, m: Mechanism, rod: Joint) -> Joint:
    """A rod parallel to another one between the same bodies, as long as it is."""
    shift = _near(rng)
    a, b = (turned(shift, -m.place(body)[2]) for body in (rod.a, rod.b))
    at_a = rod.at_a[0] + a[0], rod.at_a[1] + a[1]
    at_b = rod.at_b[0] + b[0], rod.at_b[1] + b[1]
    return replace(rod, at_a=at_a, at_b=at_b)


def _is_one_of_two(m: Mechanism, rod: Joint) -> bool:
    """Whether another rod of the same length between the same bodies is parallel to it."""
    return any(
        other.kind == "rod"
        and other is not rod
        and (other.a, other.b) == (rod.a, rod.b)
        and math.dist(_way(m, other), _way(m, rod)) < 1e-9
        for other in m.joints
    )


def _way(m: Mechanism, j: Joint) -> Point:
    a, b = m.world(j.a, j.at_a), m.world(j.b, j.at_b)
    return b[0] - a[0], b[1] - a[1]


class LeastSquares(Reference):
    """The same mechanics; of all multipliers those of the smallest sum of squares."""

    def __init__(self, mechanism: Any, dependent: int) -> None:
        super().__init__(mechanism)
        self.dependent = dependent

    def regularity(self, q: np.ndarray) -> float:
        g = self.constraints(q, np.zeros(self.size))[1]
        sizes = np.linalg.svd(g, compute_uv=False)
        return float(sizes[len(g) - self.dependent - 1])

    def solve(
        self, t: float, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, list[tuple[float, float, float]]]:
        _, g, bias = self.constraints(q, v)
        load = self.loads(t, q, v)
        rank = len(g) - self.dependent
        # Accelerations from Gauss' principle: in the measure of the masses nearest to those
        # without joints.
        root = np.sqrt(self.mass)
        scaled = np.linalg.pinv(g / root, rcond=1e-9)
        assert np.linalg.matrix_rank(g, tol=1e-7) == rank
        a = load / self.mass + (scaled @ (-bias - g @ (load / self.mass))) / root
        missing = self.mass * a - load
        some = np.linalg.lstsq(g.T, missing, rcond=1e-9)[0]
        open_ = np.linalg.svd(g.T)[2][rank:].T
        ends = np.column_stack([self._ends(q, e) for e in np.eye(len(g))])
        change = np.linalg.lstsq(ends @ open_, -ends @ some, rcond=None)[0]
        return a, self._forces(q, some + open_ @ change)

    def _ends(self, q: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        """Forces and torques at both ends of all joints."""
        found: list[float] = []
        still = np.zeros(self.size)
        for joint, (x, y, torque) in zip(self.m.joints, self._forces(q, multipliers), strict=True):
            d = (
                self.point(q, still, joint.b, joint.at_b)[0]
                - self.point(q, still, joint.a, joint.at_a)[0]
            )
            found += [x, y, torque, -x, -y, -torque - d[0] * y + d[1] * x]
        return np.array(found)
