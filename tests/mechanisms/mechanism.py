"""Planar mechanisms as data: made at random, written as a model, made smaller.

Everything random is drawn here, from one seed. Loops close by construction: the last
joint of a loop is put where its bodies happen to be. The model's text has its components
and connections in random order, and every arm and joint with either end first.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace

Point = tuple[float, float]
GROUND = -1
#: Loops of one mechanism after the other: larger ones take longer and come less often.
LOOPS = (0, 1, 2, 1, 3, 0, 2, 1, 4, 2)


@dataclass(frozen=True)
class Body:
    mass: float
    inertia: float
    centre: Point  # of mass, in the body's frame
    place: tuple[float, float, float]  # of the frame at the start: x, y, angle


@dataclass(frozen=True)
class Joint:
    """Between a point of body a and one of body b, each in its body's frame.

    revolute    the points coincide
    prismatic   b's point lies on a line through a's, along `axis` in a's frame; b's angle
                plus `turn` is that of a
    rod         the points keep their distance (JointRR)
    """

    kind: str
    a: int
    at_a: Point
    b: int
    at_b: Point
    axis: Point = (1.0, 0.0)
    turn: float = 0.0


@dataclass(frozen=True)
class Load:
    """kind: spring (stiffness, length), damper (damping), push (x, y, frequency, phase) on
    b's point, torque (size, frequency) from a on b."""

    kind: str
    a: int
    at_a: Point
    b: int
    at_b: Point
    numbers: tuple[float, ...]


@dataclass(frozen=True)
class Mechanism:
    """The first joints are those of the tree, joint i carrying body i; others close loops.

    `whims` seeds what does not change the motion: orders, ends, the way to the ground.
    `drift` are numbers that the speeds at the start are made of.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    loads: tuple[Load, ...]
    gravity: Point
    drift: tuple[float, ...]
    whims: int

    def place(self, body: int) -> tuple[float, float, float]:
        return (0.0, 0.0, 0.0) if body == GROUND else self.bodies[body].place

    def world(self, body: int, point: Point) -> Point:
        """Where a point of a body is at the start."""
        x, y, angle = self.place(body)
        u = turned(point, angle)
        return x + u[0], y + u[1]

    def to_json(self) -> str:
        return json.dumps(asdict(self), indent=1)


def from_json(text: str) -> Mechanism:
    def tuples(value: object) -> object:
        return tuple(map(tuples, value)) if isinstance(value, list) else value

    data = json.loads(text)

    def rows(cls: type, key: str) -> tuple:  # type: ignore[type-arg]
        return tuple(cls(**{k: tuples(v) for k, v in row.items()}) for row in data[key])

    return Mechanism(
        rows(Body, "bodies"),
        rows(Joint, "joints"),
        rows(Load, "loads"),
        tuple(data["gravity"]),  # type: ignore[arg-type]
        tuple(data["drift"]),
        data["whims"],
    )


def turned(v: Point, angle: float) -> Point:
    c, s = math.cos(angle), math.sin(angle)
    return c * v[0] - s * v[1], s * v[0] + c * v[1]


# At random ------------------------------------------------------------------------------------


def draw(seed: int) -> Mechanism:
    """None to four loops, and bodies enough to move."""
    rng = random.Random(seed)
    kinds = ("revolute", "revolute", "prismatic", "rod")
    loops = [rng.choice(kinds) for _ in range(LOOPS[seed % len(LOOPS)])]
    taken = sum(1 if kind == "rod" else 2 for kind in loops)
    tree: list[str] = []
    freedom = 0
    while freedom <= taken or rng.random() < 0.25:
        tree.append(rng.choice(("revolute",) * 5 + ("prismatic",) * 2 + ("rod",)))
        freedom += 2 if tree[-1] == "rod" else 1
    bodies: list[Body] = []
    joints: list[Joint] = []
    for i, kind in enumerate(tree):
        parent = rng.randint(max(GROUND, i - 3), i - 1)
        body, joint = _branch(rng, bodies, kind, parent, i)
        bodies.append(body)
        joints.append(joint)
    m = Mechanism(tuple(bodies), (), (), (rng.uniform(-3, 3), rng.uniform(-12, 0)), (), seed)
    joints += [j for kind in loops if (j := _closing(rng, m, kind)) is not None]
    loads = [_load(rng, m) for _ in range(rng.randint(0, 4))]
    drift = tuple(rng.uniform(-1.5, 1.5) for _ in range(3 * len(bodies)))
    return replace(m, joints=tuple(joints), loads=tuple(loads), drift=drift)


def _near(rng: random.Random, size: float) -> Point:
    return rng.uniform(-size, size), rng.uniform(-size, size)


def _unit(rng: random.Random) -> Point:
    return turned((1.0, 0.0), rng.uniform(-math.pi, math.pi))


def _either(rng: random.Random, joint: Joint) -> Joint:
    """The same with the other body at end a, half of the time."""
    if rng.random() < 0.5:
        return joint
    # b + turn = a: seen from b, the axis is turned back.
    axis = turned(joint.axis, joint.turn)
    return Joint(joint.kind, joint.b, joint.at_b, joint.a, joint.at_a, axis, -joint.turn)


def _branch(
    rng: random.Random, bodies: list[Body], kind: str, parent: int, number: int
) -> tuple[Body, Joint]:
    """A body on the parent: its frame lies wherever the joint puts it."""
    at_a = _near(rng, 2.0 if parent == GROUND else 1.0)
    at_b = _near(rng, 0.6)
    axis, angle, turn = _unit(rng), rng.uniform(-3, 3), 0.0
    x, y, parent_angle = (0.0, 0.0, 0.0) if parent == GROUND else bodies[parent].place
    arm = at_a
    if kind == "prismatic":
        s = rng.uniform(-1, 1)
        arm = at_a[0] + s * axis[0], at_a[1] + s * axis[1]
        turn = parent_angle - angle
    elif kind == "rod":
        length, way = rng.uniform(0.4, 1.2), _unit(rng)
        arm = at_a[0] + length * way[0], at_a[1] + length * way[1]
    tip, back = turned(arm, parent_angle), turned(at_b, angle)
    body = Body(
        rng.uniform(0.5, 3),
        rng.uniform(0.02, 0.3),
        _near(rng, 0.5),
        (x + tip[0] - back[0], y + tip[1] - back[1], angle),
    )
    return body, _either(rng, Joint(kind, parent, at_a, number, at_b, axis, turn))


def _closing(rng: random.Random, m: Mechanism, kind: str) -> Joint | None:
    """A joint between two parts as they are."""
    a, b = rng.sample(range(GROUND, len(m.bodies)), 2)
    at_a, axis = _near(rng, 1.0), _unit(rng)
    if kind == "rod":
        return Joint(kind, a, at_a, b, _near(rng, 1.0))
    s = rng.uniform(-1, 1) if kind == "prismatic" else 0.0
    x, y, angle = m.place(b)
    here = m.world(a, (at_a[0] + s * axis[0], at_a[1] + s * axis[1]))
    at_b = turned((here[0] - x, here[1] - y), -angle)
    turn = m.place(a)[2] - angle if kind == "prismatic" else 0.0
    return Joint(kind, a, at_a, b, at_b, axis, turn)


def _load(rng: random.Random, m: Mechanism) -> Load:
    a, b = rng.sample(range(GROUND, len(m.bodies)), 2)
    if b == GROUND:
        a, b = b, a
    kind = rng.choice(("spring", "damper", "push", "torque"))
    numbers = {
        "spring": (rng.uniform(5, 60), rng.uniform(0.2, 1)),
        "damper": (rng.uniform(0.2, 4),),
        "push": (*_near(rng, 10), rng.uniform(0.5, 6), rng.uniform(-3, 3)),
        "torque": (rng.uniform(-4, 4), rng.uniform(0.5, 6)),
    }
    return Load(kind, a, _near(rng, 1.0), b, _near(rng, 1.0), numbers[kind])


# As text --------------------------------------------------------------------------------------


def model_text(m: Mechanism, speeds: list[tuple[float, float, float]]) -> str:
    """The model; `speeds` are those of the bodies' frames at the start."""
    return _Writer(m, speeds).text()


class _Writer:
    def __init__(self, m: Mechanism, speeds: list[tuple[float, float, float]]) -> None:
        self.m, self.speeds = m, [*speeds, (0.0, 0.0, 0.0)]  # the last one is the ground's
        self.rng = random.Random(m.whims)
        self.declarations: list[str] = []
        self.equations: list[str] = []

    def text(self) -> str:
        for i, body in enumerate(self.m.bodies):
            self._body(i, body)
        for i, joint in enumerate(self.m.joints):
            self._joint(i, joint)
        for i, load in enumerate(self.m.loads):
            self._load(i, load)
        self.rng.shuffle(self.declarations)
        self.rng.shuffle(self.equations)
        gx, gy = self.m.gravity
        g = math.hypot(gx, gy)
        field = f"g={g!r}, n={{{gx!r}, {gy!r}}}"
        world = f"inner PlanarMultiBody.World world(enableAnimation=false, {field});"
        return "\n".join(
            ["model Random", world, *self.declarations, "equation", *self.equations, "end Random;"]
        )

    def _connect(self, p: str, q: str) -> None:
        if self.rng.random() < 0.5:
            p, q = q, p
        self.equations.append(f"connect({p}, {q});")

    def _body(self, i: int, body: Body) -> None:
        starts = ""
        if self.m.joints[i].kind == "rod":  # no joint coordinate tells where it is
            x, y, angle = body.place
            vx, vy, w = self.speeds[i]
            starts = (
                f", r(start={{{x!r}, {y!r}}}), v(start={{{vx!r}, {vy!r}}}), "
                f"phi(start={angle!r}), w(start={w!r})"
            )
        cx, cy = body.centre
        self.declarations.append(
            f"PlanarMultiBody.Parts.Body body{i}(m={body.mass!r}, I={body.inertia!r}, "
            f"r_CM={{{cx!r}, {cy!r}}}{starts});"
        )

    def _arm(self, name: str, body: int, at: Point, turn: float, end: str) -> None:
        """From a body to a frame `end` beside it, turned by `turn`."""
        home = f"body{body}.frame_a" if body != GROUND else "world.frame_b"
        if body == GROUND and self.rng.random() < 0.5:
            self.declarations.append(
                f"PlanarMultiBody.Parts.Fixed {name}(r={{{at[0]!r}, {at[1]!r}}}, phi={turn!r});"
            )
            self._connect(f"{name}.frame_b", end)
            return
        ends, r, angle = ("frame_a", "frame_b"), at, turn
        if self.rng.random() < 0.5:
            ends, angle = ("frame_b", "frame_a"), -turn
            r = turned((-at[0], -at[1]), -turn)
        kind, more = "FixedTranslation", ""
        if turn:
            kind, more = "FixedRotation", f", angle={angle!r}"
        self.declarations.append(
            f"PlanarMultiBody.Parts.{kind} {name}(r={{{r[0]!r}, {r[1]!r}}}{more});"
        )
        self._connect(home, f"{name}.{ends[0]}")
        self._connect(f"{name}.{ends[1]}", end)

    def _joint(self, i: int, j: Joint) -> None:
        told = i < len(self.m.bodies) or self.rng.random() < 0.5
        pa, pb = self.m.world(j.a, j.at_a), self.m.world(j.b, j.at_b)
        d = pb[0] - pa[0], pb[1] - pa[1]
        angle = self.m.place(j.a)[2]
        if j.kind == "rod":
            self.declarations.append(
                f"PlanarMultiBody.Joints.JointRR joint{i}(L={math.hypot(*d)!r});"
            )
        elif j.kind == "revolute":
            phi = self.m.place(j.b)[2] - angle
            w = self.speeds[j.b][2] - self.speeds[j.a][2]
            starts = f"(phi(start={phi!r}), w(start={w!r}))" if told else ""
            self.declarations.append(f"PlanarMultiBody.Joints.Revolute joint{i}{starts};")
        else:
            e = turned(j.axis, angle)
            s = e[0] * d[0] + e[1] * d[1]
            va, vb = self._velocity(j.a, j.at_a), self._velocity(j.b, j.at_b)
            turning = self.speeds[j.a][2]
            relative = vb[0] - va[0] + turning * d[1], vb[1] - va[1] - turning * d[0]
            v = e[0] * relative[0] + e[1] * relative[1]
            starts = f", s(start={s!r}), v(start={v!r})" if told else ""
            self.declarations.append(
                f"PlanarMultiBody.Joints.Prismatic joint{i}"
                f"(n={{{j.axis[0]!r}, {j.axis[1]!r}}}{starts});"
            )
        self._arm(f"armA{i}", j.a, j.at_a, 0.0, f"joint{i}.frame_a")
        self._arm(f"armB{i}", j.b, j.at_b, j.turn, f"joint{i}.frame_b")

    def _velocity(self, body: int, at: Point) -> Point:
        vx, vy, w = self.speeds[body]
        u = turned(at, self.m.place(body)[2])
        return vx - w * u[1], vy + w * u[0]

    def _load(self, i: int, load: Load) -> None:
        name, n = f"load{i}", load.numbers
        if load.kind == "spring":
            text = f"Spring {name}(c={n[0]!r}, s_unstretched={n[1]!r})"
        elif load.kind == "damper":
            text = f"Damper {name}(d={n[0]!r})"
        elif load.kind == "push":
            text = f"WorldForce {name}"
            wave = f"sin({n[2]!r}*time + ({n[3]!r}))"
            self.equations.append(f"{name}.force = {{{n[0]!r}*{wave}, {n[1]!r}}};")
        else:
            text = f"Torque {name}"
            self.equations.append(f"{name}.torque = {n[0]!r}*cos({n[1]!r}*time);")
        self.declarations.append(f"PlanarMultiBody.Forces.{text};")
        if load.kind != "push":
            self._arm(f"fromLoad{i}", load.a, load.at_a, 0.0, f"{name}.frame_a")
        self._arm(f"toLoad{i}", load.b, load.at_b, 0.0, f"{name}.frame_b")


# Smaller --------------------------------------------------------------------------------------


def shrink(m: Mechanism, fails: Callable[[Mechanism], bool]) -> Mechanism:
    """The smallest mechanism found that still fails: loads, loops and bodies are taken away,
    numbers made plain."""
    better = True
    while better:
        better = False
        for smaller in _smaller(m):
            if fails(smaller):
                m, better = smaller, True
                break
    return m


def _smaller(m: Mechanism) -> Iterator[Mechanism]:
    count = len(m.bodies)
    for i in range(len(m.loads)):
        yield replace(m, loads=m.loads[:i] + m.loads[i + 1 :])
    for i in range(count, len(m.joints)):
        yield replace(m, joints=m.joints[:i] + m.joints[i + 1 :])
    last = count - 1
    carried = [j for i, j in enumerate(m.joints) if i != last and last in (j.a, j.b)]
    if count > 1 and not carried and not any(last in (f.a, f.b) for f in m.loads):
        yield replace(
            m,
            bodies=m.bodies[:-1],
            joints=m.joints[:last] + m.joints[last + 1 :],
            drift=m.drift[:-3],
        )
    if any(m.drift):
        yield replace(m, drift=(0.0,) * len(m.drift))
    if any(m.gravity):
        yield replace(m, gravity=(0.0, -9.81)) if m.gravity != (0.0, -9.81) else m
    for i, body in enumerate(m.bodies):
        if body.centre != (0.0, 0.0):
            plain = replace(body, centre=(0.0, 0.0), mass=1.0, inertia=0.1)
            yield replace(m, bodies=(*m.bodies[:i], plain, *m.bodies[i + 1 :]))
