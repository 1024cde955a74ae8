"""The far side of a fold: where the solution of a block ends, another one may go on.

In:   Rescue, a point (t, y) at which or right after which a block has no solution near by
Out:  the first such point, with the block solved from another root; None where there is none

Example: the output of a Schmitt trigger follows a curve that turns back. At the turn the run
jumps to the curve's other branch, as it would at an event.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from planarc.solve.rescue.rescue import Rescue

#: Factor from one look ahead to the next.
FURTHER = 4.0
#: Part of the way to the fold within which it is found.
NEAR = 1e-9
#: A root that is no further from the last one, relative to max(1, |x|), is the turn itself.
CLOSE = 1e-4


def leap(
    rescue: Rescue, t: float, y: Sequence[float], least: float, furthest: float
) -> tuple[float, list[float]] | None:
    """The time and the states beyond the fold, between `least` and `furthest` away. The block
    starts from its new root then; `rescue.leapt` tells which it was."""
    kernel, ydot = rescue.kernel, [0.0] * len(y)

    def evaluate(h: float) -> int:
        return kernel.outputs(t + h, [a + h * d for a, d in zip(y, ydot, strict=True)])

    kernel.rhs(t, y, ydot)
    good = h = 0.0
    while h <= furthest:
        if evaluate(h) != 0:
            h = _edge(evaluate, good, h, least)
            if rescue.overcome(t + h, partial(evaluate, h)) != 0:
                return None
            if rescue.moved > CLOSE:
                return t + h, [a + h * d for a, d in zip(y, ydot, strict=True)]
            if h == 0.0:  # the turn itself: now it can be seen where it leads
                kernel.rhs(t, y, ydot)
        good, h = h, max(FURTHER * h, least)
    return None


def _edge(evaluate: Callable[[float], int], good: float, bad: float, least: float) -> float:
    """The first argument that cannot be evaluated, between one that can and one that cannot."""
    while bad - good > max(least, NEAR * good):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if evaluate(middle) == 0 else (good, middle)
    return bad
