"""The start in its ordinary case, by machine code; where it is none, `solve` goes its way.

In:   Program, a native kernel (parameters and start values set), the time
Out:  Plain    the start, and the choice of states there; the workspace is left at it
      None     where there is anything to decide, to search or to tell

Whatever is looked for is written into a plan, once for all runs that give the same start values.
Mechanisms with initial equations, or with joints that share what they hold, have none.
`codegen.native.begin` follows the plan, and gives the values that `solve` finds, to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain
from struct import pack, unpack
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.ir.begin import LARGEST, LEVEL, Plan
from planarc.ir.frame import place
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.solve.measure import length_of
from planarc.solve.start.system import asking_of, form_of, is_written, weight_of
from planarc.solve.states.selector import Determined, choosing, kinds_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Choices of given start values of which the plans are remembered.
MOST_PLANS = 64


class Plain(Data):
    """The values of the candidates; the use of each start value: what it was, what it became, and
    whether it is held."""

    values: tuple[float, ...]
    uses: Iterable[tuple[float, float, bool]]
    determined: Determined


def begin(program: Program, kernel: Kernel, t: float, given: frozenset[int]) -> Plain | None:
    form = kernel.capabilities.start
    if form is None or length_of(program, kernel) != 1.0:
        return None
    known = _plans(program)
    if given not in known:
        if len(known) > MOST_PLANS:
            known.clear()
        known[given] = _plan(program, given)
    if (plan := known[given]) is None:
        return None
    found = form.begin(t, plan, tuple(f.slot for f in form_of(program).fixed))
    if found is None:
        return None
    held, solved, scales, starts, values = found
    uses = zip(starts, values, map(bool, held), strict=True)
    return Plain(tuple(values), uses, Determined(solved, scales))


@once
def _plans(program: Program) -> dict[frozenset[int], NDArray[np.int64] | None]:
    """The plans that were asked for."""
    return {}


def _plan(program: Program, given: frozenset[int]) -> NDArray[np.int64] | None:
    import numpy as np

    form, candidates = form_of(program), program.candidates
    first, rows = form.initial_rows.stop, form.initial_rows.stop + len(form.fixed)
    if form.initial_rows or program.sharing is not None:
        return None
    if not rows <= len(candidates) <= LARGEST or not candidates:
        return None

    def written(start: CandidateSlot | FixedSlot) -> bool:
        return is_written(start, given)

    def weight(start: CandidateSlot | FixedSlot) -> int:
        number: int = unpack("q", pack("d", weight_of(start, written(start))))[0]
        return number

    numbers, kinds = {c.slot: i for i, c in enumerate(candidates)}, kinds_of(program)
    own = [
        (c.start, c.derivative, kind, numbers.get(c.derivative, -1), weight(c))
        for c, kind in zip(candidates, kinds, strict=True)
    ]
    asking = [item if isinstance(item, int) else -1 for item in asking_of(program, given)[0]]
    levels, heights = list[int](), sorted({b.height for _, b in form.blocks}, reverse=True)
    for height in heights:
        blocks = [k for k, (_, b) in enumerate(form.blocks) if b.height == height]
        fixed = [row for row, f in enumerate(form.fixed, first) if f.height == height]
        others = [f for f in program.fixed if f.height == height and not f.fixed]
        numbered = [*blocks, *fixed, *(n for f in others for n in (f.slot, f.start, weight(f)))]
        counts = len(blocks), len(fixed), len(others), sum(map(written, others))
        levels += [LEVEL + len(numbered), *counts, *numbered]
    chooses, placed = choosing(program), place(program)
    below = [
        (form.block_rows[i].start, len(b.residuals), b.first, len(b.tears), b.linear,
         placed.jacobian(i), bool(b.residuals) and b.height > 1, i in chooses)
        for i, b in form.blocks
    ]  # fmt: skip
    lists = [[*chain(*own)], asking, [*chain(*below)], [f.start for f in form.fixed], levels]
    begins = [Plan.HEAD + sum(map(len, lists[:k])) for k in range(len(lists))]
    must, free = sum(c.fixed for c in candidates), not (rows or any(map(written, program.fixed)))
    together = len(form.stages) > len(heights) or bool(form.fixed)
    head = len(asking), must, free, len(below), len(heights), together
    return np.array([*head, *begins, *chain(*lists)], np.int64)
