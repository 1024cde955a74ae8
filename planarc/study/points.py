"""The points of a study: grids, and random samples of ranges.

A point is a value for each of some names; a name is a parameter (`rod.L`) or a start
value (`crank.phi.start`). All samples are the same every time for the same `seed`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

import numpy as np

from planarc.api.values import Value
from planarc.core.diagnostic import usage_error
from planarc.core.quantity import split
from planarc.core.unknown import telling_keywords

Point: TypeAlias = "Mapping[str, Value]"
Range: TypeAlias = "tuple[float | str, float | str]"


@telling_keywords
def grid(values: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Points with every combination of values; the last name changes fastest.

    Raises UsageError: C230 for values that are no sequence, C239 for none at all.
    """
    if not isinstance(values, Mapping):
        raise usage_error("C230", f"a grid takes values by name, not {type(values).__name__}")
    axes: list[list[Any]] = []
    for name, axis in values.items():
        if isinstance(axis, str | bytes) or not hasattr(axis, "__iter__"):
            hint = "write a list of values, or `numpy.linspace(0.1, 0.5, 9)`"
            message = f"`{name}` takes a sequence of values, not {axis!r:.40}"
            raise usage_error("C230", message, hint=hint)
        items = axis.tolist() if hasattr(axis, "tolist") else list(axis)
        if not items:
            raise usage_error("C239", f"`{name}` has no values")
        axes.append(items)
    return [dict(zip(values, point, strict=True)) for point in product(*axes)]


@telling_keywords
def random(ranges: Mapping[str, Range], count: int, seed: int = 0) -> list[dict[str, Any]]:
    """`count` points, independent and uniform within the ranges, the same for the same `seed`.

    A range is two numbers, or two texts of one unit as `("5cm", "9cm")`, of which the values are
    texts, too. Raises UsageError: C237 for a range that is none, C238 for a count below 1.
    """
    return _scaled(ranges, np.random.default_rng(seed).random((_count(count), len(ranges))))


@telling_keywords
def latin_hypercube(ranges: Mapping[str, Range], count: int, seed: int = 0) -> list[dict[str, Any]]:
    """`count` points, of which one lies in each of `count` slices of every range.

    They cover the ranges more evenly than independent ones. Raises UsageError as `random` does.
    """
    from scipy.stats import qmc

    return _scaled(ranges, qmc.LatinHypercube(len(ranges), rng=seed).random(_count(count)))


def _scaled(ranges: Mapping[str, Range], part: Any) -> list[dict[str, Any]]:
    bounds = [_range(name, given) for name, given in ranges.items()]
    return [
        {
            name: _with_unit(low + (high - low) * float(u), unit)
            for name, (low, high, unit), u in zip(ranges, bounds, row, strict=True)
        }
        for row in part
    ]


def _with_unit(value: float, unit: str) -> float | str:
    return f"{value!r} {unit}" if unit else value


def _range(name: str, given: Any) -> tuple[float, float, str]:
    """The ends of a range, and the unit that both of them tell."""
    try:
        (low, unit), (high, other) = map(_number, given)
    except (TypeError, ValueError):
        low, high, unit, other = math.nan, math.nan, "", ""
    if unit != other:
        message = f"the ends of the range of `{name}` have several units: {given!r:.40}"
        raise usage_error("C237", message, hint="give both of them in one unit")
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        raise usage_error(
            "C237", f"the range of `{name}` is two finite numbers, low and high: {given!r:.40}"
        )
    return low, high, unit


def _number(given: Any) -> tuple[float, str]:
    """A number and its unit, none where it is no text of a number with one. Raises ValueError."""
    number, unit = (split(given) if isinstance(given, str) else None) or (given, "")
    return float(number), unit


def _count(count: int) -> int:
    if not isinstance(count, int) or count < 1:
        raise usage_error("C238", f"the number of points is an integer above 0, not {count!r:.20}")
    return count
