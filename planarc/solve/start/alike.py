"""Two rods without mass that lead from one frame to one point: mostly the second one was copied,
and a sign or a length of it was to be another one.

In:   Program, a kernel that holds the start
Out:  a note (R452), or None

Example: of the two rods from a chassis to its axles, `r = {1.2, 0}` and `r = {-1.2, 0}`, the second
one lost its minus.
"""

from __future__ import annotations

from itertools import combinations

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.places import own_part, owner
from planarc.ir.program import Program

#: A length below this one, in m, is rounding.
_CLOSE = 1e-9

_Place = tuple[tuple[int, int], ...]  # slot and sign of each coordinate


class _Pair(Data):
    """Two rods that begin at one frame, and where they end."""

    names: tuple[str, str]
    begin: _Place
    ends: tuple[_Place, _Place]


def judge_alike(program: Program, kernel: Kernel) -> Diagnostic | None:
    """The note about the first two such rods."""
    w = kernel.w

    def apart(one: _Place, two: _Place) -> bool:
        pairs = zip(one, two, strict=True)
        return any(abs(a * w[i] - b * w[j]) > _CLOSE for (i, a), (j, b) in pairs)

    for pair in _pairs(program):
        one, two = pair.ends
        if apart(one, two) or not apart(pair.begin, one):
            continue
        first, second = (own_part(program, name) for name in pair.names)
        if first is None or second is None:
            continue
        shown = ", ".join(f"{sign * w[slot]:.4g}" for slot, sign in one)
        return Diagnostic(
            "R452",
            f"`{first.name}` and `{second.name}` begin at one frame, and end at one point: "
            f"{{{shown}}}",
            second.span,
            Severity.NOTE,
            hint=f"look at `{second.name}.r`: its sign or its length may have been copied",
            related=(Related("the other one", first.span),),
        )
    return None


@once
def _pairs(program: Program) -> tuple[_Pair, ...]:
    if program.mechanism is None:
        return ()
    columns = {c.name: (c.slot, c.sign) for c in program.columns}
    heavy = {owner(p.name) for p in program.parameter_slots if p.name.endswith(".m")}
    joints = {joint.name for joint in program.mechanism.joints}
    rods: dict[_Place, list[tuple[str, _Place]]] = {}  # by their beginnings
    for link in program.mechanism.links:
        for frame in link.frames:
            name, _, end = frame.rpartition(".")
            other = f"{name}.frame_b"
            bare = "." not in name and name not in joints and name not in heavy
            if end == "frame_a" and bare and other in link.frames:
                begin, far = (
                    tuple(columns.get(f"{f}.r[{i}]", (-1, 0)) for i in (1, 2))
                    for f in (frame, other)
                )
                if (-1, 0) not in begin + far:
                    rods.setdefault(begin, []).append((name, far))
    return tuple(
        _Pair((one[0], two[0]), begin, (one[1], two[1]))
        for begin, found in rods.items()
        for one, two in combinations(found, 2)
        if one[1] != two[1]  # whose far ends are connected to each other
    )
