"""A mechanism made by hand, all of whose places follow from formulas."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

TIME = np.linspace(0.0, 4.0, 401)


@pytest.fixture
def swing(
    table: Any, result_of: Callable[..., Any], shape_of: Callable[..., Any], visual_of: Any
) -> Any:
    """A rod around the origin at the angle sin(t), a pin at its end, a spring to the pin.

    The pin is red, the rod grey. The spring grows from (-1, 0); an arrow is there at t < 2 only.
    """
    s = table.symbol
    angle = np.sin(TIME)
    x, y = np.cos(angle), np.sin(angle)
    columns = {
        "phi": angle,
        "x": x,
        "y": y,
        "reach": np.hypot(x + 1, y),
        "lean": np.arctan2(y, x + 1),
        "push": np.where(TIME < 2, 0.3, np.nan),
        "pin.r[1]": x,
        "pin.r[2]": y,
    }
    rod = shape_of(
        table, "rod", shapeType="beam", phi=s("phi"), length=1.0, width=0.1,
        color=(120.0, 120.0, 120.0),
    )  # fmt: skip
    pin = shape_of(
        table, "pin", shapeType="cylinder", r=(s("x"), s("y")), zDirection=True, width=0.2,
        length=0.1, color=(214.0, 40.0, 40.0), heightShift=1.0,
    )  # fmt: skip
    spring = shape_of(
        table, "spring", shapeType="spring", r=(-1.0, 0.0), phi=s("lean"), length=s("reach"),
        width=0.1, extra=4.0, color=(44.0, 140.0, 80.0), heightShift=-1.0,
    )  # fmt: skip
    arrow = visual_of(
        table, "push", "arrow", r=(0.0, 0.0), phi=0.0, r_tail=(0.0, 0.0),
        r_head=(s("push"), 0.0), width=0.02, heightShift=2.0, color=(0.0, 0.0, 200.0),
    )  # fmt: skip
    return result_of(table, TIME, columns, (rod, pin, spring, arrow), "Swing")
