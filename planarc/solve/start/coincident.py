"""A link of a four-bar without length: the others make a rigid triangle, which turns as one part.

In:   Program, a kernel that holds the start
Out:  a warning (R446), or None

Only loops of four joints are looked at: a loop of five may well have two bearings on one axis.

Example: of two `Fixed`, the bearings of crank and rocker, the second one was left where the first
one is.
"""

from __future__ import annotations

import math
from collections import Counter

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import both, listed
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.mechanism import GROUND, Joint, Mechanism
from planarc.ir.once import once
from planarc.ir.places import own_names, own_part
from planarc.ir.program import Program

#: A length below this one, in m, is rounding.
_CLOSE = 1e-12
_FOUR = 4

_Place = tuple[tuple[int, int], ...]  # slot and sign of each coordinate


class _Pair(Data):
    """Two pins of one link in a loop of four joints, and where they are."""

    link: int
    pins: tuple[str, str]
    others: tuple[int, ...]  # links of the loop
    places: _Place  # of the one, then of the other


def judge_coincident(program: Program, kernel: Kernel) -> Diagnostic | None:
    """The warning about the first such link."""
    if program.locked is not None:
        return None  # such as a bar with both joints at one end: it is why, and has been told
    pairs, take = _pairs(program)
    values, at = take(kernel.w), 0
    for pair in pairs:
        (_, a), (_, b), (_, c), (_, d) = pair.places
        x, y, u, v = a * values[at], b * values[at + 1], c * values[at + 2], d * values[at + 3]
        at += 4
        if -_CLOSE < x - u < _CLOSE and -_CLOSE < y - v < _CLOSE:
            return _told(program, kernel, pair, (float(x), float(y)))
    return None


def _told(program: Program, kernel: Kernel, pair: _Pair, place: tuple[float, float]) -> Diagnostic:
    links = program.mechanism.links if program.mechanism else ()
    joints = {joint.name for joint in program.mechanism.joints} if program.mechanism else set()

    def parts(link: int) -> list[str]:
        owners = (frame.rpartition(".")[0] for frame in links[link].frames)
        return [n for n in own_names(program, (o for o in owners if o not in joints)) if n]

    bars = [name for link in pair.others if link != GROUND for name in parts(link)[:1]]
    here = [name for name in parts(pair.link) if name != "world"]
    at = f"{{{place[0]:.4g}, {place[1]:.4g}}}"
    columns = {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}

    def is_there(part: str) -> bool:
        x, y = (columns.get(f"{part}.frame_b.r[{i}]", math.nan) for i in (1, 2))
        return math.hypot(x - place[0], y - place[1]) < _CLOSE

    apart = [part for part in here if not is_there(part)] if pair.link == GROUND else []
    here = [part for part in here if part not in apart]
    if pair.link != GROUND and here:  # what leads from one joint to the other, before what is on it
        ends = Counter(frame.rpartition(".")[0] for frame in links[pair.link].frames)
        here = [part for part in here if ends[part] > 1 or part not in ends][:1] or here[:1]
    own = own_part(program, here[-1] if here else apart[-1] if apart else pair.pins[1])
    hint = "give one of them another place"
    if apart and not here:
        hint = f"connect one of them to `{apart[-1]}`, which is elsewhere"
    elif pair.link == GROUND and here:
        hint = f"give {both(here[-2:])} places of their own by `r`"
        hint = hint if len(here) > 1 else f"give `{here[0]}` a place of its own by `r`"
    elif here:
        hint = f"give `{here[0]}` its length by `r`"
    return Diagnostic(
        "R446",
        f"{both(pair.pins)} are at the same place, {at}: {listed(f'`{b}`' for b in bars)} "
        "turn as one rigid part",
        own.span if own else None,
        Severity.WARNING,
        hint=hint,
    )


@once
def _pairs(program: Program) -> tuple[tuple[_Pair, ...], Taker]:
    """And what takes all their coordinates."""
    mechanism = program.mechanism
    if mechanism is None:
        return (), taker(())
    columns = {c.name: (c.slot, c.sign) for c in program.columns}
    found: dict[tuple[str, ...], _Pair] = {}
    for joint in mechanism.joints:
        loop = mechanism.shortest_loop(joint, _FOUR)
        if len(loop) != _FOUR or any(j.count > 1 for j in loop):
            continue
        links = tuple(dict.fromkeys(i for j in loop for i in j.links))
        for link in links:
            on = [(j, p) for j in loop if (p := _pin(j, link, mechanism, columns)) is not None]
            if len(on) == 2:
                pins = (on[0][0].name, on[1][0].name)
                others = tuple(i for i in links if i != link)
                found.setdefault(
                    tuple(sorted(pins)), _Pair(link, pins, others, (*on[0][1], *on[1][1]))
                )
    pairs = tuple(found.values())
    return pairs, taker([slot for pair in pairs for slot, _ in pair.places])


def _pin(
    joint: Joint, link: int, mechanism: Mechanism, columns: dict[str, tuple[int, int]]
) -> _Place | None:
    """Where a joint holds two frames at one point, of which one is on a link."""
    places = [
        tuple(columns.get(f"{frame}.r[{i}]", (-1, 0)) for i in (1, 2)) for frame in joint.frames
    ]
    on = any(frame in mechanism.links[link].frames for frame in joint.frames)
    same = len(places) == 2 and places[0] == places[1] and places[0][0][0] >= 0
    return places[0] if on and same else None
