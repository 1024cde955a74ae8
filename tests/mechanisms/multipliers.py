"""The mechanics of a mechanism in absolute coordinates, with Lagrange multipliers.

It shares nothing with planarc: each body has the coordinates x, y of its centre of mass
and its angle; each joint adds rows to the constraints g(q) = 0; accelerations a and
multipliers l solve

    [ M  -G' ] [ a ]   [ Q        ]
    [ G   0  ] [ l ] = [ -dG/dt v ]

Reference: E. J. Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems,
           1989, section 6.3 (the augmented equations of planar systems).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

GROUND = -1
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # by a right angle


class Reference:
    def __init__(self, mechanism: Any) -> None:
        self.m = mechanism
        self.size = 3 * len(mechanism.bodies)
        self.mass = np.array(
            [v for b in mechanism.bodies for v in (b.mass, b.mass, b.inertia)], dtype=float
        )
        self.lengths = [
            math.dist(mechanism.world(j.a, j.at_a), mechanism.world(j.b, j.at_b))
            for j in mechanism.joints
        ]

    # Where things are

    def start(self) -> np.ndarray:
        """Coordinates at the start."""
        return np.array(
            [
                v
                for i, b in enumerate(self.m.bodies)
                for v in (*self.m.world(i, b.centre), b.place[2])
            ]
        )

    def drift(self, q: np.ndarray) -> np.ndarray:
        """Speeds at the start that the joints allow."""
        g = self.constraints(q, np.zeros(self.size))[1]
        v = np.array(self.m.drift)
        return v - np.linalg.lstsq(g, g @ v, rcond=None)[0] if len(g) else v

    def frame_speeds(self, q: np.ndarray, v: np.ndarray) -> list[tuple[float, float, float]]:
        """Of the bodies' frames: what the model's start values are about."""
        found = []
        for i in range(len(self.m.bodies)):
            _, velocity, _, _ = self.point(q, v, i, (0.0, 0.0))
            found.append((float(velocity[0]), float(velocity[1]), float(v[3 * i + 2])))
        return found

    def point(
        self, q: np.ndarray, v: np.ndarray, body: int, at: tuple[float, float]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Place, velocity, Jacobian (2 x size), and acceleration where a = 0."""
        jacobian = np.zeros((2, self.size))
        if body == GROUND:
            return np.array(at), np.zeros(2), jacobian, np.zeros(2)
        k = 3 * body
        centre, angle, w = self.m.bodies[body].centre, q[k + 2], v[k + 2]
        c, s = math.cos(angle), math.sin(angle)
        x, y = at[0] - centre[0], at[1] - centre[1]
        u = np.array([c * x - s * y, s * x + c * y])
        jacobian[0, k] = jacobian[1, k + 1] = 1.0
        jacobian[:, k + 2] = -u[1], u[0]
        return q[k : k + 2] + u, jacobian @ v, jacobian, -w * w * u

    def angle(self, q: np.ndarray, body: int) -> tuple[float, np.ndarray]:
        row = np.zeros(self.size)
        if body == GROUND:
            return 0.0, row
        row[3 * body + 2] = 1.0
        return float(q[3 * body + 2]), row

    # Constraints

    def constraints(
        self, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values, Jacobian, and second derivative where a = 0; by joints in their order."""
        values: list[float] = []
        rows: list[np.ndarray] = []
        biases: list[float] = []
        for joint, length in zip(self.m.joints, self.lengths, strict=True):
            pa, va, ja, ba = self.point(q, v, joint.a, joint.at_a)
            pb, vb, jb, bb = self.point(q, v, joint.b, joint.at_b)
            d, speed, jd, bias = pb - pa, vb - va, jb - ja, bb - ba
            if joint.kind == "revolute":
                values += d.tolist()
                rows += list(jd)
                biases += bias.tolist()
            elif joint.kind == "rod":
                values.append(float(d @ d - length**2) / (2 * length))
                rows.append(d @ jd / length)
                biases.append(float(speed @ speed + d @ bias) / length)
            else:
                angle, ra = self.angle(q, joint.a)
                other, rb = self.angle(q, joint.b)
                w = float(ra @ v)
                n = self.normal(q, joint)
                values += [float(n @ d), other + joint.turn - angle]
                rows += [n @ jd + float(TURN @ n @ d) * ra, rb - ra]
                biases += [float(n @ bias + 2 * w * (TURN @ n) @ speed - w * w * n @ d), 0.0]
        shape = (len(rows), self.size)
        return np.array(values), np.array(rows).reshape(shape), np.array(biases)

    def normal(self, q: np.ndarray, joint: Any) -> np.ndarray:
        """Across the axis of a prismatic joint."""
        angle, _ = self.angle(q, joint.a)
        c, s = math.cos(angle), math.sin(angle)
        x, y = joint.axis
        return np.array([-(s * x + c * y), c * x - s * y])

    def regularity(self, q: np.ndarray) -> float:
        """The smallest singular value of the constraints."""
        g = self.constraints(q, np.zeros(self.size))[1]
        return float(np.linalg.svd(g, compute_uv=False)[-1]) if len(g) else 1.0

    # Forces

    def loads(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        total = self.mass * np.array([*self.m.gravity, 0.0] * len(self.m.bodies))
        for load in self.m.loads:
            pa, va, ja, _ = self.point(q, v, load.a, load.at_a)
            pb, vb, jb, _ = self.point(q, v, load.b, load.at_b)
            n = load.numbers
            if load.kind in ("spring", "damper"):
                d = pb - pa
                s = float(np.hypot(*d))
                e = d / s
                tension = n[0] * (s - n[1] if load.kind == "spring" else float(e @ (vb - va)))
                total -= tension * (e @ (jb - ja))
            elif load.kind == "push":
                total += np.array([n[0] * math.sin(n[2] * t + n[3]), n[1]]) @ jb
            else:
                torque = n[0] * math.cos(n[1] * t)
                total += torque * (self.angle(q, load.b)[1] - self.angle(q, load.a)[1])
        return total

    def solve(
        self, t: float, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, list[tuple[float, float, float]]]:
        """Accelerations; and what each joint does to its body b: force, and torque about
        b's point."""
        _, g, bias = self.constraints(q, v)
        count = len(g)
        matrix = np.zeros((self.size + count, self.size + count))
        matrix[: self.size, : self.size] = np.diag(self.mass)
        matrix[: self.size, self.size :] = -g.T
        matrix[self.size :, : self.size] = g
        found = np.linalg.solve(matrix, np.concatenate([self.loads(t, q, v), -bias]))
        return found[: self.size], self._forces(q, found[self.size :])

    def _forces(self, q: np.ndarray, multipliers: np.ndarray) -> list[tuple[float, float, float]]:
        found, k, still = [], 0, np.zeros(self.size)
        for joint, length in zip(self.m.joints, self.lengths, strict=True):
            torque = 0.0
            if joint.kind == "revolute":
                force = multipliers[k : k + 2]
                k += 2
            elif joint.kind == "rod":
                pa, pb = (
                    self.point(q, still, body, at)[0]
                    for body, at in ((joint.a, joint.at_a), (joint.b, joint.at_b))
                )
                force = multipliers[k] * (pb - pa) / length
                k += 1
            else:
                force = multipliers[k] * self.normal(q, joint)
                torque = float(multipliers[k + 1])
                k += 2
            found.append((float(force[0]), float(force[1]), torque))
        return found

    # Motion

    def move(self, stop: float) -> tuple[np.ndarray, np.ndarray, float]:
        """Coordinates and speeds at the end, and the least regularity on the way.

        Integrated as an ordinary differential equation; in a short time it drifts off its
        constraints by no more than the integrator's errors.
        """
        from scipy.integrate import solve_ivp

        q, v = self.start(), self.drift(self.start())
        n = self.size

        def slope(t: float, y: np.ndarray) -> np.ndarray:
            return np.concatenate([y[n:], self.solve(t, y[:n], y[n:])[0]])

        run = solve_ivp(slope, (0, stop), np.concatenate([q, v]), "DOP853", rtol=1e-8, atol=1e-8)
        least = min(self.regularity(column[:n]) for column in run.y.T)
        return run.y[:n, -1], run.y[n:, -1], least
