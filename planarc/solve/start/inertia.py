"""Long bodies that turn with the inertia that the library gives where none is written.

In:   Program, a kernel that holds the start
Out:  a warning (R441) about the first one, or None

A part that has a length by its frames, a mass `m` and an inertia `I` is compared with a rod.

Example: `BodyShape(r={3.5, 0}, m=14)`, the boom of a barrier. A rod of it has 14.3 kg.m2, the
library's default is 0.001 kg.m2.
"""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.start.longest import lengths_of_parts

#: The inertia that bodies have where none is written, in kg.m2, and the multiple of it that a rod
#: of the same mass and length has before it is told.
DEFAULT, MULTIPLE = 0.001, 100.0


def judge_inertia(program: Program, kernel: Kernel) -> Diagnostic | None:
    """The warning about a body of much less inertia than a rod has."""
    w = kernel.w
    bodies = [(part, m) for part, i, m in _bodies(program) if w[i] == DEFAULT]
    if not bodies:
        return None
    lengths = lengths_of_parts(program, kernel)
    for part, m in bodies:
        length, mass = lengths.get(part, 0.0), float(w[m])
        rod = mass * length * length / 12
        own = own_part(program, part)
        if rod > MULTIPLE * DEFAULT and own is not None:
            return Diagnostic(
                "R441",
                f"`{part}` has the inertia of bodies where none is given, {DEFAULT:g} kg.m2: "
                f"a rod of {length:.3g} m and {mass:.3g} kg has {rod:.3g}",
                own.span,
                Severity.WARNING,
                hint=f"write `{part}(I=...)`, about its centre of mass; `I=0` is that of a point",
            )
    return None


@once
def _bodies(program: Program) -> tuple[tuple[str, int, int], ...]:
    """The parts that turn and have that inertia by default, with the slots of inertia and mass."""
    if not program.state_count:  # a truss
        return ()
    slots = {p.name: p.slot for p in program.parameter_slots}
    turning = {c.name for c in program.columns if not c.constant}
    found = []
    for p in program.parameter_slots:
        part, _, name = p.name.rpartition(".")
        usual = name == "I" and p.default == DEFAULT and f"{part}.m" in slots
        if usual and f"{part}.frame_b.phi" in turning:
            found.append((part, p.slot, slots[f"{part}.m"]))
    return tuple(found)
