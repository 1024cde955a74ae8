"""The way to a start from the simplified equations to the actual ones.

In:   Program, Kernel (opened, at the start), and a run of the program whose `homotopy(a, s)`
      is (1 - way)*s + way*a, opened with the same values
Out:  the candidates' values where way = 1, and there the workspace; None where no way leads there

The simplified equations are solved as any start. Then `way` grows, in steps at which unknowns
change little, so that of several roots the one is found that hangs together with theirs. Where
the way turns back (a fold), it goes on from another root at the same place.

Example: an operational amplifier with positive feedback rests at either limit or, unstable,
between. With its upper limit as the simplified output it starts there.

Reference: Modelica Language Specification 3.6, section 3.7.4.3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError
from planarc.ir.dae import HOMOTOPY
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program, RelationSlot
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.settings import Request

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: The first step, and those that are so short that what changes in them, jumps.
FIRST, SHORTEST = 0.1, 1e-4
#: Distance of an unknown from a straight way, as a part of the largest value it had, and the least
#: value that counts.
MOST, LEAST = 0.1, 1e-6


class Leading(Protocol):
    """A run that starts again and again."""

    program: Program
    kernel: Kernel
    request: Request
    rescue: Rescue

    def settle(self, t: float, guess: Vector | None = None) -> object:
        """Start values near the guess, and the relations there. Raises PlanarcError."""


def request_of(leading: Program, program: Program, kernel: Kernel, request: Request) -> Request:
    """The request of the leading run: the same start, parameters and start values."""
    w = kernel.w
    known = {p.name: p.slot for p in program.parameter_slots}
    names = {slot: name for name, slot in program.slots.items() if slot in request.starts}
    values = {p.slot: w[known[p.name]] for p in leading.parameter_slots if p.name in known}
    starts = {leading.slots[n]: w[s] for s, n in names.items() if n in leading.slots}
    return replace(request, values=values, starts=starts)


def lead(program: Program, kernel: Kernel, run: Leading, t: float) -> Vector | None:
    """Leave the kernel at the root that the leading run comes to, and give the candidates there."""
    import numpy as np

    for name in program.inputs:
        run.kernel.w[run.program.slots[name]] = kernel.w[program.slots[name]]
    with np.errstate(all="ignore"):
        if not _Way(run, t).goes():
            return None
    _hand_over(run.program, run.kernel, program, kernel)
    kernel.accept(t)
    return np.array([kernel.w[c.slot] for c in program.candidates])


class _Way:
    """The way from 0 to 1."""

    def __init__(self, run: Leading, t: float) -> None:
        import numpy as np

        self._run, self._t = run, t
        program = run.program
        self._slot = program.slots[HOMOTOPY]
        tops = [text for b in program.blocks if not b.height for text in map(repr, b.tears)]
        candidates = [c.slot for c in program.candidates]
        self._slots = [*candidates, *(program.slots[name] for name in tops)]
        self._count = len(candidates)
        self._largest = np.full(len(self._slots), LEAST)

    def goes(self) -> bool:
        """Whether it leads to 1."""
        if not self._solved(0.0, None):
            return False
        here, way, step = self._values(), 0.0, FIRST
        rise = 0.0 * here  # of the unknowns on the way
        while way < 1.0:
            kept = list(self._run.kernel.w)
            jump = step < SHORTEST
            self._run.rescue.resting = not jump
            part = min(1.0, way + step)
            expected = here if jump else here + (part - way) * rise
            off = self._off(expected) if self._solved(part, expected) else None
            if off is not None and (off <= MOST or jump):
                now = self._values()
                rise = 0.0 * here if jump else (now - here) / (part - way)
                here, way = now, part
                step *= 2.0 if off <= MOST / 4 or jump else 1.0
            elif jump:
                return False
            else:
                self._run.kernel.w[:] = kept
                step /= 4.0
        return True

    def _solved(self, way: float, near: Vector | None) -> bool:
        kernel = self._run.kernel
        kernel.w[self._slot] = way
        kernel.parameters()
        for slot, value in self._run.request.starts.items():
            kernel.w[slot] = value
        if near is not None:
            for slot, value in zip(self._slots, near.tolist(), strict=True):
                kernel.w[slot] = value
            kernel.accept(self._t)
        try:
            self._run.settle(self._t, None if near is None else near[: self._count])
        except PlanarcError:
            return False
        return True

    def _values(self) -> Vector:
        import numpy as np

        values = np.array([self._run.kernel.w[s] for s in self._slots])
        self._largest = np.maximum(self._largest, abs(values))
        return values

    def _off(self, expected: Vector) -> float:
        """How far an unknown is from where it was expected, beside the largest value it had."""
        import numpy as np

        now = np.array([self._run.kernel.w[s] for s in self._slots])
        return float((abs(now - expected) / np.maximum(self._largest, abs(now))).max(initial=0.0))


def _hand_over(leading: Program, origin: Kernel, program: Program, kernel: Kernel) -> None:
    """Values of variables, and truths of the relations that both have."""
    for name, slot in program.slots.items():
        if name in leading.slots and not name.startswith(("$", "event[", "start(")):
            kernel.w[slot] = origin.w[leading.slots[name]]
    truths = {_known(r): origin.w[r.slot] for r in leading.relations}
    for relation in program.relations:
        kernel.w[relation.slot] = truths.get(_known(relation), kernel.w[relation.slot])


def _known(relation: RelationSlot) -> tuple[object, ...]:
    return relation.text, relation.span, relation.component
