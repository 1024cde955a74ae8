"""Planar mechanisms as equations in text, and an independent formulation of their mechanics.

The models have the equations of the library's components, written out. The reference
knows nothing of them: points are sums of rotated vectors, masses and inertias sit on
angles, loops are closed with multipliers (augmented Lagrange equations).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np


class Mechanism:
    """Collects the equations of components and connections; each frame has r, phi, f, t."""

    def __init__(self) -> None:
        self.equations: list[str] = []
        self.parameters: dict[str, float] = {"g": 9.81}
        self.attributes: dict[str, dict[str, Any]] = {}
        self._frames: dict[str, None] = {}

    def _add(self, name: str, frames: str, text: str, **parameters: float) -> str:
        for key, value in parameters.items():
            self.parameters[f"{name}.{key}"] = value
        for end in frames.split():
            self._frames[f"{name}.{end}"] = None
        words = {"N": name, "A": f"{name}.a", "B": f"{name}.b"}
        for line in text.strip().splitlines():
            self.equations.append(line.strip().format(**words))
        return name

    def fixed(self, name: str, x: float = 0, y: float = 0, angle: float = 0) -> None:
        self._add(
            name, "b", "{B}.x = {N}.x\n{B}.y = {N}.y\n{B}.phi = {N}.angle", x=x, y=y, angle=angle
        )

    def rod(self, name: str, x: float, y: float = 0) -> None:
        self._add(
            name,
            "a b",
            """{N}.rx = cos({A}.phi)*{N}.x - sin({A}.phi)*{N}.y
            {N}.ry = sin({A}.phi)*{N}.x + cos({A}.phi)*{N}.y
            {B}.x = {A}.x + {N}.rx
            {B}.y = {A}.y + {N}.ry
            {B}.phi = {A}.phi
            0 = {A}.fx + {B}.fx
            0 = {A}.fy + {B}.fy
            0 = {A}.t + {B}.t + ({N}.rx*{B}.fy - {N}.ry*{B}.fx)""",
            x=x,
            y=y,
        )

    def revolute(self, name: str, tau: str = "{N}.tau = 0") -> None:
        self._add(
            name,
            "a b",
            """{B}.x = {A}.x
            {B}.y = {A}.y
            {B}.phi = {A}.phi + {N}.phi
            {N}.w = der({N}.phi)
            {N}.z = der({N}.w)
            0 = {A}.fx + {B}.fx
            0 = {A}.fy + {B}.fy
            0 = {A}.t + {B}.t
            {N}.tau = -{B}.t
            """
            + tau,
        )
        self.attributes[f"{name}.phi"] = {"select": "prefer"}
        self.attributes[f"{name}.w"] = {"select": "prefer"}

    def prismatic(self, name: str, nx: float = 1, ny: float = 0) -> None:
        self._add(
            name,
            "a b",
            """{N}.ex = cos({A}.phi)*{N}.nx - sin({A}.phi)*{N}.ny
            {N}.ey = sin({A}.phi)*{N}.nx + cos({A}.phi)*{N}.ny
            {N}.dx = {N}.ex*{N}.s
            {N}.dy = {N}.ey*{N}.s
            {B}.x = {A}.x + {N}.dx
            {B}.y = {A}.y + {N}.dy
            {B}.phi = {A}.phi
            {N}.v = der({N}.s)
            {N}.acc = der({N}.v)
            0 = {A}.fx + {B}.fx
            0 = {A}.fy + {B}.fy
            0 = {A}.t + {B}.t + ({N}.dx*{B}.fy - {N}.dy*{B}.fx)
            {N}.f = -({N}.ex*{B}.fx + {N}.ey*{B}.fy)
            {N}.f = 0""",
            nx=nx,
            ny=ny,
        )
        self.attributes[f"{name}.s"] = {"select": "prefer"}
        self.attributes[f"{name}.v"] = {"select": "prefer"}

    def body(self, name: str, m: float, inertia: float, x: float = 0, y: float = 0) -> None:
        self._add(
            name,
            "a",
            """{N}.rx = {A}.x
            {N}.ry = {A}.y
            {N}.vx = der({N}.rx)
            {N}.vy = der({N}.ry)
            {N}.ax = der({N}.vx)
            {N}.ay = der({N}.vy)
            {N}.phi = {A}.phi
            {N}.w = der({N}.phi)
            {N}.z = der({N}.w)
            {N}.cx = cos({N}.phi)*{N}.x - sin({N}.phi)*{N}.y
            {N}.cy = sin({N}.phi)*{N}.x + cos({N}.phi)*{N}.y
            {N}.rcx = {N}.rx + {N}.cx
            {N}.rcy = {N}.ry + {N}.cy
            {N}.vcx = der({N}.rcx)
            {N}.vcy = der({N}.rcy)
            {N}.acx = der({N}.vcx)
            {N}.acy = der({N}.vcy)
            {A}.fx = {N}.m*{N}.acx
            {A}.fy = {N}.m*({N}.acy + g)
            {N}.I*{N}.z = {A}.t - ({N}.cx*{A}.fy - {N}.cy*{A}.fx)""",
            m=m,
            I=inertia,
            x=x,
            y=y,
        )
        for end in ("rx", "ry", "vx", "vy", "phi", "w"):
            self.attributes[f"{name}.{end}"] = {"select": "avoid"}

    def connect(self, *frames: str) -> None:
        first, *others = frames
        for key in ("x", "y", "phi"):
            self.equations += [f"{f}.{key} = {first}.{key}" for f in others]
        for key in ("fx", "fy", "t"):
            self.equations.append("0 = " + " + ".join(f"{f}.{key}" for f in frames))
        for f in frames:
            self._frames.pop(f)

    def finished(self) -> tuple[str, ...]:
        """All equations; what is connected to nothing carries no force."""
        loose: Iterable[str] = self._frames
        free = [f"{f}.{key} = 0" for f in loose for key in ("fx", "fy", "t")]
        return (*self.equations, *free)


def pendulum() -> Mechanism:
    m = Mechanism()
    m.fixed("ground")
    m.revolute("rev")
    m.body("bob", 2.0, 0.3, 0.7)
    m.connect("ground.b", "rev.a")
    m.connect("rev.b", "bob.a")
    return m


def chain(count: int) -> Mechanism:
    m = Mechanism()
    m.fixed("ground")
    end = "ground.b"
    for i in range(count):
        m.revolute(f"rev{i}")
        m.rod(f"rod{i}", 1.0)
        m.body(f"body{i}", 1.0, 0.1)
        m.connect(end, f"rev{i}.a", *([f"body{i - 1}.a"] if i else []))
        m.connect(f"rev{i}.b", f"rod{i}.a")
        end = f"rod{i}.b"
    m.connect(end, f"body{count - 1}.a")
    return m


def four_bar() -> Mechanism:
    m = Mechanism()
    m.fixed("gA")
    m.fixed("gD", 1.0)
    for name, length in (("crank", 0.4), ("coupler", 0.9), ("rocker", 0.8)):
        m.rod(name, length)
    m.body("crankBody", 1.0, 0.0134, 0.2)
    m.body("couplerBody", 2.0, 0.14, 0.45, 0.1)
    m.body("rockerBody", 1.5, 0.08, 0.4)
    for name in "ABCD":
        m.revolute(f"rev{name}")
    m.connect("gA.b", "revA.a")
    m.connect("revA.b", "crank.a", "crankBody.a")
    m.connect("crank.b", "revB.a")
    m.connect("revB.b", "coupler.a", "couplerBody.a")
    m.connect("gD.b", "revD.a")
    m.connect("revD.b", "rocker.a", "rockerBody.a")
    m.connect("coupler.b", "revC.a")
    m.connect("revC.b", "rocker.b")
    return m


def ladder(count: int) -> Mechanism:
    """N four-bars in a row: N + 1 uprights on the ground, joined by N bars at the top."""
    m = Mechanism()
    for i in range(count + 1):
        m.fixed(f"g{i}", float(i))
        m.revolute(f"foot{i}")
        m.rod(f"up{i}", 1.0)
        m.body(f"upBody{i}", 1.0, 0.1, 0.5)
        m.connect(f"g{i}.b", f"foot{i}.a")
        m.connect(f"foot{i}.b", f"up{i}.a", f"upBody{i}.a")
    for i in range(count):
        m.revolute(f"left{i}")
        m.revolute(f"right{i}")
        m.rod(f"bar{i}", 1.0)
        m.body(f"barBody{i}", 1.0, 0.1, 0.5)
        m.connect(f"left{i}.b", f"bar{i}.a", f"barBody{i}.a")
        m.connect(f"bar{i}.b", f"right{i}.a")
    for i in range(count + 1):
        ends = [f"up{i}.b"]
        if i < count:
            ends.append(f"left{i}.a")
        if i:
            ends.append(f"right{i - 1}.b")
        m.connect(*ends)
    return m


def crank_slider() -> Mechanism:
    m = Mechanism()
    m.fixed("ground")
    m.revolute("revA")
    m.rod("crank", 0.3)
    m.body("crankBody", 1.0, 0.02, 0.15)
    m.revolute("revB")
    m.rod("conrod", 0.8)
    m.body("conrodBody", 1.5, 0.05, 0.4)
    m.revolute("revC")
    m.prismatic("slide")
    m.body("piston", 2.0, 0.01)
    m.connect("ground.b", "revA.a", "slide.a")
    m.connect("revA.b", "crank.a", "crankBody.a")
    m.connect("crank.b", "revB.a")
    m.connect("revB.b", "conrod.a", "conrodBody.a")
    m.connect("conrod.b", "revC.a")
    m.connect("slide.b", "revC.b", "piston.a")
    return m


# An independent formulation -----------------------------------------------------------------

#: A point: the sum of vectors, each turning with the angle of a bar.
PointOf = Sequence[tuple[int, tuple[float, float]]]


def _rotated(angle: float, v: tuple[float, float]) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])


def jacobian(point: PointOf, q: np.ndarray) -> np.ndarray:
    j = np.zeros((2, len(q)))
    for bar, v in point:
        j[:, bar] += _rotated(q[bar] + np.pi / 2, v)
    return j


def _drift(point: PointOf, q: np.ndarray, w: np.ndarray) -> np.ndarray:
    """The part of the acceleration that comes from velocities."""
    return sum((-_rotated(q[b], v) * w[b] ** 2 for b, v in point), np.zeros(2))


def accelerations(
    q: np.ndarray,
    w: np.ndarray,
    masses: Sequence[tuple[float, PointOf]],
    inertias: Sequence[float],
    closed: Sequence[tuple[tuple[float, float], PointOf]],
    driven: Sequence[int] = (),
) -> tuple[np.ndarray, np.ndarray]:
    """Angular accelerations of the bars, and multipliers of direction . point = constant.

    Driven bars turn at constant speed; their multipliers, the torques, come last.
    """
    mass = np.diag(np.array(inertias, dtype=float))
    force = np.zeros(len(q))
    for m, point in masses:
        j = jacobian(point, q)
        mass += m * j.T @ j
        force += m * j.T @ (np.array([0, -9.81]) - _drift(point, q, w))
    rows = np.array([np.array(n) @ jacobian(p, q) for n, p in closed]).reshape(-1, len(q))
    rows = np.vstack([rows, np.eye(len(q))[list(driven)]])
    right = np.array([-np.array(n) @ _drift(p, q, w) for n, p in closed] + [0.0] * len(driven))
    k = len(right)
    full = np.block([[mass, rows.T], [rows, np.zeros((k, k))]])
    solution = np.linalg.solve(full, np.concatenate([force, right]))
    return solution[: len(q)], solution[len(q) :]
