"""How a mechanism moves: paths of points, forces at joints, velocities, instant centres.

In:   Mechanism, Result
Out:  Layers, to be laid over the moving picture

A link's motion is that of a body on it, whose velocities the result knows exactly, or else by
differences of its frame. Of a point P of a link with origin O (r, v, a known), d = P - O and
n = {-d[2], d[1]}:

    v_P = v_O + w*n            a_P = a_O + z*n - w^2*d
    instant centre  O + {-v_O[2], v_O[1]}/w, where the link has no velocity
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from planarc.core.data import Data
from planarc.insight.values import Values, rate
from planarc.ir.insight import Layer, Mark
from planarc.ir.mechanism import GROUND

if TYPE_CHECKING:
    from planarc.ir.insight import Track
    from planarc.ir.mechanism import Joint, Link, Mechanism
    from planarc.ir.result import Result

#: A link that turns more slowly than this (rad/s) moves straight on: its centre is far away.
_SLOW = 1e-6


class _Motion(Data):
    """Of a link: origin, its velocity and acceleration, angular velocity and acceleration."""

    x: Track
    y: Track
    u: Track
    v: Track
    du: Track
    dv: Track
    w: Track
    z: Track


def find_layers(result: Result, mechanism: Mechanism | None) -> tuple[Layer, ...]:
    """Only layers that hold something."""
    if mechanism is None or not len(result.time):
        return ()
    values = Values(result)
    motions = {i: _motion(values, link) for i, link in enumerate(mechanism.links) if i != GROUND}
    points = [*_joint_points(values, mechanism, motions), *_centres_of_mass(values)]
    moving = [p for p in points if not (isinstance(p.x, float) and isinstance(p.y, float))]
    found = (
        Layer("paths", "Paths", "paths", "m", tuple(Mark(p.name, p.x, p.y) for p in moving)),
        Layer("forces", "Joint forces", "vectors", "N", tuple(_forces(values, mechanism))),
        Layer("velocities", "Velocities", "vectors", "m/s", _vectors(points, 0)),
        Layer("accelerations", "Accelerations", "vectors", "m/s2", _vectors(points, 1)),
        Layer("centres", "Instant centres", "centres", "m", _instant_centres(mechanism, motions)),
    )
    return tuple(layer for layer in found if layer.members)


class _Point(Data):
    name: str
    x: Track
    y: Track
    vectors: tuple[tuple[Track, Track], tuple[Track, Track]] | None  # velocity, acceleration


def _motion(values: Values, link: Link) -> _Motion | None:
    """None where the result does not hold the link's position."""
    for frame in link.frames:
        body = frame.rpartition(".")[0]
        if values.has(body, "r[1]", "v[1]", "a[1]", "w", "z") and frame.endswith(".frame_a"):
            (x, y), (u, v), (du, dv) = (values.pair(body, n) for n in ("r", "v", "a"))
            return _Motion(x, y, u, v, du, dv, values.get(f"{body}.w"), values.get(f"{body}.z"))
    frame = link.frames[0]
    if not values.has(frame, "r[1]", "r[2]", "phi"):
        return None
    own = [f"{frame}.{n}" for n in ("r[1]", "r[2]", "phi")]
    u, v, w = (values.rate(name) for name in own)
    du, dv, z = (_second(values, track) for track in (u, v, w))
    return _Motion(values.get(own[0]), values.get(own[1]), u, v, du, dv, w, z)


def _second(values: Values, track: Track) -> Track:
    return 0.0 if isinstance(track, float) else rate(values.time, track)


def _joint_points(
    values: Values, mechanism: Mechanism, motions: dict[int, _Motion | None]
) -> Iterator[_Point]:
    """Where joints sit; both ends of one whose frames do not coincide."""
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
    """Equal for frames whose positions are the same variables."""
    columns = values.result.columns
    own = (columns[f"{frame}.r[1]"], columns[f"{frame}.r[2]"])
    return tuple(number for c in own for number in (c.slot, c.sign))


def _carried(o: _Motion, x: Track, y: Track) -> tuple[tuple[Track, Track], tuple[Track, Track]]:
    dx, dy = x - o.x, y - o.y
    velocity = o.u - o.w * dy, o.v + o.w * dx
    square = o.w * o.w
    return velocity, (o.du - o.z * dy - square * dx, o.dv + o.z * dx - square * dy)


def _centres_of_mass(values: Values) -> Iterator[_Point]:
    for part in values.result.program.parts:
        for r, v, a in (("r_0CM", "v_CM", "a_CM"), ("r_mass", "v", "a")):
            if values.has(part.name, f"{r}[1]", f"{v}[1]", f"{a}[1]"):
                pairs = [values.pair(part.name, n) for n in (r, v, a)]
                yield _Point(f"{part.name} centre", *pairs[0], (pairs[1], pairs[2]))
                break
        else:
            own = ("m", "r[1]", "v[1]", "a[1]", "frame_a.phi")
            if values.has(part.name, *own) and not values.has(part.name, "I"):
                x, y = values.pair(part.name, "r")
                moved = values.pair(part.name, "v"), values.pair(part.name, "a")
                yield _Point(part.name, x, y, moved)


def _vectors(points: list[_Point], which: int) -> tuple[Mark, ...]:
    return tuple(
        Mark(p.name, p.x, p.y, *p.vectors[which])
        for p in points
        if p.vectors is not None and not _is_zero(p.vectors[which])
    )


def _is_zero(vector: tuple[Track, Track]) -> bool:
    import numpy as np

    return all(not np.any(np.nan_to_num(np.asarray(v))) for v in vector)


def _forces(values: Values, mechanism: Mechanism) -> Iterator[Mark]:
    """The force of a joint on the link at its last moving frame: less the cut force there."""
    link_of = {f: i for i, link in enumerate(mechanism.links) for f in link.frames}
    for joint in mechanism.joints:
        frame = _acted(joint, link_of)
        if frame is None or not values.has(frame, "r[1]", "f[1]", "f[2]"):
            continue
        (x, y), (u, v) = _touched(values, joint, frame), values.pair(frame, "f")
        on = mechanism.links[link_of[frame]].name
        mark = Mark(f"{joint.name} on {on}", x, y, -u, -v)
        if not _is_zero((u, v)):
            yield mark


def _touched(values: Values, joint: Joint, frame: str) -> tuple[Track, Track]:
    """Where the force acts: at the frame, or where two curves touch."""
    x, y = values.pair(frame, "r")
    if not values.has(joint.name, "r2[1]", "normal2[1]") or not frame.endswith(".frame_b"):
        return x, y
    dx, dy = values.pair(joint.name, "r2")
    return x + dx, y + dy


def _acted(joint: Joint, link_of: dict[str, int]) -> str | None:
    moving = [f for f in joint.frames if link_of.get(f, GROUND) != GROUND]
    return moving[-1] if moving else None


def _instant_centres(mechanism: Mechanism, motions: dict[int, _Motion | None]) -> tuple[Mark, ...]:
    """One for each link that turns; a hinge in the ground is a centre that nobody asks for."""
    import numpy as np

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
