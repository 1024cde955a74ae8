"""Delayed signals in a run: their past is gathered, and their jumps come back on time.

In:   Program, Kernel (parameters set), its `history`
Out:  `Delays`   what the run tells at its start, at every step, at events

On every step each signal is interpolated through its values at six points of the step,
so that the past is as accurate as the integrator's own dense output; where that does not meet a
seventh, as of a sine of the time in a long step, through those of its halves. Steps are no longer
than the shortest delay, so the past is always complete; only a delay that changes may ask
for what lies ahead of it, and gets the tangent. A signal that changes at events only bounds
no step: what lies ahead of its past, up to the next kink, is its last value.

A *kink* is an instant at which signals may jump: the start, and events. It comes back when
each delay has passed. The integrator is led there and restarts, and what it lost of its
smoothness goes on to the next delay, one order smoother each time.

Reference: A. Bellen, M. Zennaro, Numerical Methods for Delay Differential Equations,
           Oxford University Press 2003, sections 2.2 (breaking points) and 3.2.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, PlanarcError, error
from planarc.ir.kernel import Kernel
from planarc.ir.program import DelayCode, Program
from planarc.runtime.history import DEGREE
from planarc.solve.events.instants import room, same
from planarc.solve.messages.text import Reader

if TYPE_CHECKING:
    from planarc.solve.solvers.integrator import Integrator

#: Times that a kink is followed, one order smoother each time.
GENERATIONS = 4
#: Longest step where a delay changes while running, as a part of the run.
LONGEST_STEP = 1 / 500
#: A start is found when the delayed values change by less than this part of their size.
SETTLED = 1e-12
#: Steps before a longer one become part of its piece where they are shorter than this part of
#: it: derivatives of short pieces would be rounding errors.
NEGLIGIBLE = 0.08
#: Times that a step is halved at most where a signal swings within it; where on it polynomials are
#: checked, between points that they go through; how near they come, as a part of the tolerance.
HALVINGS, CHECKED, ACCURACY = 10, 0.22, 0.1
#: Part of its size by which a delay time may leave its limits.
ROUNDING = 1e-12
#: Part of its size by which a value jumps, and is not only inaccurate.
JUMP = 1e-9


class _Piece:
    """Signals at the times of a part of a step, and the polynomials through them."""

    def __init__(self, times: Sequence[float], values: Sequence[Sequence[float]]) -> None:
        self.times, self.values = times, values

    @cached_property
    def terms(self) -> list[list[float]]:
        return _fitted(self.times, self.values)

    def says(self, there: Sequence[float], accuracy: float) -> bool:
        """Whether they have these values at the time that is checked."""
        found = (sum(c * CHECKED**k for k, c in enumerate(row)) for row in self.terms)
        return all(_near(a, b, accuracy) for a, b in zip(found, there, strict=True))


class Delays:
    """The delays of one run. Raises R461 for a delay time that is not positive."""

    def __init__(
        self, program: Program, kernel: Kernel, start: float, span: float, tolerance: float
    ) -> None:
        self.present = bool(program.delays)
        self._kernel, self._codes, self._span = kernel, program.delays, span
        self._history, self._all_held = kernel.history, all(d.held for d in program.delays)
        self._intervals, self._most = list[float | None](), list[float]()
        self._longest, self._accuracy = 0.0, ACCURACY * tolerance
        if self.present:
            read = Reader(program, kernel, start)
            self._intervals = [_interval(d, read) for d in program.delays]
            self._most = [
                math.inf if d.maximum is None else float(read(d.maximum)) for d in program.delays
            ]
            lengths = zip(self._intervals, self._most, strict=True)
            self._longest = max(m if i is None else i for i, m in lengths)
        #: of each delay: kinks that have not come back yet, with their generation
        self._ahead: list[deque[tuple[float, int]]] = [deque() for _ in program.delays]
        self._last: list[float] = [0.0] * len(program.delays)
        self._halved = False  # whether the last step was
        self._resumed = start  # the signals are smooth from here on
        self._rounds: list[list[float]] = []
        self.trouble: Diagnostic | None = None  # why the run cannot go on

    @property
    def longest_step(self) -> float:
        """The longest step that the integrator may make."""
        lengths = zip(self._codes, self._intervals, strict=True)
        steps = [
            self._span * LONGEST_STEP if i is None else i
            for d, i in lengths
            if i is None or not d.held
        ]
        return min(steps, default=math.inf)

    # The start

    def begin(self, t: float) -> None:
        """Begin the past, before start values are solved for."""
        if not self.present:
            return
        self._history.start(t, self._last)
        self._free()

    def settle_start(self, t: float) -> bool:
        """Give every signal before the start its value at the start: true when that was not
        so yet, so that the start must be solved for once more."""
        if not self.present:
            return False
        values, before = self._signals(), self._last
        if all(_near(a, b, SETTLED) for a, b in zip(values, before, strict=True)):
            return False
        self._rounds.append(values)
        if len(self._rounds) == 3:  # Aitken's extrapolation: at once where it is linear
            values = [_limit(*found) for found in zip(*self._rounds, strict=True)]
            self._rounds.clear()
        self._last = values
        self._history.start(t, values)
        return True

    def _free(self) -> None:
        self._history.bounds[:] = type(self._history.bounds)(
            "d", [-math.inf, math.inf] * len(self._codes)
        )

    # On the way

    def take(self, stepper: Integrator, begin: float) -> bool:
        """The step from `begin` to where the stepper is becomes past; false where the
        equations could not be solved on it, or a delay is out of its range."""
        end = stepper.t
        if not end > begin:
            return True
        pieces = self._pieces(stepper, begin, self._last, end, 0 if self._all_held else HALVINGS)
        if not pieces:
            return False
        # What was halved says more than a longer piece would.
        most = 0.0 if self._halved else NEGLIGIBLE * (pieces[0].times[-1] - begin)
        self._halved = len(pieces) > 1
        from_, values = self._history.merge(max(self._resumed, begin - most), begin, self._last)
        if from_ != begin:
            pieces[0] = _Piece([from_, *pieces[0].times[1:]], [values, *pieces[0].values[1:]])
        for piece in pieces:
            last = piece.values[-1]
            held = [[v, *(0.0,) * DEGREE] for v in last] if self._all_held else None
            self._history.append(piece.times[0], piece.times[-1], held or piece.terms)
            self._last = list(last)
        self._history.forget(begin - self._longest)  # rows of the step are still to be taken
        return self._in_range(end)

    def _pieces(
        self, stepper: Integrator, begin: float, before: Sequence[float], end: float, halvings: int
    ) -> list[_Piece]:
        """The signals of a part of the step, halved where one polynomial does not say them; nothing
        where the equations could not be solved. The workspace is that of its end."""
        inner = () if self._all_held else _inner_points()
        times, values = [begin], [before]
        checked = (CHECKED,) if halvings else ()
        for t in (*(begin + x * (end - begin) for x in (*inner, *checked)), end):
            y = stepper.y if t == stepper.t else stepper.interpolate(t)
            if self._kernel.outputs(t, y) != 0:
                return []
            times.append(t)
            values.append(self._signals())
        if not halvings:
            return [_Piece(times, values)]
        there = values.pop(-2)
        times.pop(-2)
        whole, middle = _Piece(times, values), begin + (end - begin) / 2
        if not begin < middle < end or whole.says(there, self._accuracy):
            return [whole]
        left = self._pieces(stepper, begin, before, middle, halvings - 1)
        if not left:
            return []
        right = self._pieces(stepper, middle, left[-1].values[-1], end, halvings - 1)
        return [*left, *right] if right else []

    def _in_range(self, t: float) -> bool:
        for d, most in zip(self._codes, self._most, strict=True):
            if d.interval_slot is None:
                continue
            interval = self._kernel.w[d.interval_slot]
            if not -ROUNDING <= interval <= most * (1 + ROUNDING):
                self.trouble = Diagnostic(
                    "R462",
                    f"the delay time of `{d.text}` is {interval:.6g} s at t = {t:.6g} s, which"
                    f" is not between 0 and {most:.6g} s",
                    d.span,
                    hint="limit the second argument, or enlarge the third",
                )
                return False
        return True

    def _signals(self) -> list[float]:
        w = self._kernel.w
        return [d.sign * float(w[d.slot]) for d in self._codes]

    def resume(self, t: float) -> None:
        """The workspace holds the values from which the next step begins."""
        self._last, self._resumed = self._signals(), t

    # Kinks

    def next(self, after: float) -> float:
        """The next instant at which a kink comes back."""
        found = math.inf
        for interval, ahead in zip(self._intervals, self._ahead, strict=True):
            if interval is not None and ahead:
                found = min(found, ahead[0][0] + interval)
        return found if found > after else math.inf

    def kink(self, t: float, generation: int = 0) -> None:
        """Signals may jump here, or lose their smoothness, which held ones do not have."""
        if generation < GENERATIONS:
            for d, interval, ahead in zip(self._codes, self._intervals, self._ahead, strict=True):
                if interval is not None and not (d.held and generation):
                    ahead.append((t, generation))

    def cross(self, t: float) -> int | None:
        """Make the past right behind `t` count from here on; the generation of the kinks that
        come back now, if any do."""
        found: int | None = None
        if not self.present:
            return found
        within = 2 * room(t)
        for i, (interval, ahead) in enumerate(zip(self._intervals, self._ahead, strict=True)):
            if interval is None:
                continue
            while ahead and (same(ahead[0][0] + interval, t) or ahead[0][0] + interval < t):
                _, generation = ahead.popleft()
                found = generation if found is None else min(found, generation)
            self._history.bounds[2 * i] = t - interval + within
            self._history.bounds[2 * i + 1] = ahead[0][0] - within if ahead else math.inf
        return found

    def values(self, t: float) -> list[float]:
        """The present values of the delays of fixed time."""
        return [
            self._history.value(i, 0, t - interval)
            for i, interval in enumerate(self._intervals)
            if interval is not None
        ]

    def texts(self, chosen: Sequence[int]) -> tuple[str, ...]:
        """The user's text of some of `values`."""
        fixed = [d for d in self._codes if d.interval_slot is None]
        return tuple(fixed[i].text for i in chosen)


def jumped(before: Sequence[float], after: Sequence[float]) -> list[int]:
    """Which values are others now."""
    return [i for i, (a, b) in enumerate(zip(before, after, strict=True)) if not _near(a, b, JUMP)]


def not_settled(program: Program) -> PlanarcError:
    first = program.delays[0]
    return error(
        "R463",
        f"no start was found at which `{first.text}` is the value at the start itself",
        first.span,
        hint="give start values that do not depend on what is delayed",
    )


def _interval(d: DelayCode, read: Reader) -> float | None:
    if d.interval_slot is not None:
        return None
    interval = float(read(d.interval))
    if not 0 < interval < math.inf:
        raise error(
            "R461",
            f"the delay time of `{d.text}` is {interval:.6g} s",
            d.span,
            hint="give a delay time above zero",
        )
    return interval


def _near(a: float, b: float, part: float) -> bool:
    return abs(a - b) <= part * max(1.0, abs(a), abs(b))


def _limit(a: float, b: float, c: float) -> float:
    """The limit of a sequence whose steps shrink, or grow, by one factor."""
    bend = (c - b) - (b - a)
    return c if _near(c, b, 1e-14) or bend == 0 else c - (c - b) ** 2 / bend


@cache
def _inner_points() -> tuple[float, ...]:
    """Chebyshev's points of a step from 0 to 1, without its ends."""
    return tuple((1 - math.cos(math.pi * k / DEGREE)) / 2 for k in range(1, DEGREE))


def _fitted(times: Sequence[float], values: Sequence[Sequence[float]]) -> list[list[float]]:
    """The polynomials through values at the times of a piece, which begins with the first."""
    import numpy as np

    ends = np.zeros((len(times), len(values[0])))
    ends[0], ends[1] = values[0], np.subtract(values[-1], values[0])
    x = (np.array(times) - times[0]) / (times[-1] - times[0])
    try:
        terms = np.linalg.solve(np.vander(x, increasing=True), values)
    except np.linalg.LinAlgError:  # a step so short that its inner points coincide
        terms = ends
    found: list[list[float]] = terms.T.tolist()
    return found
