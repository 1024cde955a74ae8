"""Time events: the instants known beforehand, at which the run stops exactly.

In:   Program, Kernel (parameters set)
Out:  Schedule   when `sample` fires and when relations of time alone switch

A relation such as `time >= t0` whose zero function is linear in time switches at an
instant that can be computed; the integrator is led exactly there. Other relations of
time alone (`sin(time) > 0`) are found like those of the states.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from sys import float_info

from msgspec import Struct

from planarc.core.diagnostic import Diagnostic
from planarc.core.source import Span
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.program import Let, Program
from planarc.solve.messages.event import sampling
from planarc.solve.messages.text import Reader

#: Instants nearer to each other than that many last digits, or than so many seconds, are one:
#: what follows from parameters and what an integrator finds agree no better.
DIGITS, SAME = 256, 1e-14
#: More ticks than this of one sampler take no run to its end.
MOST_TICKS = 1e9


class Sampler(Struct):
    slot: int
    start: float
    interval: float
    span: Span
    fired: int = 0

    def next(self) -> float:
        return self.start + self.fired * self.interval


class Schedule:
    """`switches`: relation -> (instant, truth from then on)."""

    def __init__(self, program: Program, kernel: Kernel, start: float) -> None:
        read = Reader(program, kernel, start)
        self.samplers = [
            Sampler(slot, float(read(first)), float(read(interval)), span)
            for slot, first, interval, span in program.samplers
        ]
        for sampler in self.samplers:
            if sampler.interval > 0 and sampler.start < start:
                passed = (start - sampler.start) / sampler.interval
                sampler.fired = max(0, math.ceil(passed - room(passed)))
        self.switches: dict[int, tuple[float, bool]] = {}
        for i, zero in time_functions(program, kernel, start).items():
            found = _linear_zero(zero)
            if found is not None and found[0] > start:
                self.switches[i] = found

    def judge(self, start: float, stop: float) -> Iterator[Diagnostic]:
        """What is wrong with samplers: no ticks at all, or more than a run can take."""
        for sampler in self.samplers:
            ticks = (stop - start) / sampler.interval if sampler.interval > 0 else 0.0
            between = sampler.interval > room(max(abs(start), abs(stop)))
            if sampler.interval <= 0 or ticks > MOST_TICKS or (ticks >= 1 and not between):
                yield sampling(sampler.span, sampler.start, sampler.interval, ticks)

    def next(self, after: float) -> float:
        """The first instant that lies after a time."""
        times = [s.next() for s in self.samplers if s.interval > 0]
        times += [t for t, _ in self.switches.values()]
        later = (t for t in times if t > after and not same(t, after))
        return min(later, default=math.inf)

    def switching(self, t: float) -> dict[int, bool]:
        return {i: truth for i, (at, truth) in self.switches.items() if same(at, t)}

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
    return max(SAME, DIGITS * float_info.epsilon * abs(t))


def same(a: float, b: float) -> bool:
    return a == b or abs(a - b) <= room(min(abs(a), abs(b)))


_Values = Mapping[Expr, Expr]


def time_functions(program: Program, kernel: Kernel, start: float) -> dict[int, TimeFunction]:
    """The zero functions of the relations of time alone."""
    lets = {s.target: s.value for s in program.roots if isinstance(s, Let)}
    return {
        i: TimeFunction(program, kernel, relation.zero, lets)
        for i, relation in enumerate(program.relations)
        if relation.time_only
    }


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
        below = (lets[e],) if e in lets else (e,)
        stack.extend(
            (leaf, False)
            for leaf in postorder(below)
            if leaf.op is Op.SYMBOL and leaf in lets and leaf is not e
        )
    return order


def _linear_zero(zero: TimeFunction) -> tuple[float, bool] | None:
    """The zero of a function linear in time, and whether it is below zero afterwards.

    Far from zero the slope is known to few digits: what is left there is taken off again.
    """
    g = [zero(t) for t in (0.0, 1.0, 2.0)]
    if g[0] is None or g[1] is None or g[2] is None:
        return None
    slope = g[1] - g[0]
    bend = abs(g[2] - 2 * g[1] + g[0])
    if slope == 0 or bend > 1e-12 * max(abs(v) for v in g if v is not None):
        return None
    at = -g[0] / slope
    for _ in range(3):
        rest = zero(at)
        at -= rest / slope if rest else 0.0
    return at, slope < 0
