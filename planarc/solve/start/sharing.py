"""What is said of forces that redundant joints leave open, and whether these joints still fit.

In:   Program with `sharing`, Kernel at the start of a run; its rows at the end
Out:  a note that names the joints; an error where the motion depends on how they share, or where
      a condition that was left out does not hold

The sum of squares that the forces make smallest has a bias (`structure.sharing`). With another
one the open forces are others, as far as the equations leave them open, and all else must be as
it was: positions and velocities do not know of it, accelerations must not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity
from planarc.core.prose import be
from planarc.ir.dae import MISFIT, SHARING
from planarc.ir.kernel import Kernel
from planarc.ir.places import point_home
from planarc.ir.program import Condition, Program
from planarc.solve.measure import length_of, sizes_of_slots

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.solve.start.system import System

#: Accelerations that change by more than this part of what the forces change, depend on them.
DEPENDS = 1e-6
#: A condition that was left out holds when it is off by less, in the measure of the mechanism.
FITS = 1e-6


def strict(program: Program) -> Program:
    """The program held at the start to what was left out since it follows from the rest."""
    if program.sharing is None:
        return program
    held = [c.held for c in program.sharing.conditions if c.held is not None]
    return replace(program, fixed=(*program.fixed, *(replace(f, fixed=True) for f in held)))


def left_out_rows(system: System) -> list[int]:
    """The rows of a strict program that hold it to what was left out, in their order."""
    conditions = enumerate(system.conditions, system.fixed_rows.start)
    return [row for row, f in conditions if f.display.startswith(MISFIT)]


def missed(system: System, values: Vector) -> bool:
    """Whether an assembled position misses what was left out: a loop was closed on another side.
    A strict program misses nothing."""
    if system.program.sharing is None or left_out_rows(system):
        return False
    system.evaluate_flag(values)
    return misses(system.program, system.kernel)


def misses(program: Program, kernel: Kernel) -> bool:
    """Whether the position that the workspace holds misses what was left out."""
    conditions = program.sharing.conditions if program.sharing is not None else ()
    held = [c.held.slot for c in conditions if c.held is not None]
    sizes = sizes_of_slots(program, length_of(program, kernel), held)
    return any(abs(kernel.w[slot]) > FITS * size for slot, size in zip(held, sizes, strict=True))


def judge_sharing(program: Program, kernel: Kernel, t: float, y: Sequence[float]) -> Diagnostic:
    """A note. The workspace holds the point (t, y) and does so afterwards. Raises R417, R418."""
    import numpy as np

    before = [float(v) for v in kernel.w]
    wrong = misfit(program, kernel, np.array([t]), lambda slot: np.array([before[slot]]))
    if wrong is not None:
        raise PlanarcError(wrong)
    kernel.w[program.slots[SHARING]] = 1.0
    kernel.parameters()
    kernel.accept(t)
    solved = kernel.outputs(t, y) == 0
    after = [float(v) for v in kernel.w]
    for slot, value in enumerate(before):
        kernel.w[slot] = value
    kernel.accept(t)
    change = [abs(b - a) if solved else 0.0 for a, b in zip(before, after, strict=True)]
    moved = _moved(program, change)
    largest = max((size for _, size in moved), default=0.0)
    moving = max((change[c.derivative] for c in program.candidates), default=0.0)
    sharing = [name for name, size in moved if size > DEPENDS * largest]
    if moving > DEPENDS * max(largest, 1.0):
        raise _depends(program, sharing)
    return _shared(program, sharing)


def _moved(program: Program, change: Sequence[float]) -> list[tuple[str, float]]:
    """The most that a cut force or torque of each joint (or of each component with frames, where
    all of them share) has changed."""
    assert program.sharing is not None and program.mechanism is not None
    mechanism = program.mechanism
    frames: dict[str, list[str]] = {joint.name: list(joint.frames) for joint in mechanism.joints}
    if program.sharing.everywhere:
        frames = {}
        for frame in (f for link in mechanism.links for f in link.frames):
            frames.setdefault(frame.rpartition(".")[0], []).append(frame)
    slots = {c.name: c.slot for c in program.columns}
    return [
        (name, max(change[slots[f"{f}.{v}"]] for f in own for v in ("f[1]", "f[2]", "t")))
        for name, own in frames.items()
        if own
    ]


def _shared(program: Program, names: Sequence[str]) -> Diagnostic:
    from planarc.solve.messages import trouble

    assert program.sharing is not None
    count = program.sharing.open
    return Diagnostic(
        "R416",
        f"{trouble.names(names)} hold motions more than once: {count} of their forces and torques "
        f"{be(count)} not determined, and those of the smallest sum of squares "
        "are given; the motion does not depend on them",
        severity=Severity.NOTE,
    )


def _depends(program: Program, names: Sequence[str]) -> PlanarcError:
    from planarc.solve.messages import trouble

    found = Diagnostic(
        "R418",
        f"{trouble.names(names)} hold motions more than once, and the motion depends on how they "
        "share their forces, as with friction",
        hint="replace one of these joints by a freer one",
    )
    return PlanarcError(point_home(program, found, names[-1] if names else ""))


def misfit(
    program: Program, kernel: Kernel, times: Vector, values: Callable[[int], Vector]
) -> Diagnostic | None:
    """The first condition that was left out and does not hold; `values` gives those
    of a slot over the times."""
    import numpy as np

    slots = {c.name: c.slot for c in program.columns}
    conditions = program.sharing.conditions if program.sharing is not None else ()
    places = [slots[condition.name] for condition in conditions]
    sizes = sizes_of_slots(program, length_of(program, kernel), places)
    for condition, slot, size in zip(conditions, places, sizes, strict=True):
        off = values(slot)
        wrong = np.flatnonzero(~(np.abs(off) <= FITS * size))
        if len(wrong):
            first = int(wrong[0])
            by = f"{float(off[first]):.2g}"
            return does_not_hold(program, condition, float(times[first]), by)
    return None


def does_not_hold(program: Program, condition: Condition, t: float, off: str) -> Diagnostic:
    """`off` is a number as it is told."""
    info = condition.info
    found = Diagnostic(
        "R417",
        f"at t = {t:.6g} s `{info.component or 'the model'}` does not fit: `{info.text}`, which "
        f"was left out because it followed from other conditions, is off by {off}",
        info.span,
        hint="joints repeat each other in some positions only: replace one of them by a freer one",
    )
    return point_home(program, found, info.component)
