"""Slides whose direction does not let their loop close: what a user may have copied, or mistaken.

In:   Program, Kernel at a point where the loop does not close; components of the loop
Out:  what to look at, as a part of a hint; empty where directions do. Directions to try

Example: the slot of a Scotch yoke with the `n` of the yoke's guide. Both carry it along one line,
so that nothing lets the crank pin go across.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from math import cos, hypot, sin

from planarc.core.prose import listed
from planarc.ir.kernel import Kernel
from planarc.ir.mechanism import GROUND, Joint
from planarc.ir.places import own_names
from planarc.ir.program import Program
from planarc.solve.messages.loops import loop_joints

Vector2 = tuple[float, float]

#: The sine of the angle within which two directions are one.
_PARALLEL = 1e-6
#: Pins by which a loop of slides turns a crank: with more of them, parallel slides may be right.
_PINS = 2


def one_way(program: Program, kernel: Kernel, components: Collection[str]) -> str:
    """A sentence about the slides of a loop that all slide along one line, with so few pins that
    nothing moves across it."""
    joints = _loop(program, components)
    slides = _directions(program, kernel, joints)
    pins = _pins(joints, slides)
    if len(slides) < 2 or len(pins) > _PINS or len(slides) + len(pins) < len(joints):
        return ""
    first, *others = slides.values()
    if any(abs(_cross(first, other)) > _PARALLEL for other in others):
        return ""
    names = list(slides)
    n = entries(*_square(program, kernel, names[0]).values())
    return (
        f"{listed(f'`{name}`' for name in names)} slide along the same line: give one of them "
        f"another direction, such as `{names[0]}(n={n})`"
    )


def beside_wheel(program: Program, kernel: Kernel, components: Collection[str]) -> str:
    """A sentence about the level slide of a loop that misses the centre of a wheel, which rolls on
    the line y = 0."""
    joints = _loop(program, components)
    classes = {p.name: p.class_name for p in program.parts}
    radii = {p.name: float(kernel.w[p.slot]) for p in program.parameter_slots}
    wheels = [j.name for j in joints if classes.get(j.name, "").endswith(".RollingJoint")]
    level = [n for n, d in _directions(program, kernel, joints).items() if abs(d[1]) < _PARALLEL]
    if not wheels or not level or f"{wheels[0]}.R" not in radii:
        return ""
    wheel, slide = own_names(program, [wheels[0], level[0]])
    return (
        f"`{wheel}` rolls on y = 0, so that its centre is at y = {radii[f'{wheels[0]}.R']:.4g} m, "
        f"which `{slide}` passes by: put `{slide}` at that height, or leave it out, as the wheel "
        "holds the height alone"
    )


def square_on(
    program: Program, kernel: Kernel, components: Collection[str]
) -> Iterator[tuple[str, dict[int, float]]]:
    """The slides of a loop, each with the slots of its `n` and the values that turn it by a right
    angle. None of a loop whose pins turn bars, since these reach a slide of any direction or are
    too short."""
    joints = _loop(program, components)
    slides = _directions(program, kernel, joints)
    if len(_pins(joints, slides)) <= _PINS:
        yield from ((slide, _square(program, kernel, slide)) for slide in slides)


def goes_round(
    program: Program, kernel: Kernel, components: Collection[str], lengths: Mapping[str, float]
) -> tuple[str, str]:
    """What lets the crank go round that with a rod of some `lengths` moves a slide, and cannot as
    it is: the part to change, and what to do. A slide that is beside the crank rather than before
    it is turned by a right angle, if that is enough; else the rod is too short."""
    mechanism, joints = program.mechanism, _loop(program, components)
    slides = _directions(program, kernel, joints)
    bearings = [j for j in joints if GROUND in j.links and j.name not in slides]
    if mechanism is None or len(joints) != 4 or len(slides) != 1 or len(bearings) != 1:
        return "", ""
    ((slide, d),) = slides.items()
    at = {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}
    turning = {f.rpartition(".")[0] for f in mechanism.links[max(bearings[0].links)].frames}
    cranks = [bar for bar in lengths if bar in turning]
    frames = (f"{slide}.frame_a", f"{slide}.frame_b", f"{bearings[0].name}.frame_a")
    ends = [f"{frame}.r[{i}]" for frame in frames for i in (1, 2)]
    if len(lengths) != 2 or len(cranks) != 1 or not at.keys() >= {*ends}:
        return "", ""
    x, y, x_end, y_end, u, v = (at[end] for end in ends)
    ((rod, length),) = ((bar, length) for bar, length in lengths.items() if bar != cranks[0])
    across = (-d[1], d[0])
    aside = [abs(_cross((u - x, v - y), e)) for e in (d, across)]
    needs = [lengths[cranks[0]] + distance for distance in aside]
    if length > needs[0]:
        return "", ""
    before = abs(_cross((x_end - u, y_end - v), across))
    if needs[1] < length and aside[0] > before:
        n = entries(*_square(program, kernel, slide).values())
        return slide, f"turn `{slide}`: with `n={n}`, `{cranks[0]}` can go round"
    beside = f", as `{slide}` passes {aside[0]:.4g} m beside its axis" if aside[0] else ""
    return rod, (
        f"for `{cranks[0]}` to go round, `{rod}` must be longer than {needs[0]:.4g} m{beside}"
    )


def _square(program: Program, kernel: Kernel, slide: str) -> dict[int, float]:
    """The slots of a slide's `n`, and the values that turn it by a right angle."""
    slots = {p.name: p.slot for p in program.parameter_slots}
    x, y = slots[f"{slide}.n[1]"], slots[f"{slide}.n[2]"]
    return {x: 0.0 - float(kernel.w[y]), y: float(kernel.w[x])}


def _loop(program: Program, components: Collection[str]) -> list[Joint]:
    return list({j.name: j for j in loop_joints(program, components)}.values())


def _pins(joints: Collection[Joint], slides: Collection[str]) -> list[Joint]:
    return [j for j in joints if j.name not in slides and j.conditions > 1]


def _directions(program: Program, kernel: Kernel, joints: Collection[Joint]) -> dict[str, Vector2]:
    """The directions of slides in the world, by the names of these."""
    n = {p.name: float(kernel.w[p.slot]) for p in program.parameter_slots}
    at = {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}
    found: dict[str, Vector2] = {}
    for joint in (j.name for j in joints):
        x, y, phi = (n.get(f"{joint}.n[1]"), n.get(f"{joint}.n[2]"), at.get(f"{joint}.frame_a.phi"))
        if x is None or y is None or phi is None or f"{joint}.s" not in at or not hypot(x, y):
            continue
        c, s = cos(phi) / hypot(x, y), sin(phi) / hypot(x, y)
        found[joint] = (c * x - s * y, s * x + c * y)
    return found


def _cross(a: Vector2, b: Vector2) -> float:
    return a[0] * b[1] - a[1] * b[0]


def entries(*v: float) -> str:
    """A vector as it is written in a model."""
    x, y = (0.0 if abs(e) < _PARALLEL else e for e in v)
    return f"{{{x:.3g}, {y:.3g}}}"
