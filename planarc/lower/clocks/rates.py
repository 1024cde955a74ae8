"""How often parts tick: from the clocks that are given, by the operators between parts.

In:   Parting
Out:  a Rate for each part: its base clock, and every which of its ticks, from which on

Example: part 2 follows from part 1 by `subSample(u, 3)`, part 3 from it by `superSample(u, 2)`; a
clock of 0.1 s is given for part 2. The base clock ticks at each instant of part 3.

    part 1   every 2nd tick of the base clock, which ticks each 1/60 s
    part 2   every 6th
    part 3   each

Times are counted in ticks of the part whose clock is given, as fractions: ticks of several parts
that fall together do so exactly.

Reference: Modelica Language Specification 3.6, sections 16.3, 16.5.2 and 16.7.5.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import gcd, lcm

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related, Severity, error
from planarc.core.disjoint import DisjointSets
from planarc.ir import flat
from planarc.ir.text.flat import print_expression
from planarc.lower.clocks.parts import Conversion, Part, Parting


class Base(Data):
    """A clock that others follow from: the one given, and the part of its interval after which it
    ticks."""

    clock: flat.Builtin
    grain: Fraction


class Rate(Data):
    """Each `every`th tick of a base clock, from the tick number `first` on, counted from 0."""

    base: int
    every: int
    first: int


class _Beat(Data):
    """Interval and first tick of a part, in intervals of the part whose clock is given."""

    interval: Fraction
    first: Fraction


def find_rates(parting: Parting) -> tuple[list[Base], list[Rate], list[Diagnostic]]:
    """Base clocks, a rate for each part, and warnings. Raises PlanarcError (L373, L374)."""
    groups: DisjointSets[int] = DisjointSets(range(len(parting.parts)))
    for c in parting.conversions:
        groups.join(c.source, c.target)
    bases: list[Base] = []
    rates: dict[int, Rate] = {}
    warnings: list[Diagnostic] = []
    for group in groups.sets():
        if not any(parting.parts[i].clocks for i in group):
            parting, warning = _from_outside(parting, group)
            warnings.append(warning)
        given = _given(parting.parts, group)
        beats = _follow(parting, group, given)
        _agree(parting.parts, beats, given)
        grain = _grain([b for beat in beats.values() for b in (beat.interval, beat.first)])
        clock = parting.parts[given].clocks[0]
        if is_event(clock) and grain != 1:
            where = next(i for i, b in beats.items() if b.interval % 1 or b.first % 1)
            raise error(
                "L374",
                "this ticks between the ticks of a clock that waits for a condition",
                parting.parts[where].span,
                hint="let the condition tick as often as the fastest part does, and `subSample` it",
                related=[Related("the clock", clock.span)],
            )
        for i, beat in beats.items():
            rates[i] = Rate(len(bases), int(beat.interval / grain), int(beat.first / grain))
        bases.append(Base(clock, grain))
    return bases, [rates[i] for i in range(len(parting.parts))], warnings


def is_event(clock: flat.Builtin) -> bool:
    """Whether a clock ticks where a condition becomes true."""
    return clock.arguments[0].type.base is flat.Base.BOOLEAN


def ratio(clock: flat.Builtin) -> Fraction | None:
    """The interval of a clock that is given by numbers, in seconds."""
    match clock.arguments:
        case (flat.Literal(value=int(counter)), flat.Literal(value=int(resolution))):
            return Fraction(counter, resolution)
        case (flat.Literal(value=int() | float() as interval),):
            return Fraction(str(interval))
    return None


def _from_outside(parting: Parting, group: Sequence[int]) -> tuple[Parting, Diagnostic]:
    """Parts whose clock comes from where the model's inputs and outputs are connected: by itself
    it ticks each second. Refuses those that nothing outside can reach."""
    parts = list(parting.parts)
    first = parts[group[0]]
    hint = "give it a clock, as in `sample(u, Clock(0.1))` or `when Clock(0.1) then`"
    if not any(parts[i].open for i in group):
        raise error("L373", "nothing says when this ticks", first.span, hint=hint)
    second = flat.Literal(flat.INTEGER, first.span, 1)
    clock = flat.Builtin(flat.CLOCK, first.span, "Clock", (second, second))
    parts[group[0]] = replace(first, clocks=(clock,))
    message = "the clock of this comes from outside of the model: alone it ticks each second"
    told = Diagnostic("L373", message, first.span, Severity.WARNING, hint=hint)
    return replace(parting, parts=tuple(parts)), told


def _given(parts: Sequence[Part], group: Sequence[int]) -> int:
    """A part of the group with a clock: first one that is given by whole numbers."""
    timed = [i for i in group if parts[i].clocks]
    return min(timed, key=lambda i: len(parts[i].clocks[0].arguments) < 2)


def _follow(parting: Parting, group: Sequence[int], given: int) -> dict[int, _Beat]:
    """The beats of all parts of a group, from the one whose clock is given on."""
    beats = {given: _Beat(Fraction(1), Fraction(0)), **_seeds(parting.parts, group, given)}
    ours = [c for c in parting.conversions if c.source in group]
    while True:
        count = len(beats)
        for c in ours:
            if c.source in beats and c.target not in beats and _is_known(c):
                beats[c.target] = _after(c, beats[c.source])
            elif c.target in beats and c.source not in beats and _is_known(c):
                beats[c.source] = _before(c, beats[c.target])
        if len(beats) > count:
            continue
        open_ = next((c for c in ours if (c.source in beats) != (c.target in beats)), None)
        if open_ is None:
            break
        known = beats[open_.source if open_.source in beats else open_.target]
        beats[open_.target if open_.source in beats else open_.source] = known  # factor 1
    for c in ours:
        _expect(c, beats[c.source], beats[c.target], parting.parts[given].clocks[0])
    return beats


def _seeds(parts: Sequence[Part], group: Sequence[int], given: int) -> dict[int, _Beat]:
    """The beats of parts that have clocks of their own: the one given again, or such as numbers
    compare with it."""
    first = parts[given].clocks[0]
    found: dict[int, _Beat] = {}
    for i in group:
        known = [r for clock in parts[i].clocks if (r := _times_of(first, clock)) is not None]
        if known and i != given:
            found[i] = _Beat(known[0], Fraction(0))
    return found


def _times_of(first: flat.Builtin, clock: flat.Builtin) -> Fraction | None:
    """The interval of a clock as a multiple of another one's, where that is known."""
    if print_expression(clock) == print_expression(first):
        return Fraction(1)
    unit, own = ratio(first), ratio(clock)
    return None if unit is None or own is None else own / unit


def _is_known(c: Conversion) -> bool:
    return not c.operator or bool(c.numbers)


def _after(c: Conversion, beat: _Beat) -> _Beat:
    match c.operator, c.numbers:
        case "subSample", (factor,):
            return _Beat(beat.interval * factor, beat.first)
        case "superSample", (factor,):
            return _Beat(beat.interval / factor, beat.first)
        case "shiftSample", (counter, resolution):
            return _Beat(beat.interval, beat.first + beat.interval * Fraction(counter, resolution))
        case "backSample", (counter, resolution):
            return _Beat(beat.interval, beat.first - beat.interval * Fraction(counter, resolution))
    return beat


_INVERSE = {
    "subSample": "superSample",
    "superSample": "subSample",
    "shiftSample": "backSample",
    "backSample": "shiftSample",
    "": "",
}


def _before(c: Conversion, beat: _Beat) -> _Beat:
    inverse = Conversion(_INVERSE[c.operator], c.numbers, c.target, c.source, c.span)
    return _after(inverse, beat)


def _expect(c: Conversion, source: _Beat, target: _Beat, clock: flat.Builtin) -> None:
    """Refuse a conversion that does not fit what its two sides are."""
    own = _after(c, source)
    if _is_known(c):
        fits = own == target
    else:
        factor = target.interval / source.interval
        whole = factor if c.operator == "subSample" else 1 / factor
        fits = whole.denominator == 1 and source.first == target.first
    if not fits:
        message = f"`{c.span.text}` ticks {_times(own)}, and its equation {_times(target)}"
        related = [Related(f"counted in the intervals of `{_text(clock)}`", clock.span)]
        raise error("L374", message, c.span, related=related)


def _times(beat: _Beat) -> str:
    interval = "every interval" if beat.interval == 1 else f"every {beat.interval} intervals"
    return f"{interval} from {beat.first} on" if beat.first else interval


def _agree(parts: Sequence[Part], beats: dict[int, _Beat], given: int) -> None:
    """Refuse clocks that do not fit each other."""
    first = parts[given].clocks[0]
    origin = min(beat.first for beat in beats.values())
    if origin < 0:
        where = next(i for i, b in beats.items() if b.first == origin)
        message = "this would tick before the clock that is given for it begins"
        related = [Related("the clock", first.span)]
        raise error("L374", message, parts[where].span, related=related)
    for i, clock in _clocks(parts, beats):
        times, beat = _times_of(first, clock), beats[i]
        if clock is not first and (times != beat.interval or beat.first):
            raise error(
                "L374",
                f"`{_text(clock)}` and `{_text(first)}` tick for one part of the model",
                clock.span,
                hint="keep one of them; what passes from one clock to another goes through "
                "`subSample`, `superSample`, or `hold` and `sample`",
                related=[Related("the other clock", first.span)],
            )


def _clocks(parts: Sequence[Part], beats: dict[int, _Beat]) -> Iterator[tuple[int, flat.Builtin]]:
    return ((i, clock) for i in beats for clock in parts[i].clocks)


def _text(clock: flat.Builtin) -> str:
    return " ".join(clock.span.text.split())


def _grain(times: Sequence[Fraction]) -> Fraction:
    """The longest time of which all are multiples."""
    below = lcm(*(t.denominator for t in times))
    return Fraction(gcd(*(int(t * below) for t in times)), below)
