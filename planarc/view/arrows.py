"""Arrows that components draw themselves: forces and torques to one scale each.

In:   items, Result
Out:  items, their arrows no longer than a share of the mechanism; Scale   of each unit

A force says with `N_to_m`, a torque with `Nm_to_m`, what value it would draw 1 m long. Where the
largest of the run is then far too long or too short, or two say different things, all of one unit
get one new scale. What is round-off beside the largest is left out.

Example: a thrust of at most 500 N on a mechanism 2 m wide

    Scale(unit="N", metres=0.001, color=FORCE)   # the longest is 0.5 m, a quarter
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.insight import Track
from planarc.ir.result import Result
from planarc.view.box import bounds
from planarc.view.item import Item, Kind

ARROWS = (Kind.ARROW, Kind.DOUBLE_ARROW)
#: The parameter that says what is drawn 1 m long, and its unit.
_SAID = {Kind.ARROW: ("N_to_m", "N"), Kind.DOUBLE_ARROW: ("Nm_to_m", "N.m")}
#: The longest arrow as a share of the size of all else; what is shorter or longer than may be.
_LONGEST, _TOO_SHORT, _TOO_LONG = 0.25, 0.03, 0.6
#: The share of the largest that is round-off, and what is always.
_NEGLIGIBLE, _ROUND_OFF = 1e-9, 1e-12


class Scale(Data):
    """How long arrows of a unit are: `metres` for a value of 1; `owners` draw them."""

    unit: str
    metres: float
    color: tuple[Track, Track, Track]
    owners: tuple[str, ...]

    def changed(self, item: Item, metres: float) -> Item:
        """An item to another scale, if it is one of these arrows."""
        if item.component not in self.owners or item.kind not in ARROWS:
            return item
        return replace(item, length=item.length * (metres / self.metres))


def scaled(
    items: Sequence[Item], result: Result, notes: list[str]
) -> tuple[list[Item], tuple[Scale, ...]]:
    """The items with their arrows to scale; what is not drawn as it says is noted."""
    size = _size(items)
    drawn = list(items)
    scales = []
    for kind, (parameter, unit) in _SAID.items():
        own = {
            n: factor
            for n, item in enumerate(drawn)
            if item.kind is kind and (factor := _said(item, parameter, result)) > 0
        }
        values = {n: _longest(drawn[n]) * factor for n, factor in own.items()}
        largest = max(values.values(), default=0.0)
        if not size or largest <= _ROUND_OFF:
            continue
        seen = {n: f for n, f in own.items() if values[n] > _NEGLIGIBLE * largest}
        metres = _metres(set(seen.values()), largest, size)
        for n, factor in seen.items():
            if metres * factor != 1.0:
                drawn[n] = replace(drawn[n], length=drawn[n].length * (metres * factor))
        if any(metres * factor != 1.0 for factor in seen.values()):
            notes.append(f"arrows are drawn 1 m long for {1 / metres:.3g} {unit}")
        owners = tuple(drawn[n].component for n in seen)
        scales.append(Scale(unit, metres, drawn[next(iter(seen))].color, owners))
        drawn = [item for n, item in enumerate(drawn) if n in seen or n not in own]
    return [_shortened(item, size, notes) for item in drawn], tuple(scales)


def _said(item: Item, parameter: str, result: Result) -> float:
    """What the owner of an arrow would draw 1 m long; 0 where it does not say."""
    name = f"{item.component.rpartition('.')[0]}.{parameter}"
    if name not in result:
        return 0.0
    value = np.asarray(result.track(name))
    return float(value) if value.ndim == 0 else float(value[0])


def _metres(factors: set[float], largest: float, size: float) -> float:
    """The one scale of all: what they say, or the largest at a quarter of the size."""
    factor = next(iter(factors))
    if len(factors) == 1 and _TOO_SHORT * size <= largest / factor <= _TOO_LONG * size:
        return 1.0 / factor
    return _LONGEST * size / largest


def _longest(item: Item) -> float:
    lengths = np.abs(np.asarray(item.length))
    return float(np.max(lengths, where=np.isfinite(lengths), initial=0.0))


def _size(items: Sequence[Item]) -> float:
    """The larger side of the box around everything but arrows; 0 where there is nothing."""
    box = bounds([item for item in items if item.kind not in ARROWS])
    return 0.0 if box is None else max(box[2] - box[0], box[3] - box[1])


def _shortened(item: Item, size: float, notes: list[str]) -> Item:
    """An arrow that would make the mechanism small is drawn to another scale."""
    if item.kind not in ARROWS or not size or (longest := _longest(item)) <= _TOO_LONG * size:
        return item
    factor = float(f"{_LONGEST * size / longest:.1g}")
    notes.append(f"the arrow `{item.component}` is drawn {factor:g} times as long as it says")
    return replace(item, length=item.length * factor)
