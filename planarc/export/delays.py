"""The delays of a model: what its code must know of them.

    px_intervals(block, intervals, most)   from the parameters; not a number where one changes

and the table `px_past` (`instance.past.layout.Told`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from planarc.codegen.native.assembly import POINTER, REAL, SELDOM, Code, table
from planarc.codegen.native.formulas import formula, real
from planarc.instance.clauses import reader
from planarc.instance.past.layout import sizes, work_size
from planarc.instance.plan import Lags
from planarc.ir.frame import Frame
from planarc.ir.program import Program

#: Pieces of the past that there is room for in any model; what each jump needs; and the most that
#: sampling and the host's steps are reckoned to need.
_PIECES, _OF_JUMP, _MOST = 600, 3, 20_000
#: Kinks for each piece: jumps, which begin pieces, and as many that are none.
_KINKS = 2


def room_of(program: Program, longest: float, ticks: Sequence[float], step: float) -> Lags | None:
    """`longest` is the longest delay at export, `ticks` are the intervals of samplers and `step` is
    that of the experiment. None for a model without delays."""
    if not program.delays:
        return None
    jumps = sum(longest / t for t in (*ticks, step) if t > 0)
    pieces = _PIECES + math.ceil(min(_OF_JUMP * jumps, _MOST))
    counts = len(program.delays), len(program.inputs), program.state_count
    delays, inputs, states = counts
    return Lags(
        pieces,
        sizes(delays, pieces, _KINKS * pieces, inputs, states),
        work_size(*counts),
    )


def delay_messages(program: Program, lags: Lags | None) -> list[str]:
    """Why a run may end at a delay: two texts for each, and that of the whole past."""
    if lags is None:
        return []
    found = []
    for d in program.delays:
        found += [
            f"the delay time of `{d.text}` is not above zero",
            f"the delay time of `{d.text}` is not between 0 and its largest one",
        ]
    full = (
        f"what is delayed jumps or changes too often: of its past no more than {lags.pieces} pieces"
        " are kept; export the model with the delay times and the sampling of this run"
    )
    return [*found, full]


def delay_functions(program: Program, lags: Lags | None, image: int, first: int) -> str:
    """The function and the table. `image`: words of a new state; `first`: the number of the first
    message."""
    if lags is None:
        return ""
    c = Code("px_intervals", "void", ((POINTER, "m"), (POINTER, "intervals"), (POINTER, "most")))
    m, intervals, most = c.arguments
    w = m.load(POINTER, Frame.W)
    leaf = reader(program, w, w.load(REAL))
    rows: list[int] = []
    for i, d in enumerate(program.delays):
        fixed = d.interval_slot is None
        interval = real(c, formula(c, d.interval, leaf)) if fixed else c.constant(math.nan, REAL)
        intervals.store(interval, i)
        longest = interval if d.maximum is None else real(c, formula(c, d.maximum, leaf))
        most.store(longest, i)
        rows += [d.slot, d.sign, -1 if d.interval_slot is None else d.interval_slot]
    c.give()
    inputs = [program.slots[name] for name in program.inputs]
    numbers = (len(program.delays), lags.pieces, _KINKS * lags.pieces, len(inputs), image, first)
    return c.text(SELDOM) + table("px_past", (*numbers, *rows, *inputs))
