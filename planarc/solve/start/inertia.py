"""Long bodies that turn with the inertia that the library gives where none is written.

In:   Program, a kernel that holds the start
Out:  a warning (R441) about the first one, or None

A part that has a length by its frames, a mass `m` and an inertia `I` is compared with a rod. So is
a body without length that is all the mass of what it is on, where this turns about the body's own
centre, by which nothing but its inertia counts.

Example: `BodyShape(r={3.5, 0}, m=14)`, the boom of a barrier. A rod of it has 14.3 kg.m2, the
library's default is 0.001 kg.m2. So has `Body(m=600)`, the chassis of a car between two rods of
1.2 m, where a rod has 288.
"""

from __future__ import annotations

from collections.abc import Mapping

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.places import own_part, owner
from planarc.ir.program import Column, Program
from planarc.solve.start.longest import Place, lengths_of_parts, spread

#: The inertia that bodies have where none is written, in kg.m2, and the multiple of it that a rod
#: of the same mass and length has before it is told.
DEFAULT, MULTIPLE = 0.001, 100.0
#: A length below this one, in m, is rounding.
_CLOSE = 1e-9


class _Body(Data):
    """A part with the slots of its inertia and mass; and where its centre is, the joints of what it
    is on, and the frames of that, where it is all the mass there, and has no length of its own."""

    part: str
    inertia: int
    mass: int
    centre: Place
    joints: tuple[Place, ...]
    around: tuple[Place, ...]


def judge_inertia(program: Program, kernel: Kernel) -> Diagnostic | None:
    """The warning about a body of much less inertia than a rod has."""
    w = kernel.w
    lengths: Mapping[str, float] | None = None
    for body in _bodies(program):
        if w[body.inertia] != DEFAULT:
            continue
        lengths = lengths or lengths_of_parts(program, kernel)
        length, mass = lengths.get(body.part, 0.0), float(w[body.mass])
        if body.joints and spread(kernel, (body.centre, *body.joints)) < _CLOSE:
            length = spread(kernel, body.around)
        rod = mass * length * length / 12
        own = own_part(program, body.part)
        if rod > MULTIPLE * DEFAULT and own is not None:
            return Diagnostic(
                "R441",
                f"`{body.part}` has the inertia of bodies where none is given, {DEFAULT:g} kg.m2: "
                f"a rod of {length:.3g} m and {mass:.3g} kg has {rod:.3g}",
                own.span,
                Severity.WARNING,
                hint=f"write `{body.part}(I=...)`, about its centre of mass; `I=0` is that of a "
                "point",
            )
    return None


@once
def _bodies(program: Program) -> tuple[_Body, ...]:
    """The parts that turn and have that inertia by default."""
    if not program.state_count or program.mechanism is None:  # a truss
        return ()
    slots = {p.name: p.slot for p in program.parameter_slots}
    usual = [p for p in program.parameter_slots if p.name.endswith(".I") and p.default == DEFAULT]
    columns = {c.name: c for c in program.columns} if usual else {}
    link_of = {f: link for link in program.mechanism.links for f in link.frames}
    ends = {f for joint in program.mechanism.joints for f in joint.frames}
    found = []
    for p in usual:
        part = p.name.rpartition(".")[0]
        end = next((f for f in ("frame_b", "frame_a") if f"{part}.{f}.phi" in columns), None)
        turns = end is not None and not columns[f"{part}.{end}.phi"].constant
        if not turns or f"{part}.m" not in slots:
            continue
        frames = link_of[f"{part}.{end}"].frames if f"{part}.{end}" in link_of else ()
        alone = not any(owner(f) != part and f"{owner(f)}.m" in slots for f in frames)
        centre = _place(columns, f"{part}.r_0CM")
        around = [_place(columns, f"{f}.r") for f in frames]
        joints = [place for f, place in zip(frames, around, strict=True) if f in ends]
        known = alone and end == "frame_a" and centre and all(around)
        kept = (centre, tuple(joints), tuple(around)) if known else ((), (), ())
        found.append(_Body(part, p.slot, slots[f"{part}.m"], *kept))
    return tuple(found)


def _place(columns: Mapping[str, Column], vector: str) -> Place:
    """The slots of a vector in the plane; () where there are none."""
    named = [columns.get(f"{vector}[{i}]") for i in (1, 2)]
    return tuple((c.slot, c.sign) for c in named if c is not None)
