"""Time events: the instants known beforehand, at which the run stops exactly.

In:   Program, Kernel (parameters set)
Out:  Schedule   when `sample` fires, when relations of time alone switch, and when inputs bend

A relation such as `time >= t0` whose zero function is linear in time switches at an
instant that can be computed; those of other relations of time alone (`sin(time) > 0`), also
by way of variables, are looked for (`scan`). The integrator is led exactly there, and to the
corners of tables that drive the kernel, where it stops without an event, lest it step over a pulse.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from sys import float_info
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from planarc.core.diagnostic import Diagnostic
from planarc.core.source import Span
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Op, below, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import Let, Program, RelationSlot
from planarc.solve.messages.text import Reader

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.solve.events.scan import Times

#: Instants nearer to each other than that many last digits, or than so many seconds, are one:
#: what follows from parameters and what an integrator finds agree no better.
DIGITS, SAME = 256, 1e-14
_PART = DIGITS * float_info.epsilon
#: More ticks than this of one sampler take no run to its end.
MOST_TICKS = 1e9
#: More ticks than this take a run a minute or more.
_MANY_TICKS = 1e6


class Sampler(Struct):
    slot: int
    start: float
    interval: float
    span: Span
    fired: int = 0

    def next(self) -> float:
        return self.start + self.fired * self.interval


class Schedule:
    """`instants` at which relations switch, ascending, and `switches`: the relation there and its
    truth from then on. `endless` are those that switch more often than a run can follow."""

    def __init__(self, program: Program, kernel: Kernel, start: float, stop: float) -> None:
        self.samplers: list[Sampler] = []
        if program.samplers:
            read = Reader(program, kernel, start)
            self.samplers += [
                Sampler(slot, float(read(first)), float(read(interval)), span)
                for slot, first, interval, span in program.samplers
            ]
        for sampler in self.samplers:
            if sampler.interval > 0 and sampler.start < start:
                passed = (start - sampler.start) / sampler.interval
                sampler.fired = max(0, math.ceil(passed - room(passed)))
        found: list[tuple[float, int, bool]] = []
        self.endless: list[RelationSlot] = []
        driven = _driven(program, kernel, start) if program.relations else {}
        for i, zero in driven.items():
            relation = program.relations[i]
            known = linear_zero(zero) if relation.time_only else None
            known = known or _other_zeros(zero, relation, start, stop)
            if known is None:
                self.endless.append(relation)
                continue
            instants, first = known
            later = ((t, i, first ^ bool(k % 2)) for k, t in enumerate(instants))
            found += [switch for switch in later if switch[0] > start]
        found.sort()
        self.instants = [t for t, _, _ in found]
        self.switches = [(i, truth) for _, i, truth in found]
        self._corners = kernel.capabilities.corners

    def judge(self, start: float, stop: float) -> Iterator[Diagnostic]:
        """What is wrong with instants: a sampler without ticks, or more than a run can take, or
        takes quickly."""
        for relation in self.endless:
            from planarc.solve.messages.event import oscillating

            yield oscillating(relation)
        for sampler in self.samplers:
            ticks = (stop - start) / sampler.interval if sampler.interval > 0 else 0.0
            between = sampler.interval > room(max(abs(start), abs(stop)))
            endless = ticks > MOST_TICKS or (ticks >= 1 and not between)
            if sampler.interval <= 0 or ticks > _MANY_TICKS or endless:
                from planarc.solve.messages.event import sampling

                yield sampling(sampler.span, sampler.start, sampler.interval, ticks, endless)

    def next(self, after: float) -> float:
        """The first instant that lies after a time."""
        if not (self.samplers or self.instants or self._corners):
            return math.inf
        found = math.inf
        for known in (self.instants, self._corners):
            place = bisect_right(known, after + room(after))
            found = min((found, *known[place : place + 1]))
        for sampler in self.samplers:
            if sampler.interval > 0 and after < (t := sampler.next()) < found:
                found = found if same(t, after) else t
        return found

    def switching(self, t: float) -> dict[int, bool]:
        begin, end = (bisect_right(self.instants, t + way) for way in (-2 * room(t), 2 * room(t)))
        near = zip(self.instants[begin:end], self.switches[begin:end], strict=True)
        return {i: truth for at, (i, truth) in near if same(at, t)}

    def firing(self, t: float) -> list[int]:
        """The samplers that fire now; each is asked once for an instant."""
        fired = []
        for i, sampler in enumerate(self.samplers):
            if sampler.interval > 0 and same(sampler.next(), t):
                sampler.fired += 1
                fired.append(i)
        return fired


def room(t: float) -> float:
    """How far two instants may be apart that are one."""
    return max(SAME, _PART * abs(t))


def same(a: float, b: float) -> bool:
    """Whether two instants are one: within the `room` of the one that lies nearer to zero."""
    apart = abs(a - b)
    return a == b or apart <= SAME or (apart <= _PART * abs(a) and apart <= _PART * abs(b))


_Values = Mapping[Expr, Expr]

#: Times at which a function is compared with a linear one: no period meets all of them.
_BETWEEN = (2.0, 0.6180339887, 1.4142135623)


def time_functions(program: Program, kernel: Kernel, start: float) -> dict[int, TimeFunction]:
    """The zero functions of the relations of time alone."""
    alone = {i: r.zero for i, r in enumerate(program.relations) if r.time_only}
    if not alone:
        return {}
    lets = {s.target: s.value for s in program.roots if isinstance(s, Let)}
    return {i: TimeFunction(program, kernel, zero, lets) for i, zero in alone.items()}


@once
def lines_of_time(program: Program) -> frozenset[int]:
    """The relations of time alone whose zero functions are written as lines over it."""
    degrees: dict[Expr, int] = {}
    for s in program.roots:
        if isinstance(s, Let):
            degrees[s.target] = _degree(s.value, degrees)
    alone = ((i, r.zero) for i, r in enumerate(program.relations) if r.time_only)
    return frozenset(i for i, zero in alone if _degree(zero, degrees) <= 1)


def _degree(root: Expr, known: Mapping[Expr, int]) -> int:
    """0 of a formula without time, 1 of a line over it, 2 of any other; symbols as known."""
    found: dict[Expr, int] = {}
    for e in postorder((root,)):
        below_it = [found[a] for a in e.args]
        most = max(below_it, default=0)
        match e.op:
            case Op.TIME:
                degree = 1
            case Op.SYMBOL:
                degree = known.get(e, 0)
            case Op.ADD | Op.NEG:
                degree = most
            case Op.MUL:
                degree = sum(below_it)
            case Op.DIV:
                degree = below_it[0] + 2 * below_it[1]
            case _:
                degree = 2 * most
        found[e] = min(degree, 2)
    return found[root]


def known_functions(program: Program, kernel: Kernel) -> dict[int, TimeFunction]:
    """The zero functions of the relations that have a value before anything is solved."""
    relations, lets = _known(program)
    return {i: TimeFunction(program, kernel, program.relations[i].zero, lets) for i in relations}


@once
def _known(program: Program) -> tuple[list[int], _Values]:
    """The relations that ask nothing but time, parameters and discrete variables, and the
    statements that they need."""
    fixed = {p.slot for p in program.parameter_slots}
    fixed.update(slot for d in program.discretes for slot in (d.slot, d.pre))
    lets: dict[Expr, Expr] = {}

    def known(e: Expr) -> bool:
        if e.op in (Op.SYMBOL, Op.PRE):
            return e in lets or program.slots.get(repr(e)) in fixed
        return e.op not in (Op.PAST, Op.APPLY, Op.EVENT)

    for s in program.roots:
        if isinstance(s, Let) and all(map(known, below((s.value,)))):
            lets[s.target] = s.value
    found = enumerate(program.relations)
    return [i for i, r in found if r.time_only or all(map(known, below((r.zero,))))], lets


def _driven(program: Program, kernel: Kernel, start: float) -> dict[int, TimeFunction]:
    """The zero functions of time alone, also those that ask variables which are."""
    by_way = by_way_of_variables(program)
    found = time_functions(program, kernel, start)
    for i, lets in by_way.items():
        found[i] = TimeFunction(program, kernel, program.relations[i].zero, lets)
    return found


@once
def by_way_of_variables(program: Program) -> dict[int, _Values]:
    """The other relations whose zero functions follow from time, by the statements they need."""
    asked = [i for i, relation in enumerate(program.relations) if not relation.time_only]
    if not asked:
        return {}
    fixed = {p.slot for p in program.parameter_slots}
    lets: dict[Expr, Expr] = {}

    def follows(e: Expr) -> bool:
        if e.op is Op.EVENT:
            return bool(program.relations[e.data].time_only)
        if e.op is Op.SYMBOL:
            return e in lets or program.slots.get(repr(e)) in fixed
        return e.op not in (Op.PRE, Op.PAST, Op.APPLY)

    for s in chain(program.roots, *program.levels, program.rest, program.roots):
        if isinstance(s, Let) and all(map(follows, below((s.value,)))):
            lets[s.target] = s.value
    return {i: lets for i in asked if program.relations[i].zero in lets}


class TimeFunction:
    """The zero function of a relation of time alone, evaluated without the kernel."""

    def __init__(self, program: Program, kernel: Kernel, zero: Expr, lets: _Values) -> None:
        self._program, self._kernel, self._zero, self._lets = program, kernel, zero, lets

    def __call__(self, t: float) -> float | None:
        read = Reader(self._program, self._kernel, t)
        values: dict[Expr, float] = {}

        def leaf(e: Expr) -> float:
            return values[e] if e in values else read.leaf(e)

        try:
            for target in _needed(self._zero, self._lets):
                values[target] = float(evaluate(self._lets[target], leaf))
            return float(evaluate(self._zero, leaf))
        except (ArithmeticError, ValueError, KeyError):
            return None

    def at(self, times: Times) -> Times:
        """The values at many times; nan where there is none."""
        import numpy as np

        from planarc.evaluate.rows import RowValues

        read = Reader(self._program, self._kernel, 0.0)
        rows: RowValues

        def leaf(e: Expr) -> Any:
            if e.op is Op.TIME:
                return times
            if e.op is Op.EVENT:
                relation = self._program.relations[e.data]
                return _truth(relation, rows(relation.zero))
            return rows(self._lets[e]) if e in self._lets else read.leaf(e)

        rows = RowValues(leaf)
        with np.errstate(all="ignore"):
            return np.broadcast_to(rows(self._zero), times.shape)


def _needed(zero: Expr, lets: _Values) -> list[Expr]:
    """The temporaries below a zero function, those first that others need."""
    order: list[Expr] = []
    stack = [(zero, False)]
    while stack:
        e, ready = stack.pop()
        if ready:
            if e in lets and e not in order:
                order.append(e)
            continue
        stack.append((e, True))
        roots = (lets[e],) if e in lets else (e,)
        stack.extend(
            (leaf, False)
            for leaf in postorder(roots)
            if leaf.op is Op.SYMBOL and leaf in lets and leaf is not e
        )
    return order


def _truth(relation: RelationSlot, zero: Times) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = zero < 0 if relation.strict else zero <= 0
    return found


def _other_zeros(
    zero: TimeFunction, relation: RelationSlot, start: float, stop: float
) -> tuple[Sequence[float], bool] | None:
    """The instants at which a relation switches, and its truth after the first."""
    from planarc.solve.events.scan import switches

    found = switches(lambda times: _truth(relation, zero.at(times)), start, stop)
    if found is None:
        return None
    return found.tolist(), len(found) > 0 and bool(_truth(relation, zero.at(found[:1]))[0])


def linear_zero(zero: TimeFunction) -> tuple[Sequence[float], bool] | None:
    """The zero of a function linear in time, and whether it is below zero afterwards.

    Far from zero the slope is known to few digits: what is left there is taken off again.
    """
    begin, end = zero(0.0), zero(1.0)
    if begin is None or end is None or begin == end:
        return None
    slope = end - begin
    for t in _BETWEEN:
        g = zero(t)
        if g is None or abs(g - begin - t * slope) > 1e-12 * max(abs(begin), abs(end), abs(g)):
            return None
    at = -begin / slope
    for _ in range(3):
        rest = zero(at)
        at -= rest / slope if rest else 0.0
    return (at,), slope < 0
