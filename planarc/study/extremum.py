"""The greatest value of a variable over a run, between the rows, too.

In:   Result (rows with the model that made them), the name of a variable
Out:  the value at its highest place

Around the highest rows the states are on polynomials that have the values and derivatives of the
rows and fulfil the equations between them; where none does, the motion is followed once more, from
row to row. The equations are solved at the highest place on the way. So a maximum depends smoothly
on parameters, which an optimiser asks for. Where that does not lead to the rows again, the rows
count alone. A model with delays remembers more than they tell: its states are followed on cubics
with the values and derivatives of the rows; of its other variables the rows count (`rows_alone`).

Example: of sin(t), rows at every 0.5 s give 0.997 at most; the maximum is 1.
Reference: R. P. Brent, Algorithms for Minimization without Derivatives, 1973, chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import copysign, inf, isclose, isfinite
from operator import itemgetter
from typing import TypeAlias

import numpy as np

from planarc.api.result import Result
from planarc.core.arrays import Vector
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program

#: Peaks that are looked at: between rows the highest may be another one.
_PEAKS = 3
#: Part of a row's interval to which a peak is found: its height is then known to the square of it.
_NEAR = 2e-4
#: Where a top beside an end is looked for, and parabolas at most.
_EDGE, _ROUNDS = 0.05, 8
#: A parabola's top this far from its middle row, in intervals, lies on that side for certain.
_ASIDE = 0.2
#: Steps between two rows, at most, and parts of the states to which these agree with half as many.
_STEPS, _EXACT = 64, 3e-6
#: Where the slopes of quintics are asked for, and where they then err as much as anywhere; the
#: slope of (s (1 - s))**2 (a + b s) is a / _SKEW / 2 and its opposite at the former, where b = 0.
_LEFT, _RIGHT, _BETWEEN, _SKEW = 0.5 - 12**-0.5, 0.5 + 12**-0.5, 0.36, 27**0.5 / 2
#: Slopes that err there to and fro by so much move a quintic by less than a part of 1.
_LOOSE = 10.0
#: Parts of the largest value to which a row is found again where it is, and from the row before.
_SAME, _NEARLY = 1e-6, 1e-3

#: States, and their derivatives times the length of a step.
_Node: TypeAlias = "tuple[list[float], list[float]]"
#: A variable over 0 to 1, and its values at 0 and 1.
_Curve: TypeAlias = "tuple[Callable[[float], float], float, float]"


def highest(result: Result, name: str) -> float:
    """The greatest value of a variable, not below that of any row."""
    return _highest(result, name, 1.0)


def lowest(result: Result, name: str) -> float:
    """The least value of a variable."""
    return -_highest(result, name, -1.0)


def _highest(result: Result, name: str, sign: float) -> float:
    values = sign * np.asarray(result[name])
    best = float(np.max(values))
    column = result.rows.columns.get(name)
    moves = column is not None and column.slot in result.rows.stored
    if not moves or len(values) < 3 or not np.isfinite(best):
        return best
    time, slopes = np.asarray(result.time), rises(result, name, sign)
    remembers = bool(result.rows.program.delays)
    between: Between | None = None
    for hope, k in _intervals(time, values, slopes):
        if hope < best:  # another peak is higher than this one can be
            continue
        if remembers:
            curve = None if slopes is None else _by_slopes(time, values, slopes, k)
        else:
            between = between or Between.of(result, name)
            curve = None if between is None else between.curve(k, sign)
        if curve is None:
            continue
        best = max(best, _climb(*curve))
    return best


def rows_alone(program: Program, name: str) -> bool:
    """Whether nothing is known of a variable between the rows: a past that they do not hold."""
    columns = {c.name: c for c in program.columns}
    if not program.delays or columns[name].constant:
        return False
    return all(
        c.slot != columns[name].slot or c.derivative not in {d.slot for d in program.columns}
        for c in program.candidates
    )


def _by_slopes(time: Vector, values: Vector, rises: Vector, k: int) -> _Curve | None:
    """A state between row `k` and the next, on the cubic with their values and derivatives."""
    h = float(time[k + 1] - time[k])
    if not h > 0:
        return None
    first, last = (([float(values[i])], [h * float(rises[i])]) for i in (k, k + 1))
    way = _cubics((first, last))
    return lambda s: way(s)[0], first[0][0], last[0][0]


def rises(result: Result, name: str, sign: float = 1.0) -> Vector | None:
    """The derivative of a variable at each row, where the rows hold it."""
    rows, column = result.rows, result.rows.columns.get(name)
    if column is None:
        return None
    for c in rows.program.candidates:
        if c.slot == column.slot and c.derivative in rows.stored:
            found: Vector = sign * column.sign * rows.data[:, rows.stored[c.derivative]]
            return found
    return None


def _intervals(time: Vector, values: Vector, rises: Vector | None) -> list[tuple[float, int]]:
    """The rows behind which the curve may be highest, the most promising first, each with a height
    that it hardly reaches: four times as far above the row as a parabola does."""
    inner = np.arange(1, len(values) - 1)
    tops = inner[(values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])].tolist()
    best, last = float(np.max(values)), len(values) - 1
    steep = float(np.max(np.abs(np.diff(values))))
    found = [(*_parabola(time, values, k), k) for k in tops if values[k] >= best - steep]
    found += [(best, 0.0, k) for k in (0, last) if values[k] == best]
    likely = sorted(found, reverse=True)[:_PEAKS]
    sides: dict[int, float] = {}
    for height, aside, k in likely:
        at_event = not time[max(k - 1, 0)] < time[k] < time[min(k + 1, last)]
        hope = inf if at_event else float(values[k]) + 4 * (height - float(values[k]))
        if rises is not None and not at_event:
            aside = copysign(1.0, float(rises[k]))
        for side in (k - 1,) if aside < -_ASIDE else (k,) if aside > _ASIDE else (k - 1, k):
            if 0 <= side < last:
                sides.setdefault(side, hope)
    return [(hope, k) for k, hope in sides.items()]


def _parabola(time: Vector, values: Vector, k: int) -> tuple[float, float]:
    """The height of the parabola through a row and its neighbours, and how many intervals its top
    lies behind the row."""
    (a, b, c), (x, y, z) = time[k - 1 : k + 2].tolist(), values[k - 1 : k + 2].tolist()
    if not a < b < c:  # at an event
        return y, 0.0
    left, right = (y - x) / (b - a), (z - y) / (c - b)
    bend = (right - left) / (c - a)
    if bend >= 0:
        return y, 0.0
    slope = (left * (c - b) + right * (b - a)) / (c - a)
    return y - slope * slope / (4 * bend), -slope / (2 * bend) / (c - b if slope > 0 else b - a)


def _climb(f: Callable[[float], float], first: float, last: float) -> float:
    """The greatest value within 0 to 1 of a curve with one top, from one parabola to the next, and
    from its values at 0 and 1."""
    points = [(0.0, first), (0.5, f(0.5)), (1.0, last)]
    for x in (_EDGE, 1 - _EDGE):  # the top may lie beside an end
        if max(points, key=itemgetter(1))[0] == round(x):
            points.append((x, f(x)))
    points.sort()
    for _ in range(_ROUNDS):
        k = max(range(len(points)), key=lambda i: points[i][1])
        if k in (0, len(points) - 1):
            break
        (a, x), (b, y), (c, z) = points[k - 1 : k + 2]
        left, right = (y - x) / (b - a), (z - y) / (c - b)
        if left == right or not isfinite(left - right):
            break
        top = b + (left * (c - b) + right * (b - a)) / (2 * (left - right))
        if abs(top - b) < _NEAR or not a < top < c:
            break
        points.append((top, f(top)))
        points.sort()
    return max(y for _, y in points)


def _cubics(nodes: Sequence[_Node]) -> Callable[[float], list[float]]:
    """The states over 0 to 1, on the cubics with the values and derivatives of equal steps."""
    last = len(nodes) - 2

    def states(s: float) -> list[float]:
        i = min(int(s * (last + 1)), last)
        s = s * (last + 1) - i
        q = 1 - s
        (at, rate), (then, rate_then) = nodes[i], nodes[i + 1]
        return [
            q * q * ((1 + 2 * s) * a + s * u) + s * s * ((1 + 2 * q) * b - q * v)
            for a, u, b, v in zip(at, rate, then, rate_then, strict=True)
        ]

    return states


def _are_small(values: Sequence[float], sizes: Sequence[float]) -> bool:
    return all(abs(v) <= size for v, size in zip(values, sizes, strict=True))


class _Quintic:
    """Polynomials with the values and derivatives of two nodes, at 0 and 1, and derivatives that
    are asked for at two places between: p(s) = cubic(s) + (s (1 - s))**2 (a + b s)."""

    def __init__(self, first: _Node, last: _Node) -> None:
        self._cubic = _cubics((first, last))
        self._ends = list(zip(*first, *last, strict=True))
        self._bends = [(0.0, 0.0)] * len(self._ends)

    def __call__(self, s: float) -> list[float]:
        bump = (s * (1 - s)) ** 2
        bends = zip(self._cubic(s), self._bends, strict=True)
        return [y + bump * (a + b * s) for y, (a, b) in bends]

    def slopes(self, s: float) -> list[float]:
        q = 1 - s
        return [
            6 * s * q * (y - x) + q * (1 - 3 * s) * u + s * (1 - 3 * q) * v
            + s * q * (2 * (q - s) * (a + b * s) + s * q * b)
            for (x, u, y, v), (a, b) in zip(self._ends, self._bends, strict=True)
        ]  # fmt: skip

    def mend(self, left: Sequence[float], right: Sequence[float]) -> None:
        """Add to the slopes at the two places."""
        self._bends = [
            (a + _SKEW * (e - f) + 9 * (e + f), b - 18 * (e + f))
            for (a, b), e, f in zip(self._bends, left, right, strict=True)
        ]


class Between:
    """The equations between the rows of a result."""

    def __init__(self, result: Result, kernel: Kernel, name: str) -> None:
        self._rows, self._kernel = result.rows, kernel
        self._column = result.rows.columns[name]
        self._program = result.rows.program
        self._place = result.rows.stored[self._column.slot]
        self._scale = float(np.max(np.abs(result.rows.data[:, self._place])))
        self._chosen: tuple[str, ...] = ()
        self._states: list[tuple[int, int]] = []  # columns of values and of derivatives
        slots = self._program.slots
        pairs = ((s, slots.get(n[4:-1])) for n, s in slots.items() if n.startswith("pre("))
        self._before = [(before, slot) for before, slot in pairs if slot is not None]

    @classmethod
    def of(cls, result: Result, name: str) -> Between | None:
        """None where the model is not at hand."""
        compiled = result.compiled
        if compiled is None:
            return None
        kernel = compiled.load()
        rows = result.rows
        for p in compiled.program.parameter_slots:
            if p.default is not None:
                kernel.w[p.slot] = p.default
        for slot, value in rows.constants.items():
            kernel.w[slot] = value
        if kernel.parameters() != 0:
            return None
        for slot, value in rows.constants.items():
            kernel.w[slot] = value
        return cls(result, kernel, name)

    def curve(self, k: int, sign: float) -> _Curve | None:
        """The variable between row `k` and the next; None where it is not known."""
        rows, kernel = self._rows, self._kernel
        if not 0 <= k < len(rows.time) - 1:
            return None
        begin, h = float(rows.time[k]), float(rows.time[k + 1] - rows.time[k])
        if not (h > 0 and self._take_states(begin)):
            return None
        first, last = rows.data[k].tolist(), rows.data[k + 1].tolist()
        for slot, i in rows.stored.items():
            kernel.w[slot] = first[i]
        for before, slot in self._before:
            kernel.w[before] = kernel.w[slot]
        kernel.accept(begin)
        ends = [
            ([row[i] for i, _ in self._states], [h * row[i] for _, i in self._states])
            for row in (first, last)
        ]
        (y, _), (end, _) = ends
        self._settle(begin + 0.5 * h, [(a + b) / 2 for a, b in zip(y, end, strict=True)])
        way = self._direct(begin, h, ends) or self._way(begin, h, y, end)
        if way is None:
            return None

        def value(s: float) -> float:
            if kernel.outputs(begin + s * h, way(s)) != 0:
                return -inf
            return sign * self._column.sign * float(kernel.w[self._column.slot])

        found = []
        for s, row, same in ((1.0, last, _NEARLY), (0.0, first, _SAME)):
            wanted = sign * self._column.sign * row[self._place]
            found.append(value(s))
            if not isclose(found[-1], wanted, rel_tol=0.0, abs_tol=same * self._scale):
                return None
        return value, found[1], found[0]

    def _direct(self, t: float, h: float, ends: Sequence[_Node]) -> _Quintic | None:
        """The states over 0 to 1 of an interval, from their ends alone."""
        way, rates = _Quintic(*ends), [0.0] * len(self._states)

        def defects(s: float) -> list[float] | None:
            if self._kernel.rhs(t + s * h, way(s), rates) != 0:
                return None
            return [h * a - b for a, b in zip(rates, way.slopes(s), strict=True)]

        sizes = [_EXACT * (abs(y) + abs(r) or 1.0) for y, r in zip(*ends[1], strict=True)]
        for _ in range(_ROUNDS):
            found = defects(_LEFT), defects(_RIGHT)
            if found[0] is None or found[1] is None:
                return None
            way.mend(found[0], found[1])
            if _are_small(found[0], sizes) and _are_small(found[1], sizes):
                last = defects(_BETWEEN)
                wide = [_LOOSE * size for size in sizes]
                return way if last is not None and _are_small(last, wide) else None
        return None

    def _way(
        self, t: float, h: float, y: list[float], end: list[float]
    ) -> Callable[[float], list[float]] | None:
        """The states over 0 to 1 of an interval, from as few steps as come to its `end`, or to the
        same place as half as many."""
        before, count = end, 2
        while count <= _STEPS:
            nodes = self._march(t, h, y, count)
            if nodes is None:
                return None
            there, rates = nodes[-1]
            if any(
                all(abs(a - b) <= _EXACT * (abs(a) + abs(r) or 1.0) for a, b, r in way)
                for way in (tuple(zip(there, other, rates, strict=True)) for other in (end, before))
            ):
                return _cubics(nodes)
            before, count = there, 2 * count
        return None

    def _march(self, t: float, h: float, y: list[float], count: int) -> list[_Node] | None:
        """Values and derivatives (times the step) after each of some steps of the classical method
        of Runge and Kutta; None where the equations have no solution."""
        step, kernel, size = h / count, self._kernel, len(y)
        nodes: list[_Node] = []
        for i in range(count + 1):
            at = t + i * step
            k = [[0.0] * size for _ in range(4)]
            if kernel.rhs(at, y, k[0]) != 0:
                return None
            kernel.accept(at)
            nodes.append((y, [step * v for v in k[0]]))
            if i == count:
                break
            for j, part in ((1, 0.5), (2, 0.5), (3, 1.0)):
                inner = [a + part * step * b for a, b in zip(y, k[j - 1], strict=True)]
                if kernel.rhs(at + part * step, inner, k[j]) != 0:
                    return None
            y = [
                a + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                for a, k1, k2, k3, k4 in zip(y, *k, strict=True)
            ]
        return nodes

    def _settle(self, t: float, y: list[float]) -> None:
        """Give relations the truth that they have within the interval."""
        relations, w = self._program.relations, self._kernel.w
        zeros = [0.0] * len(relations)
        if relations and self._kernel.roots(t, y, zeros) == 0:
            for relation, zero in zip(relations, zeros, strict=True):
                w[relation.slot] = float(zero < 0 or (zero == 0 and not relation.strict))

    def _take_states(self, t: float) -> bool:
        """Choose the states of a time; false where their values or derivatives are not stored."""
        choices = [c.states for c in self._rows.states if c.time <= t] or [()]
        if choices[-1] == self._chosen:
            return bool(self._states) or not self._program.state_count
        places = {c.display: i for i, c in enumerate(self._program.candidates)}
        if not all(n in places for n in choices[-1]):
            return False
        selection = [places[n] for n in choices[-1]]
        stored = self._rows.stored
        found = [self._program.candidates[i] for i in selection]
        if not all(c.slot in stored and c.derivative in stored for c in found):
            return False
        self._kernel.select(selection)
        self._chosen = choices[-1]
        self._states = [(stored[c.slot], stored[c.derivative]) for c in found]
        return True
