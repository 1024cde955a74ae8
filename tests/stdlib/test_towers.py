"""Boxes dropped askew on boxes: they bounce, rock, slide and come to rest, and gain no energy."""

from __future__ import annotations

import random
from functools import cache
from typing import Any

import numpy as np
import pytest

import planarc

G, HALF = 9.81, 0.05
BOX = "Contacts.Polygon contour{}(vertices=[-0.1,-0.05; 0.1,-0.05; 0.1,0.05; -0.1,0.05])"


@cache
def tower(boxes: int, backend: str) -> planarc.Model:
    parts, joined = "", "equation\n"
    for i in range(1, boxes + 1):
        below = BOX.format(2) if i > 1 else "Contacts.HalfPlane contour2"
        lower = f"box[{i - 1}].frame_a" if i > 1 else "world.frame_b"
        contours = f"redeclare {BOX.format(1)}, redeclare {below}"
        parts += f"  Contacts.Contact c{i}({contours}, e=0.3, mu=0.5);\n"
        joined += f"  connect(box[{i}].frame_a, c{i}.frame_a);\n"
        joined += f"  connect({lower}, c{i}.frame_b);\n"
    head = "model Tower\n  import PlanarMultiBody.*;\n  inner World world;\n"
    bodies = f"  Parts.Body box[{boxes}](each m=1, each I={(0.2**2 + 0.1**2) / 12!r});\n"
    return planarc.load(head + bodies + parts + joined + "end Tower;\n", backend=backend)


def dropped(boxes: int, seed: int, backend: str) -> Any:
    """A run from places and angles that are drawn."""
    drawn, start, y = random.Random(seed), dict[str, float](), 0.0
    for i in range(1, boxes + 1):
        start[f"box[{i}].phi"] = drawn.uniform(-0.05, 0.05)
        start[f"box[{i}].r[1]"] = drawn.uniform(-0.02, 0.02)
        y += HALF + 0.012 + 0.02 * drawn.random()
        start[f"box[{i}].r[2]"] = y
        y += HALF
    return tower(boxes, backend).simulate(2, start=start)


@pytest.mark.usual
@pytest.mark.parametrize(
    ("boxes", "seed", "backend"),
    [*((2, seed, "native") for seed in range(8)), (2, 8, "numpy"), (3, 1, "native")],
)
def test_tower_comes_to_rest_and_gains_no_energy(boxes: int, seed: int, backend: str) -> None:
    result = dropped(boxes, seed, backend)
    energy = 0.0 * result.time
    for i in range(1, boxes + 1):
        speeds = [result[f"box[{i}].{v}"] for v in ("v[1]", "v[2]", "w")]
        for weight, v in zip((1, 1, (0.2**2 + 0.1**2) / 12), speeds, strict=True):
            energy = energy + weight * v**2 / 2
        energy = energy + G * result[f"box[{i}].r[2]"]
        assert max(abs(v[-1]) for v in speeds) < 1e-5
        assert result[f"box[{i}].r[2]"][-1] == pytest.approx((2 * i - 1) * HALF, abs=1e-6)
    assert np.diff(energy).max() < 1e-6
