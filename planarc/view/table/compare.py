"""Two results side by side: which variables leave the tube around the reference.

In:   Table, Table   the reference A and another result B, of any times
Out:  Comparison     for each variable that parts: when first, and by how much at most

The tube around a curve of A is what a rectangle covers that slides along it: as high as
a share of the variable's range, as wide as a share of the time. So a step that B takes a
little later is no difference, nor is a number that differs a little. A variable that ought to be
zero has rounding for its range, and so has one that ought to stay what it is: no tube is
thinner than an absolute height, or than the rounding of its curve's values.

Example: A = sin(t), B = sin(t) + 0.1*(t > 2), tolerance 0.01

    parted = (Parting(name="x", time=2.01, a=0.905, b=1.005, most=0.1, most_time=2.5),)

Values of B count in the unit that A has them in, where both tell their units.

Promises:  values that are no numbers agree with each other and with nothing else.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.quantity import scale
from planarc.core.unit import parse
from planarc.view.table.table import Table

#: Share of a curve's value that is rounding, whatever its range.
_ROUNDING = 1e-12


class Parting(Data):
    """A variable that leaves its tube."""

    name: str
    time: float  # s, where it leaves first
    a: float
    b: float
    most: float  # the greatest distance from the tube
    most_time: float


class Comparison(Data):
    compared: int  # variables that are in both
    parted: tuple[Parting, ...]  # in the order in which they part
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    ends: tuple[float, float] | None  # s, where they end, if not at the same time
    apart: tuple[tuple[str, str, str], ...] = ()  # names with units that are no common measure
    meet: bool = True  # whether they have any time in common

    @property
    def same(self) -> bool:
        return not self.parted and not self.apart and self.ends is None


def compare_tables(
    a: Table,
    b: Table,
    tolerance: float,
    width: float,
    only: re.Pattern[str] | None = None,
    absolute: float = 0.0,
) -> Comparison:
    """Compare two tables. `tolerance` is a share of a variable's range, `width` of that of time;
    values that are `absolute` apart, in the variable's own unit, agree."""
    names_a = [n for n in a.columns if only is None or only.search(n)]
    names_b = [n for n in b.columns if only is None or only.search(n)]
    known = set(names_b)
    both = [n for n in names_a if n in known]
    apart = _without_measure(a, b, both)
    common = [n for n in both if n not in {name for name, *_ in apart}]
    tube = _Tube(a.time, b.time, width)
    found = (tube.parting(n, a[n], _in_units_of(a, b, n), tolerance, absolute) for n in common)
    parted = [p for p in found if p is not None]
    held = set(both)
    return Comparison(
        len(common),
        tuple(sorted(parted, key=lambda p: p.time)),
        tuple(n for n in names_a if n not in held),
        tuple(n for n in names_b if n not in held),
        tube.ends,
        apart,
        len(tube.rows) > 0,
    )


def _units(a: Table, b: Table, name: str) -> tuple[str, str] | None:
    """The units of a variable in both tables, where they are told and differ."""
    here, there = a.units.get(name, ""), b.units.get(name, "")
    return (here, there) if here and there and here != there else None


def _without_measure(a: Table, b: Table, names: Sequence[str]) -> tuple[tuple[str, str, str], ...]:
    """The names, with both units, of variables whose units have no common measure."""
    told = ((n, units) for n in names if (units := _units(a, b, n)) is not None)
    return tuple(
        (n, *units)
        for n, units in told
        if parse(units[0]) is None or parse(units[0]) != parse(units[1])
    )


def _in_units_of(a: Table, b: Table, name: str) -> Vector:
    """B's values of a variable, in A's unit."""
    units = _units(a, b, name)
    if units is None:
        return b[name]
    (here, low), (there, zero) = map(scale, units)
    return (b[name] * there + (zero - low)) / here


class _Tube:
    """The windows in time that are the same for all variables."""

    def __init__(self, a: Vector, b: Vector, width: float) -> None:
        length = float(a[-1] - a[0]) if len(a) else 0.0
        slack = 1e-9 * max(length, 1e-300)
        half = max(width * length, slack)
        self.a = a
        self.ends = None
        if len(a) and len(b) and abs(a[-1] - b[-1]) > half:
            self.ends = (float(a[-1]), float(b[-1]))
        elif (len(a) == 0) != (len(b) == 0):
            self.ends = (float(a[-1]) if len(a) else 0.0, float(b[-1]) if len(b) else 0.0)
        within = (b >= a[0] - half) & (b <= a[-1] + half) if len(a) else np.zeros(len(b), bool)
        self.rows = np.flatnonzero(within)
        self.time = b[self.rows]
        self.left, self.right = self.time - half, self.time + half
        first = np.searchsorted(a, self.left, "left")
        self.windows = np.stack([first, np.searchsorted(a, self.right, "right")], axis=1)

    def parting(
        self, name: str, a: Vector, b: Vector, tolerance: float, absolute: float
    ) -> Parting | None:
        """The place where B's values leave the tube around A's."""
        if len(self.rows) == 0:
            return None
        values = b[self.rows]
        finite = a[np.isfinite(a)]
        size = float(np.ptp(finite)) if len(finite) else 0.0
        value = float(np.max(np.abs(finite))) if len(finite) else 0.0
        # A curve without range is measured by its value, and zero by one.
        size = size or value or 1.0
        height = max(tolerance * size, absolute, _ROUNDING * value)
        low, high = self._bounds(a)
        with np.errstate(invalid="ignore"):
            off = np.maximum(np.maximum(low - values, values - high) - height, 0.0)
        off = np.where(np.isnan(off), 0.0, off)  # infinity less itself
        here = np.interp(self.time, self.a, a)
        none = np.isnan(values)
        off = np.where(none != np.isnan(here), np.inf, off)
        outside = np.flatnonzero(off > _ROUNDING * size)
        if len(outside) == 0:
            return None
        first, worst = int(outside[0]), int(np.argmax(off))
        return Parting(
            name,
            float(self.time[first]),
            float(here[first]),
            float(values[first]),
            float(off[worst] + height),
            float(self.time[worst]),
        )

    def _bounds(self, a: Vector) -> tuple[Vector, Vector]:
        """The least and the greatest value of A's curve in each window."""
        edges = np.stack([np.interp(t, self.a, a) for t in (self.left, self.time, self.right)])
        low, high = np.fmin.reduce(edges), np.fmax.reduce(edges)
        filled = np.flatnonzero(self.windows[:, 1] > self.windows[:, 0])
        if len(filled):
            # `reduceat` takes pairs of borders; a border past the end needs one more value.
            borders = self.windows[filled].ravel()
            padded = np.append(a, a[-1])
            low[filled] = np.fmin(low[filled], np.fmin.reduceat(padded, borders)[::2])
            high[filled] = np.fmax(high[filled], np.fmax.reduceat(padded, borders)[::2])
        return low, high
