"""Find a four-bar whose coupler point passes through given points.

    python examples/coupler_curve.py

The crank of examples/four_bar.pmo is driven once around; the coupler's centre of mass draws
a closed curve. scipy changes lengths and the place of that point until the curve goes through
five points. The model is compiled once; each try is a run of a few milliseconds.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import planarc
from planarc import Model, PlanarcError

#: Points that the curve is to pass, in metres.
WANTED = np.array([[0.50, 0.74], [0.10, 0.68], [-0.12, 0.34], [0.05, 0.20], [0.44, 0.52]])

#: What may change: names of parameters, and their values at first.
FREE = {"crank.r[1]": 0.4, "coupler.r[1]": 0.9, "rocker.r[1]": 0.8,
        "couplerBody.r_CM[1]": 0.45, "couplerBody.r_CM[2]": 0.1}  # fmt: skip

TURN = "1 + 2*3.141592653589793*time"


def curve(model: Model, values: np.ndarray) -> np.ndarray:
    """The coupler point over one turn of the crank, a row for each instant."""
    parameters = dict(zip(FREE, values.tolist(), strict=True))
    run = model.drive("revA.phi", TURN, stop_time=1, intervals=120, parameters=parameters)
    return np.column_stack([run["couplerBody.r_0CM[1]"], run["couplerBody.r_0CM[2]"]])


def misses(values: np.ndarray, model: Model) -> np.ndarray:
    """From each point to the nearest one of the curve, x and y; far, where it cannot turn."""
    try:
        points = curve(model, values)
    except PlanarcError:
        return np.ones(2 * len(WANTED))
    begin, along = points[:-1], np.diff(points, axis=0)
    away = WANTED[:, None, :] - begin[None, :, :]
    part = np.clip((away * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    offsets = part[:, :, None] * along - away
    nearest = np.argmin((offsets**2).sum(axis=2), axis=1)
    return offsets[np.arange(len(WANTED)), nearest].ravel()


def optimize(model: Model, evaluations: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Values found, and how far each point is missed at first and then."""
    first = np.array(list(FREE.values()))
    found = least_squares(
        misses, first, args=(model,), diff_step=1e-3, max_nfev=evaluations,
        bounds=(0.5 * first, 2 * first),
    )  # fmt: skip
    both = [misses(v, model).reshape(-1, 2) for v in (first, found.x)]
    return found.x, np.linalg.norm(both, axis=2)


if __name__ == "__main__":
    four_bar = planarc.load(Path(__file__).with_name("four_bar.pmo"))
    values, (before, after) = optimize(four_bar)
    for name, value in zip(FREE, values, strict=True):
        print(f"{name:22} {value:.4f} m")
    print(f"misses the points by {before.max():.3f} m at first, {after.max():.4f} m at last")
    assert math.isfinite(after.max())
