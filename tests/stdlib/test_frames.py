"""Frames: rotations undo each other and keep lengths and products."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def test_rotations_undo_each_other(run: Callable[..., Any]) -> None:
    result = run(
        """
  Real v[2] = {1 + time, 2};
  Real there[2] = Frames.resolve1(3*time, v);
  Real back[2] = Frames.resolve2(3*time, there);
  Real relative[2] = Frames.resolveRelative(v, 3*time, time);
  Real onward[2] = Frames.resolve2(time, there);
  Real product[2] = Frames.rotationMatrix(3*time)*v;
  Real area = Frames.cross(v, {0.5, time});
  Real turned = Frames.cross(there, Frames.resolve1(3*time, {0.5, time}));
"""
    )
    t = result.time
    np.testing.assert_allclose(
        result["there[1]"], np.cos(3 * t) * (1 + t) - np.sin(3 * t) * 2, atol=1e-12
    )
    for i in (1, 2):
        np.testing.assert_allclose(result[f"back[{i}]"], result[f"v[{i}]"], atol=1e-12)
        np.testing.assert_allclose(result[f"relative[{i}]"], result[f"onward[{i}]"], atol=1e-12)
        np.testing.assert_allclose(result[f"product[{i}]"], result[f"there[{i}]"], atol=1e-12)
    np.testing.assert_allclose(result["area"], (1 + t) * t - 1, atol=1e-12)
    np.testing.assert_allclose(result["turned"], result["area"], atol=1e-12)
