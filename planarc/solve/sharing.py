"""What is said of forces that redundant joints leave open, and whether these joints still fit.

In:   Program with `sharing`, Kernel at the start of a run; its rows at the end
Out:  a note that names the joints; an error where the motion depends on how they share, or where
      a condition that was left out does not hold

The sum of squares that the forces make smallest has a bias (`structure.sharing`). With another
one the open forces are others, as far as the equations leave them open, and all else must be as
it was: positions and velocities do not know of it, accelerations must not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, Severity
from planarc.ir.dae import SHARING
from planarc.ir.program import Kernel, Program
from planarc.solve import trouble

if TYPE_CHECKING:
    from planarc.solve.newton import Vector

#: Accelerations that change by more than this part of what the forces change, depend on them.
DEPENDS = 1e-6
#: A condition that was left out holds when it is off by less (metres, radians).
FITS = 1e-6
#: Rows of the result at which that is looked at.
_ROWS = 200


def judge_sharing(program: Program, kernel: Kernel, t: float, y: Sequence[float]) -> Diagnostic:
    """A note. The workspace holds the point (t, y) and does so afterwards. Raises R418."""
    before = [float(v) for v in kernel.w]
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
    names = trouble.names([name for name, size in moved if size > DEPENDS * largest])
    if moving > DEPENDS * max(largest, 1.0):
        raise _depends(names)
    return _shared(program, names)


def _moved(program: Program, change: Sequence[float]) -> list[tuple[str, float]]:
    """Of each joint (or of each component with frames, where all of them share) the most that
    one of its cut forces and torques has changed."""
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


def _shared(program: Program, names: str) -> Diagnostic:
    assert program.sharing is not None
    count = program.sharing.open
    return Diagnostic(
        "R416",
        f"{names} hold motions more than once: {count} of their forces and torques "
        f"{'is' if count == 1 else 'are'} not determined, and those of the smallest sum of squares "
        "are given; the motion does not depend on them",
        severity=Severity.NOTE,
    )


def _depends(names: str) -> PlanarcError:
    return PlanarcError(
        Diagnostic(
            "R418",
            f"{names} hold motions more than once, and the motion depends on how they share their "
            "forces, as with friction",
            hint="replace one of these joints by a freer one",
        )
    )


def misfit(program: Program, kernel: Kernel, times: Vector, rows: Vector) -> Diagnostic | None:
    """Of the conditions that were left out, the first that does not hold; `rows` are the values
    of the candidates. The workspace is changed."""
    count = program.sharing.conditions if program.sharing is not None else 0
    if not count or not len(times):
        return None
    below = sum(len(b.residuals) for b in program.blocks if b.height > 0)
    size = below + len(program.initial_residuals)
    values = [0.0] * size
    step = max(1, len(times) // _ROWS)
    for i in range(0, len(times), step):
        kernel.residuals(float(times[i]), rows[i].tolist(), values)
        for k in range(size - count, size):
            if abs(values[k]) > FITS:
                return _does_not_hold(program, float(times[i]), k - below, values[k])
    return None


def _does_not_hold(program: Program, t: float, number: int, off: float) -> Diagnostic:
    info = program.initial_equations[number]
    return Diagnostic(
        "R417",
        f"at t = {t:.6g} s joints that were taken to be redundant do not fit: `{info.text}` is "
        f"off by {off:.2g}",
        info.span,
        hint="they repeat each other near the start only: replace one of them by a freer one",
        related=(Related(f"in `{info.component}`", info.span),) if info.component else (),
    )
