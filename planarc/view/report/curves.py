"""Which variables the page shows as curves, when nobody said so.

Shown at once are the coordinates of the joints; at hand are their velocities and the variables
that the model itself declares. A model without joints shows where its bodies are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planarc.ir.program import Column
    from planarc.ir.result import Result

#: The page stays small: no more curves than this.
LIMIT = 48

_DEGREES = 180 / pi


@dataclass(frozen=True, slots=True)
class Curve:
    """A variable to draw: value*scale in `unit`."""

    name: str
    unit: str
    scale: float
    description: str
    shown: bool


def choose_curves(result: Result, names: tuple[str, ...] | None = None) -> tuple[Curve, ...]:
    """The curves of a page: `names` (all shown; KeyError if one is unknown), or by rule."""
    if names is not None:
        return tuple(_curve(result.columns[name], shown=True) for name in names)
    found: dict[str, bool] = {}
    for name, shown in _candidates(result):
        column = result.columns.get(name)
        if column is not None and not column.constant:
            found.setdefault(name, shown)
    if found and not any(found.values()):
        found[next(iter(found))] = True
    return tuple(_curve(result.columns[n], s) for n, s in list(found.items())[:LIMIT])


def _candidates(result: Result) -> Iterator[tuple[str, bool]]:
    parts = [(p.name, p.class_name) for p in result.program.parts]
    joints = [name for name, kind in parts if ".Joints." in kind]
    for coordinates, shown in ((("phi", "s"), True), (("w", "v"), False)):
        for joint in joints:
            for coordinate in coordinates:
                yield f"{joint}.{coordinate}", shown
    if not joints:
        for body in (name for name, kind in parts if kind.endswith((".Body", ".PointMass"))):
            for coordinate in ("r[1]", "r[2]", "phi"):
                yield f"{body}.{coordinate}", True
    for column in result.program.columns:
        if "." not in column.name and not column.protected:
            yield column.name, False


def _curve(column: Column, shown: bool) -> Curve:
    """Angles are shown in degrees where the library says so."""
    degrees = column.unit == "rad" and column.display_unit == "deg"
    return Curve(
        column.name,
        "deg" if degrees else column.unit,
        _DEGREES if degrees else 1.0,
        column.description,
        shown,
    )
