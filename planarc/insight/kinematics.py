"""Motion of a mechanism: paths of points, forces at joints, velocities, instant centres.

In:   Mechanism, Result
Out:  Layers, to be laid over the moving picture

A link's motion is that of a frame: velocities that the result holds are exact, others are taken
by differences. Of a point P of a link with origin O (r, v, a known), with d = P - O and
n = {-d[2], d[1]}:

    v_P = v_O + w*n            a_P = a_O + z*n - w^2*d
    instant centre  O + {-v_O[2], v_O[1]}/w, where the link has no velocity

Components declare further points, such as centres of mass, and where the force of a joint acts:
`annotation(__planarc(point(centre = r_0CM), contact = frame_b.r + r2))`. Contacts, which
hold no links together, declare their forces: `force(normal(at = frame_a.r + r) = f_n*n)`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from planarc.core.data import Data
from planarc.insight.values import Values
from planarc.ir.insight import Layer, Mark, Track
from planarc.ir.mechanism import GROUND, Joint, Link, Mechanism
from planarc.ir.result import Result

#: The slowest turn (rad/s) that has a centre: slower links move straight on.
_SLOW = 1e-6
#: What is no vector: in SI units, and as a share of the largest of its layer.
_ROUND_OFF, _NEGLIGIBLE = 1e-13, 1e-10


class _Motion(Data):
    """Motion of a link: origin, velocity, acceleration, angular velocity and acceleration."""

    x: Track
    y: Track
    u: Track
    v: Track
    du: Track
    dv: Track
    w: Track
    z: Track


def find_layers(
    result: Result, mechanism: Mechanism | None, values: Values | None = None
) -> tuple[Layer, ...]:
    """The layers of a run that hold something."""
    if mechanism is None or not len(result.time):
        return ()
    values = values or Values(result)
    motions = {i: _motion(values, link) for i, link in enumerate(mechanism.links) if i != GROUND}
    points = [*_joint_points(values, mechanism, motions), *_declared_points(values)]
    moving = [p for p in points if not (isinstance(p.x, float) and isinstance(p.y, float))]
    found = (
        Layer("paths", "Paths", "paths", "m", tuple(Mark(p.name, p.x, p.y) for p in moving)),
        Layer("forces", "Joint forces", "vectors", "N", _told(_forces(values, mechanism))),
        Layer("contacts", "Contact forces", "vectors", "N", _told(_contact_forces(values))),
        Layer("velocities", "Velocities", "vectors", "m/s", _vectors(points, 0)),
        Layer("accelerations", "Accelerations", "vectors", "m/s2", _vectors(points, 1)),
        Layer("masses", "Masses by size", "masses", "kg", tuple(_masses(values))),
        Layer("centres", "Instant centres", "centres", "m", _instant_centres(mechanism, motions)),
    )
    return tuple(layer for layer in found if layer.members)


class _Point(Data):
    name: str
    x: Track
    y: Track
    vectors: tuple[tuple[Track, Track], tuple[Track, Track]] | None  # velocity, acceleration


def _motion(values: Values, link: Link) -> _Motion | None:
    """The motion of the frame with the most exact velocities; None without a position."""
    named = [tuple(f"{frame}.{n}" for n in ("r[1]", "r[2]", "phi")) for frame in link.frames]
    known = [names for names in named if all(name in values.result for name in names)]
    if not known:
        return None
    own = max(known, key=lambda names: sum(map(values.exactness, names)))
    x, y, _ = (values.get(name) for name in own)
    u, v, w = (values.rate(name) for name in own)
    du, dv, z = (values.rate(name, 2) for name in own)
    return _Motion(x, y, u, v, du, dv, w, z)


def _joint_points(
    values: Values, mechanism: Mechanism, motions: dict[int, _Motion | None]
) -> Iterator[_Point]:
    """The places of joints; both ends of one whose frames do not coincide."""
    link_of = {f: i for i, link in enumerate(mechanism.links) for f in link.frames}
    seen: set[tuple[int, ...]] = set()
    for joint in mechanism.joints:
        places = [f for f in joint.frames if values.has(f, "r[1]", "r[2]")]
        for frame in sorted(places, key=lambda f: -link_of.get(f, GROUND)):
            key = _place(values, frame)
            link = link_of.get(frame, GROUND)
            if key in seen or link == GROUND:
                continue
            seen.add(key)
            x, y = values.pair(frame, "r")
            motion = motions[link]
            vectors = None if motion is None else _carried(motion, x, y)
            several = len({_place(values, f) for f in places}) > 1
            yield _Point(frame if several else joint.name, x, y, vectors)


def _place(values: Values, frame: str) -> tuple[int, ...]:
    """A key that is equal for frames whose positions are the same variables."""
    columns = values.result.columns
    own = (columns[f"{frame}.r[1]"], columns[f"{frame}.r[2]"])
    return tuple(number for c in own for number in (c.slot, c.sign))


def _carried(o: _Motion, x: Track, y: Track) -> tuple[tuple[Track, Track], tuple[Track, Track]]:
    dx, dy = x - o.x, y - o.y
    velocity = o.u - o.w * dy, o.v + o.w * dx
    square = o.w * o.w
    return velocity, (o.du - o.z * dy - square * dx, o.dv + o.z * dx - square * dy)


def _declared_points(values: Values) -> Iterator[_Point]:
    """The points that components declare, such as centres of mass."""
    points = values.declared("point")
    velocities, accelerations = (values.declared("point", order) for order in (1, 2))
    for component, own in points.items():
        for name, (x, y) in own.items():
            moved = velocities[component][name], accelerations[component][name]
            yield _Point(f"{component} {name}".strip(), x, y, moved)


def _masses(values: Values) -> Iterator[Mark]:
    """The masses of components that declare one point, at that point."""
    for component, own in values.declared("point").items():
        mass = f"{component}.m"
        if len(own) == 1 and values.result.columns.get(mass) is not None:
            m = values.get(mass)
            if np.max(m, initial=0.0) > 0:
                ((x, y),) = own.values()
                yield Mark(component, x, y, m)


def _vectors(points: list[_Point], which: int) -> tuple[Mark, ...]:
    return _told(
        Mark(p.name, p.x, p.y, *p.vectors[which])
        for p in points
        if p.vectors is not None and not _is_zero(p.vectors[which])
    )


def _told(marks: Iterable[Mark]) -> tuple[Mark, ...]:
    """The vectors that are more than round-off, of themselves and against the largest."""
    sized = [(m, float(np.fmax.reduce(np.hypot(m.u, m.v), axis=None, initial=0.0))) for m in marks]
    least = max(_ROUND_OFF, _NEGLIGIBLE * max((size for _, size in sized), default=0.0))
    return tuple(m for m, size in sized if size > least)


def _is_zero(vector: tuple[Track, Track]) -> bool:
    return not any(np.any(np.abs(v) > 0) for v in vector)  # what is not known is no more than 0


def _forces(values: Values, mechanism: Mechanism) -> Iterator[Mark]:
    """The force of a joint on the link at its last moving frame: less the cut force there."""
    link_of = {f: i for i, link in enumerate(mechanism.links) for f in link.frames}
    contacts = values.declared("contact")
    for joint in mechanism.joints:
        frame = _acted(joint, link_of)
        if frame is None or not values.has(frame, "r[1]", "f[1]", "f[2]"):
            continue
        x, y = contacts[joint.name][""] if joint.name in contacts else values.pair(frame, "r")
        u, v = values.pair(frame, "f")
        on = mechanism.links[link_of[frame]].name
        mark = Mark(f"{joint.name} on {on}", x, y, -u, -v)
        if not _is_zero((u, v)):
            yield mark


def _contact_forces(values: Values) -> Iterator[Mark]:
    """The forces that components declare where they act: `contact normal 2` of the second point."""
    for component, own in values.declared("force").items():
        for name, rows in own.items():
            if name.endswith(".at"):
                continue
            at, several = own[f"{name}.at"], isinstance(rows[0], tuple)
            pairs = list(zip(at, rows, strict=True)) if several else [(at, rows)]
            for number, ((x, y), (u, v)) in enumerate(pairs, 1):
                told = f"{component} {name}" + f" {number}" * (len(pairs) > 1)
                if not _is_zero((u, v)):
                    yield Mark(told, x, y, u, v)


def _acted(joint: Joint, link_of: dict[str, int]) -> str | None:
    moving = [f for f in joint.frames if link_of.get(f, GROUND) != GROUND]
    return moving[-1] if moving else None


def _instant_centres(mechanism: Mechanism, motions: dict[int, _Motion | None]) -> tuple[Mark, ...]:
    """A centre for each link that turns; a hinge in the ground is one that nobody asks for."""
    found = []
    for i, motion in motions.items():
        if motion is None or mechanism.links[i].free < 3:
            continue
        with np.errstate(all="ignore"):
            w: Any = np.where(np.abs(motion.w) > _SLOW, motion.w, np.nan)
            x, y = motion.x - motion.v / w, motion.y + motion.u / w
        if np.all(np.isnan(x)):
            continue
        fixed = any(i in j.links and GROUND in j.links for j in mechanism.joints)
        found.append(Mark(mechanism.links[i].name, _track(x), _track(y), on=not fixed))
    return tuple(found)


def _track(values: Any) -> Track:
    return float(values) if getattr(values, "ndim", 0) == 0 else values
