"""Results made by hand, so that scene and report are tested without a compiler."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from planarc.ir.dae import Kind, Visual
from planarc.ir.expr import Exprs
from planarc.ir.flat import Part
from planarc.ir.program import Column, Program
from planarc.ir.result import Result, Statistics

#: The parts of a program that drawing does not need.
EMPTY = (
    "parameter_slots",
    "candidates",
    "fixed",
    "discretes",
    "relations",
    "samplers",
    "whens",
    "assertions",
    "blocks",
    "parameters",
    "levels",
    "rest",
    "initial",
    "initial_residuals",
    "roots",
    "discrete",
    "equations",
)


def make_result(
    table: Exprs,
    time: Any,
    columns: Mapping[str, Any],
    visuals: tuple[Visual, ...] = (),
    name: str = "Test",
    parts: tuple[Part, ...] = (),
    units: Mapping[str, tuple[str, str]] = {},
    description: str = "",
) -> Result:
    """A result with these columns; a number stands for a constant."""
    moving = [n for n, v in columns.items() if not np.isscalar(v)]
    fixed = [n for n, v in columns.items() if np.isscalar(v)]
    slots = {n: i for i, n in enumerate([*moving, *fixed])}
    program = Program(
        name=name,
        table=table,
        size=len(slots),
        slots=slots,
        columns=tuple(
            Column(
                n,
                slots[n],
                1,
                Kind.REAL,
                *units.get(n, ("", ""))[:1],
                constant=n in fixed,
                display_unit=units.get(n, ("", ""))[1],
            )
            for n in columns
        ),
        **dict.fromkeys(EMPTY, ()),
        visuals=visuals,
        parts=parts,
        description=description,
    )
    return Result(
        program,
        np.asarray(time, dtype=float),
        np.column_stack([np.asarray(columns[n], dtype=float) for n in moving])
        if moving
        else np.empty((len(time), 0)),
        {slots[n]: i for i, n in enumerate(moving)},
        {slots[n]: float(columns[n]) for n in fixed},
        Statistics("none", "none"),
    )


def shape(table: Exprs, component: str, **attributes: Any) -> Visual:
    """A shape visual with the library's attributes and defaults; numbers become constants."""
    values: dict[str, Any] = {
        "shapeType": "box", "r": (0.0, 0.0), "phi": 0.0, "r_shape": (0.0, 0.0), "angle": 0.0,
        "length": 0.0, "width": 0.0, "zDirection": False, "heightShift": 0.0,
        "color": (31.0, 119.0, 180.0), "extra": 0.0,
    }  # fmt: skip
    values.update(attributes)
    return visual(table, component, "shape", **values)


def visual(table: Exprs, component: str, kind: str, **attributes: Any) -> Visual:
    def lowered(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(lowered(v) for v in value)
        return table.const(value) if isinstance(value, (bool, int, float)) else value

    return Visual(component, kind, tuple((n, lowered(v)) for n, v in attributes.items()))


@pytest.fixture
def table() -> Exprs:
    return Exprs()


@pytest.fixture
def result_of() -> Callable[..., Result]:
    return make_result


@pytest.fixture
def shape_of() -> Callable[..., Visual]:
    return shape


@pytest.fixture
def visual_of() -> Callable[..., Visual]:
    return visual
