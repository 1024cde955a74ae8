"""Mechanisms sorted and evaluated, against an independent formulation of their mechanics.

The models have the equations of the library's components, written out. The reference
knows nothing of them: points are sums of rotated vectors, masses and inertias sit on
angles, loops are closed with multipliers (augmented Lagrange equations).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import pytest

from planarc.ir.dae import Dae
from planarc.ir.sorted import Block, SortedDae
from planarc.ir.sortedcheck import check_sorted
from planarc.structure.pipeline import structure


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


def _jacobian(point: PointOf, q: np.ndarray) -> np.ndarray:
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
        j = _jacobian(point, q)
        mass += m * j.T @ j
        force += m * j.T @ (np.array([0, -9.81]) - _drift(point, q, w))
    rows = np.array([np.array(n) @ _jacobian(p, q) for n, p in closed]).reshape(-1, len(q))
    rows = np.vstack([rows, np.eye(len(q))[list(driven)]])
    right = np.array([-np.array(n) @ _drift(p, q, w) for n, p in closed] + [0.0] * len(driven))
    k = len(right)
    full = np.block([[mass, rows.T], [rows, np.zeros((k, k))]])
    solution = np.linalg.solve(full, np.concatenate([force, right]))
    return solution[: len(q)], solution[len(q) :]


def _sorted(make: Callable[..., Dae], m: Mechanism) -> SortedDae:
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


def test_pendulum(make: Callable[..., Dae], point: Any) -> None:
    model = _sorted(make, pendulum())
    assert _candidates(model) == ["rev.phi", "rev.w"]
    assert _residual_counts(model) == [0, 0, 1]
    p = point(model, {"rev.phi": 0.4, "der(rev.phi)": 1.5})
    arm = 2.0 * 0.7
    assert p.of("rev.z") == pytest.approx(-arm * 9.81 * np.cos(0.4) / (0.3 + arm * 0.7), rel=1e-12)
    assert p.of("bob.w") == 1.5
    assert p.of("ground.b.fy") == pytest.approx(-p.of("bob.a.fy"))


def test_chain_of_three(make: Callable[..., Dae], point: Any) -> None:
    model = _sorted(make, chain(3))
    names = [f"rev{i}" for i in range(3)]
    assert _candidates(model) == [f"{n}.phi" for n in names] + [f"{n}.w" for n in names]
    assert _residual_counts(model) == [0, 0, 3]
    q, w = np.array([0.3, -0.5, 1.1]), np.array([0.7, -1.2, 0.4])
    relative = np.diff(q, prepend=0), np.diff(w, prepend=0)
    states = {f"{n}.phi": a for n, a in zip(names, relative[0], strict=True)}
    states |= {f"der({n}.phi)": a for n, a in zip(names, relative[1], strict=True)}
    p = point(model, states)
    tips = [(1.0, [(k, (1.0, 0.0)) for k in range(i + 1)]) for i in range(3)]
    expected, _ = accelerations(q, w, tips, [0.1] * 3, [])
    got = np.cumsum([p.of(f"{n}.z") for n in names])
    assert got == pytest.approx(expected, rel=1e-9)


def _four_bar_reference(
    q: np.ndarray, w: np.ndarray, driven: Sequence[int] = ()
) -> tuple[np.ndarray, np.ndarray]:
    masses: list[tuple[float, PointOf]] = [
        (1.0, [(0, (0.2, 0.0))]),
        (2.0, [(0, (0.4, 0.0)), (1, (0.45, 0.1))]),
        (1.5, [(2, (0.4, 0.0))]),
    ]
    loop: PointOf = [(0, (0.4, 0.0)), (1, (0.9, 0.0)), (2, (-0.8, 0.0))]
    closed = [((1.0, 0.0), loop), ((0.0, 1.0), loop)]
    return accelerations(q, w, masses, [0.0134, 0.14, 0.08], closed, driven)


@pytest.mark.parametrize("state", ["revA.phi", "revB.phi", "revC.phi"])
def test_four_bar_with_any_angle_as_the_state(
    make: Callable[..., Dae], point: Any, state: str
) -> None:
    model = _sorted(make, four_bar())
    assert model.state_count == 2
    assert len(model.candidates) == 6
    assert _residual_counts(model) == [2, 2, 5]
    guesses = {"revA.phi": 1.0, "revB.phi": -0.46, "revC.phi": 1.05}
    first = point(model, {"revA.phi": 1.0, "der(revA.phi)": 2.0}, guesses)
    angle, speed = first.of(state), first.of(state.replace(".phi", ".w"))
    p = point(model, {state: angle, f"der({state})": speed}, guesses)
    q = np.array([p.of(f"{bar}.a.phi") for bar in ("crank", "coupler", "rocker")])
    w = np.array([p.of(f"{bar}Body.w") for bar in ("crank", "coupler", "rocker")])
    expected, multipliers = _four_bar_reference(q, w)
    got = [p.of(f"{bar}Body.z") for bar in ("crank", "coupler", "rocker")]
    assert got == pytest.approx(expected, rel=1e-6)
    # The multipliers are the force of hinge C on the coupler, reversed.
    force = [p.of("revC.a.fx"), p.of("revC.a.fy")]
    assert np.abs(force) == pytest.approx(np.abs(multipliers), rel=1e-6)


def test_crank_slider(make: Callable[..., Dae], point: Any) -> None:
    model = _sorted(make, crank_slider())
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
    end: PointOf = [(0, (0.3, 0.0)), (1, (0.8, 0.0))]
    masses: list[tuple[float, PointOf]] = [
        (1.0, [(0, (0.15, 0.0))]),
        (1.5, [(0, (0.3, 0.0)), (1, (0.4, 0.0))]),
        (2.0, end),
    ]
    expected, multipliers = accelerations(
        np.array([phi, rod]), np.array([w, rod_w]), masses, [0.02, 0.05], [((0, 1), end)]
    )
    assert p.of("revA.z") == pytest.approx(expected[0], rel=1e-6)
    assert p.of("revB.z") == pytest.approx(expected[1] - expected[0], rel=1e-6)
    assert abs(p.of("slide.b.fy")) == pytest.approx(abs(multipliers[0]), rel=1e-6)


def test_a_driven_four_bar_has_no_states(make: Callable[..., Dae], point: Any) -> None:
    m = four_bar()
    m.equations.remove("revA.tau = 0")
    m.equations.append("revA.phi = 1 + 2*time")
    model = _sorted(make, m)
    assert model.state_count == 0
    p = point(model, {}, {"revB.phi": -0.46, "revC.phi": 1.05})
    q = np.array([p.of(f"{bar}.a.phi") for bar in ("crank", "coupler", "rocker")])
    w = np.array([p.of(f"{bar}Body.w") for bar in ("crank", "coupler", "rocker")])
    assert p.of("revA.w") == 2
    assert p.of("revA.z") == 0
    expected, multipliers = _four_bar_reference(q, w, driven=[0])
    got = [p.of(f"{bar}Body.z") for bar in ("crank", "coupler", "rocker")]
    assert got == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert abs(p.of("revA.tau")) == pytest.approx(abs(multipliers[2]), rel=1e-6)


def test_a_ladder_of_loops_has_one_degree_of_freedom(make: Callable[..., Dae]) -> None:
    model = _sorted(make, ladder(3))
    assert model.state_count == 2
    assert _residual_counts(model)[:2] == [6, 6]


def test_velocities_are_torn_like_positions(make: Callable[..., Dae]) -> None:
    for m in (four_bar(), crank_slider(), ladder(2)):
        model = _sorted(make, m)
        position, velocity = (
            [t.name for s in level.steps if isinstance(s, Block) for t in s.tears]
            for level in model.levels[:2]
        )
        assert position == velocity
        assert all(s.linear for s in model.levels[1].steps if isinstance(s, Block) if s.residuals)


def test_the_same_model_is_sorted_alike_however_it_is_read(make: Callable[..., Dae]) -> None:
    first, again = (_sorted(make, four_bar()) for _ in range(2))
    assert repr(first.levels) == repr(again.levels)


def test_work_grows_with_the_size_of_a_chain(make: Callable[..., Dae]) -> None:
    sizes = []
    for count in (10, 20):
        m = chain(count)
        dae = make(*m.finished(), attributes=m.attributes, **m.parameters)
        structure(dae)
        sizes.append(len(dae.table.all))
    assert sizes[1] < 2.1 * sizes[0]
