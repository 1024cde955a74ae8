"""Numbers that when-clauses and equations give each other at one instant.

In:   one pass of the event iteration, and the slots of the numbers that it changes
Out:  the numbers that a pass leaves as they are

    when sample(1, 1) then a = 3*b + 1; end when;    b = 2*a + x;

Passes alone come to rest only where they contract. Newton's method on `pass(x) = x` finds
the rest of any other loop, at once where it is linear.
"""

from __future__ import annotations

from collections.abc import Callable, MutableSequence, Sequence

#: Part of its size by which a number may change in a pass that leaves it as it is.
CLOSED = 1e-11
#: Part of its size by which a number is moved for differences.
MOVE = 1e-4
MOST_STEPS = 20
#: The least singular value, as a part of the largest, of a loop that has a solution.
LEAST = 1e-8


def same_number(a: float, b: float) -> bool:
    return abs(a - b) <= CLOSED * max(1.0, abs(b))


def close_loop(
    w: MutableSequence[float], slots: Sequence[int], one_pass: Callable[[], bool]
) -> bool:
    """Set the slots to what a pass leaves as it is; false where that is not found."""
    import numpy as np

    def after(values: Sequence[float]) -> list[float] | None:
        for slot, value in zip(slots, values, strict=True):
            w[slot] = value
        return [w[slot] for slot in slots] if one_pass() else None

    x = [w[slot] for slot in slots]
    for _ in range(MOST_STEPS):
        found = after(x)
        if found is None:
            return False
        if all(map(same_number, found, x)):
            for slot, value in zip(slots, x, strict=True):
                w[slot] = value
            return True
        columns = []
        for k, value in enumerate(x):
            step = MOVE * max(1.0, abs(value))
            moved = after([*x[:k], value + step, *x[k + 1 :]])
            if moved is None:
                return False
            columns.append([(b - a) / step for a, b in zip(found, moved, strict=True)])
        matrix = np.eye(len(x)) - np.array(columns).T
        if not np.isfinite(matrix).all():
            return False
        sizes = np.linalg.svd(matrix, compute_uv=False)
        if sizes[-1] < LEAST * max(1.0, sizes[0]):
            return False
        x = (np.array(x) + np.linalg.solve(matrix, np.subtract(found, x))).tolist()
    return False
