"""Normal forces at rest that are not determined: several contacts carry what fewer could.

In:   the touches of a run, where it ends: those that are held, and those that only just are not,
      since others carry all
Out:  a note R416 that names their contacts; nothing where all have the forces that they need

    a       how the accelerations along the normals answer to normal forces, of all of these
    open    a force that presses and is as well carried by other contacts: its column of `a` is a
            sum of theirs, with no pull where none presses

How the points of one contact share its force is nobody's question: two boxes on each other touch by
the corners of both.

Example: a bar in the middle and at both ends on ropes: a = (a_left + a_right)/2 in the middle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planarc.core.diagnostic import Diagnostic
from planarc.solve.contact import messages
from planarc.solve.contact.touches import Touches

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: Gaps, speeds and accelerations below this, in m and s, are none.
STILL = 1e-7
#: Errors of sums, and forces that are none, as parts of the largest.
SMALL = 1e-9


def judge_shares(
    touches: Touches, t: float, y: Sequence[float], states: Mapping[int, int]
) -> list[Diagnostic]:
    """The workspace holds the point (t, y) and does so afterwards."""
    rest = _resting(touches)
    groups = [messages.contact_of(touches, i) for i in rest]
    if len(set(groups)) < 2:
        return []
    force, w = touches.get("f_n")[rest], touches.kernel.w
    before = [float(v) for v in w]
    found = touches.respond(t, y, states, rest.tolist())
    for slot, value in enumerate(before):
        w[slot] = value
    touches.kernel.accept(t)
    if found is None:
        return []
    some = find_open(found[0].own[rest, : len(rest)], force, groups)
    return [messages.shared(touches, rest[some].tolist(), t)] if some else []


def _resting(touches: Touches) -> Array:
    """The touches at which something may press, and goes on doing so."""
    held = touches.get("held") != 0
    still = np.abs([touches.get(name) for name in ("gap", "v", "a")]).max(axis=0) < STILL
    found: Array = np.flatnonzero((held | still) & ~touches.bound)
    return found if held.any() else found[:0]


def find_open(a: Vector, force: Vector, groups: Sequence[str]) -> list[int]:
    """The first force that other groups could carry, with these; nothing where there is none."""
    from scipy.optimize import nnls

    largest = float(np.abs(force).max(initial=0.0))
    presses = force > SMALL * largest
    for j in np.flatnonzero(presses).tolist():
        others = [i for i, group in enumerate(groups) if group != groups[j]]
        more = [i for i in others if presses[i]]
        columns = np.hstack([a[:, others], -a[:, more]])
        size = float(np.abs(a[:, j]).max(initial=0.0))
        try:
            shares, off = nnls(columns, a[:, j])
        except RuntimeError:  # too many iterations
            continue
        if size == 0.0 or off > SMALL * size:
            continue
        change = np.zeros(len(force))
        change[j] = -1.0
        np.add.at(change, others, shares[: len(others)])
        np.add.at(change, more, -shares[len(others) :])
        if change.max() > SMALL:  # else they only let go of each other
            return np.flatnonzero(np.abs(change) > SMALL).tolist()
    return []
