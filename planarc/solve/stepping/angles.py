"""Sine and cosine by operations that have the same bits on every processor and in every language.

A heap of bodies magnifies the last digit, and functions of libraries differ in it: so runs, and the
same model in an FMU on another system or in a browser, would part from each other. The angle is
brought to within pi/4 of a multiple k of pi/2, and series follow; exact to the last digit or two as
long as k stays below 2^20.

Reference: W. J. Cody, W. Waite, Software Manual for the Elementary Functions, Prentice-Hall 1980,
           chapter 8; coefficients of the series: FDLIBM 5.3, k_sin.c and k_cos.c.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Turns by a quarter in a radian; a quarter in parts, of which k times the first two are exact.
QUARTERS = 0.6366197723675814
PARTS = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21)
#: A number to which another one is added to be rounded.
ROUNDER = 1.5 * 2.0**52
#: Coefficients by rising powers of the square of the angle: sin x = x + x^3*(...), cos x = 1 -
#: x^2/2 + x^4*(...).
SINE = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
    2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
COSINE = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
    -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip
_BOTH = np.array([SINE, COSINE])


def sine_and_cosine(angles: Vector) -> tuple[Vector, Vector]:
    """Of angles in radian."""
    k = angles * QUARTERS + ROUNDER - ROUNDER
    x = angles
    for part in PARTS:
        x = x - k * part
    z = x * x
    across, along = _series(z, _BOTH)
    sine, cosine = x + x * z * across, 1.0 - (z * 0.5 - z * z * along)
    quarter = k.astype(np.int64) & 3
    odd, back = (quarter & 1) == 1, np.where(quarter >= 2, -1.0, 1.0)
    return np.where(odd, cosine, sine) * back, np.where(odd, -sine, cosine) * back


def _series(z: Vector, rows: Vector) -> Vector:
    """One series a row, by its coefficients."""
    total: Vector = rows[:, -1:]
    for k in range(rows.shape[1] - 2, -1, -1):
        total = total * z + rows[:, k : k + 1]
    return total
