"""A moving part that is far longer than all else, or than a part of such small inertia is: mostly
it was given in mm.

In:   Program, a kernel that holds the start
Out:  a warning (R441), or None

A part is as long as its frames are apart that move as one piece, and the points that it declares,
as a centre of mass. It is compared with the other moving parts, and with the places on the ground;
a very long one also with the radius of gyration of what it carries. Loops that do not close are
told before.

Example: a boom with r = {400, 0} on a column of 0.5 m.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import both
from planarc.ir.expr import Expr
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.mechanism import GROUND
from planarc.ir.once import once
from planarc.ir.places import own_part, owner
from planarc.ir.program import Program
from planarc.solve.start.sizes import RADIUS, reader_of, value_of

#: Lengths below this one, in m, suit any mechanism.
_PLAUSIBLE = 10.0
#: Multiple of all other lengths that is hardly meant.
_FAR = 150.0
#: The least length of a part, in m, whose inertia is looked at, and the multiple of its radius of
#: gyration that it hardly has.
_LONG, _THIN = 100.0, 1e3

Place = tuple[tuple[int, int], ...]  # slot and sign of each coordinate


class _Ends(Data):
    """What a part holds together on one link."""

    part: str
    frames: tuple[Place, ...]
    points: Mapping[str, Place]  # by their names


def judge_longest(program: Program, kernel: Kernel) -> Diagnostic | None:
    """The warning about a part that is far longer than all others."""
    _, take = _parts(program)
    for value in take(kernel.w):
        if not -_PLAUSIBLE / 3 < value < _PLAUSIBLE / 3:
            break
    else:
        return None
    lengths = lengths_of_parts(program, kernel)
    return _far_longer(program, kernel, lengths) or _thin(program, kernel, lengths)


def _far_longer(
    program: Program, kernel: Kernel, lengths: Mapping[str, float]
) -> Diagnostic | None:
    if len(lengths) < 2 or not any(length > _PLAUSIBLE for length in lengths.values()):
        return None
    (part, longest), (_, next_one) = sorted(lengths.items(), key=lambda item: -item[1])[:2]
    if not part or not 0 < next_one < longest / _FAR:
        return None
    return _told(
        program,
        part,
        f"{_long(program, kernel, part, longest, 3)}, and nothing else in its mechanism more than "
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
        if d.kind == "size" and d.name.startswith(RADIUS) and isinstance(d.value, Expr)
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
    said = _long(program, kernel, part, lengths[part], 4)
    message = f"{said}, and has a radius of gyration of no more than {thin[part]:.3g} m"
    return _told(program, part, message)


def _long(program: Program, kernel: Kernel, part: str, length: float, digits: int) -> str:
    """How long a part is, in words; of one that is so long up to a point, with its name."""
    told = f"`{part}` is {length:.{digits}g} m long"
    own = [ends for ends in _parts(program)[0] if ends.part == part]
    framed = max(spread(kernel, ends.frames) for ends in own)
    points = dict.fromkeys(name for ends in own for name in ends.points)
    return told if framed > length / 2 else f"{told} up to its {both([*points])}"


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
    """How long the parts are, in m, by the places of their frames and points; "" is the ground."""
    lengths = dict[str, float]()
    for ends in _parts(program)[0]:
        length = spread(kernel, (*ends.frames, *ends.points.values()))
        lengths[ends.part] = max(length, lengths.get(ends.part, 0.0))
    return lengths


def spread(kernel: Kernel, places: Iterable[Place]) -> float:
    """The diagonal of the box around places."""
    at = [[sign * kernel.w[slot] for slot, sign in place] for place in places]
    return math.hypot(*(max(along) - min(along) for along in zip(*at, strict=True)))


@once
def _parts(program: Program) -> tuple[tuple[_Ends, ...], Taker]:
    """The parts of the model that hold several frames, or points, together, with these; "" is the
    ground. And what takes all their coordinates."""
    if program.mechanism is None:
        return (), taker(())
    columns = {c.name: (c.slot, c.sign) for c in program.columns}
    joints = {joint.name for joint in program.mechanism.joints}
    points = _points(program, columns)
    found: dict[tuple[int, str], list[Place]] = {}
    pointed: dict[tuple[int, str], dict[str, Place]] = {}
    for number, link in enumerate(program.mechanism.links):
        for frame in link.frames:
            names = [f"{frame}.r[{i}]" for i in (1, 2)]
            part = "" if number == GROUND else frame.partition(".")[0]
            if part not in joints and all(n in columns for n in names):
                place = tuple(columns[n] for n in names)
                found.setdefault((number, part), []).append(place)
                if number != GROUND:
                    own = points.get(owner(frame), {})
                    pointed.setdefault((number, part), {}).update(own)
    every = (
        _Ends(key[1], tuple(dict.fromkeys(places)), pointed.get(key, {}))
        for key, places in found.items()
    )
    parts = tuple(ends for ends in every if len(ends.frames) + len(ends.points) > 1)
    places = (place for ends in parts for place in (*ends.frames, *ends.points.values()))
    return parts, taker(tuple(dict.fromkeys(slot for place in places for slot, _ in place)))


def _points(
    program: Program, columns: Mapping[str, tuple[int, int]]
) -> dict[str, dict[str, Place]]:
    """The points that each component declares that lies on one link."""
    assert program.mechanism is not None
    on: dict[str, set[int]] = {}
    for number, link in enumerate(program.mechanism.links):
        for frame in link.frames:
            on.setdefault(owner(frame), set()).add(number)
    found: dict[str, dict[str, Place]] = {}
    for declared in program.declared:
        if declared.kind != "point" or len(on.get(declared.component, ())) != 1:
            continue
        names = [repr(e) for e in declared.value] if isinstance(declared.value, tuple) else []
        if len(names) == 2 and all(n in columns for n in names):
            place = tuple(columns[n] for n in names)
            found.setdefault(declared.component, {})[declared.name] = place
    return found
