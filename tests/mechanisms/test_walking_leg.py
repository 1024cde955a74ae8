"""The leg of the README: its points lie where circles about the others meet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import planarc

EXAMPLE = Path(__file__).parents[2] / "examples" / "walking_leg.pmo"


def meet(p: Any, r: float, q: Any, s: float, side: int) -> Any:
    """Where circles about p and q meet: to the left (1) or right (-1) of the way from p to q."""
    way = q - p
    d = np.hypot(*way)
    along = (r * r - s * s + d * d) / (2 * d)
    e = way / d
    return p + along * e + side * np.sqrt(r * r - along * along) * np.array([-e[1], e[0]])


def test_the_foot_is_where_the_lengths_say() -> None:
    result = planarc.load(EXAMPLE).simulate()
    t = result.time
    hip = np.array([[-0.38], [-0.078]]) * np.ones_like(t)
    pin = 0.15 * np.array([np.cos(np.pi / 2 * t), -np.sin(np.pi / 2 * t)])
    top, low = meet(pin, 0.5, hip, 0.415, -1), meet(pin, 0.619, hip, 0.393, 1)
    back = meet(hip, np.hypot(0.0261, 0.40015), top, np.hypot(0.415 - 0.0261, 0.40015), 1)
    heel = meet(back, 0.394, low, 0.367, -1)
    sole = meet(heel, np.hypot(0.367 + 0.0775, 0.4838), low, np.hypot(0.0775, 0.4838), -1)
    for i in (0, 1):
        np.testing.assert_allclose(result[f"sole.frame_b.r[{i + 1}]"], sole[i], atol=1e-5)


def test_it_walks() -> None:
    """Over a third of the turn the foot stays within a centimetre of the ground."""
    result = planarc.load(EXAMPLE).simulate()
    x, y = result["sole.frame_b.r[1]"], result["sole.frame_b.r[2]"]
    down = y < y.min() + 0.01
    assert np.mean(down) > 1 / 3
    assert np.ptp(x[down]) > 0.4
    assert np.ptp(y) > 0.15
