"""A moving part that is far longer than all else, or than a part of such small inertia is: mostly
it was given in mm.

In:   Program, a kernel that holds the start
Out:  a warning (R441), or None

A part is as long as its frames are apart that move as one piece. It is compared with the other
moving parts, and with the places on the ground; a very long one also with the radius of gyration of
what it carries. Loops that do not close are told before.

Example: a boom with r = {400, 0} on a column of 0.5 m.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.expr import Expr
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.mechanism import GROUND
from planarc.ir.once import once
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.start.sizes import reader_of, value_of

#: Lengths below this one, in m, suit any mechanism.
_PLAUSIBLE = 10.0
#: Multiple of all other lengths that is hardly meant.
_FAR = 150.0
#: The least length of a part, in m, whose inertia is looked at, and the multiple of its radius of
#: gyration that it hardly has.
_LONG, _THIN = 100.0, 1e3
#: What a part with mass declares of its inertia begins so.
_RADIUS = "radius of gyration"

_Place = tuple[tuple[int, int], ...]  # slot and sign of each coordinate


def judge_longest(program: Program, kernel: Kernel) -> Diagnostic | None:
    """The warning about a part that is far longer than all others."""
    _, take = _parts(program)
    if all(abs(value) < _PLAUSIBLE / 3 for value in take(kernel.w)):
        return None
    lengths = lengths_of_parts(program, kernel)
    return _far_longer(program, lengths) or _thin(program, kernel, lengths)


def _far_longer(program: Program, lengths: Mapping[str, float]) -> Diagnostic | None:
    if len(lengths) < 2 or not any(length > _PLAUSIBLE for length in lengths.values()):
        return None
    (part, longest), (_, next_one) = sorted(lengths.items(), key=lambda item: -item[1])[:2]
    if not part or not 0 < next_one < longest / _FAR:
        return None
    return _told(
        program,
        part,
        f"`{part}` is {longest:.3g} m long, and nothing else in its mechanism more than "
        f"{next_one:.3g} m",
    )


def _thin(program: Program, kernel: Kernel, lengths: Mapping[str, float]) -> Diagnostic | None:
    """The warning about the longest part whose link has next to no inertia."""
    long = [part for part, length in lengths.items() if part and length >= _LONG]
    if not long or program.mechanism is None:
        return None
    read = reader_of(program, kernel)
    radii = {
        d.component: value_of(read, d.value)
        for d in program.declared
        if d.kind == "size" and d.name.startswith(_RADIUS) and isinstance(d.value, Expr)
    }
    thin: dict[str, float] = {}
    for link in program.mechanism.links:
        owners = {frame.rpartition(".")[0] for frame in link.frames}
        most = max((radii[o] for o in owners if o in radii), default=0.0)
        for part in long:
            around = any(frame.partition(".")[0] == part for frame in link.frames)
            if around and 0 < most < lengths[part] / _THIN:
                thin[part] = most
    if not thin:
        return None
    part = max(thin, key=lambda p: lengths[p])
    message = (
        f"`{part}` is {lengths[part]:.4g} m long, and has a radius of gyration of no more than "
    )
    return _told(program, part, f"{message}{thin[part]:.3g} m")


def _told(program: Program, part: str, message: str) -> Diagnostic:
    own = own_part(program, part)
    return Diagnostic(
        "R441",
        message,
        own.span if own else None,
        Severity.WARNING,
        hint="lengths are in m: 1 mm is 1e-3 m",
    )


def lengths_of_parts(program: Program, kernel: Kernel) -> dict[str, float]:
    """How long the parts are, in m, by the places of their frames; "" is the ground."""
    w, lengths = kernel.w, dict[str, float]()
    for part, places in _parts(program)[0]:
        at = [[sign * w[slot] for slot, sign in place] for place in places]
        length = math.hypot(*(max(along) - min(along) for along in zip(*at, strict=True)))
        lengths[part] = max(length, lengths.get(part, 0.0))
    return lengths


@once
def _parts(program: Program) -> tuple[tuple[tuple[str, tuple[_Place, ...]], ...], Taker]:
    """The parts of the model that hold several frames together, with these; "" is the ground. And
    what takes all their coordinates."""
    if program.mechanism is None:
        return (), taker(())
    columns = {c.name: (c.slot, c.sign) for c in program.columns}
    joints = {joint.name for joint in program.mechanism.joints}
    found: dict[tuple[int, str], list[_Place]] = {}
    for number, link in enumerate(program.mechanism.links):
        for frame in link.frames:
            names = [f"{frame}.r[{i}]" for i in (1, 2)]
            part = "" if number == GROUND else frame.partition(".")[0]
            if part not in joints and all(n in columns for n in names):
                place = tuple(columns[n] for n in names)
                found.setdefault((number, part), []).append(place)
    distinct = ((part, tuple(dict.fromkeys(places))) for (_, part), places in found.items())
    parts = tuple((part, places) for part, places in distinct if len(places) > 1)
    slots = dict.fromkeys(slot for _, places in parts for place in places for slot, _ in place)
    return parts, taker(tuple(slots))
