"""Outlines as polygons.

In:   an Outline, the length of its unit in m, a tolerance in m
Out:  Polygon    its corners in m, counter-clockwise, on the curves; the sides are no further from
                 the curves than the tolerance. Corners that repeat or lie on a line are left out.

A curve of n equal steps of its parameter is off by at most |at''|/(8*n^2).

Example: a circle of 10 mm, to a tenth: 23 corners.
"""

from __future__ import annotations

from math import ceil, sqrt
from typing import TYPE_CHECKING

import numpy as np

from planarc.catalog.outline.piece import Outline
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, UsageError

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: Without a tolerance: this part of the larger side.
PART = 1e-3
#: What is smaller than this part of the larger side is nothing.
NOTHING = 1e-9


class Polygon(Data):
    corners: Vector  # a row a corner
    tolerance: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height."""
        width, height = np.ptp(self.corners, axis=0).tolist()
        return width, height

    @property
    def area(self) -> float:
        return _area(self.corners @ np.array([1, 1j]))

    @property
    def centre(self) -> tuple[float, float]:
        """The centre of the area."""
        here = self.corners - self.corners[0]
        there = np.roll(here, -1, axis=0)
        cross = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
        x, y = ((here + there) * cross[:, None]).sum(axis=0) / (3 * cross.sum()) + self.corners[0]
        return float(x), float(y)


def polygon(outline: Outline, metre: float, tolerance: float | None) -> Polygon:
    """Raises UsageError C174 for an open outline, C175 for one that crosses itself, C172 for one
    without an area."""
    if not outline.closed:
        raise _open(outline, metre)
    rough = _cut(outline, 0.0)
    if tolerance is None:
        tolerance = PART * metre * _side(rough)
    z = metre * (_cut(outline, tolerance / metre) if tolerance > 0 else rough)
    z = _plain(z, NOTHING * _side(z))
    if len(z) < 3 or _flat(z):
        raise _refused(outline, "C172", "has no area", "draw a closed outline around one")
    if (crossing := _crossing(z)) is not None:
        place = f"at ({crossing.real:.6g}, {crossing.imag:.6g}) m"
        hint = "draw it so that its sides meet at its corners only"
        raise _refused(outline, "C175", f"crosses or touches itself {place}", hint)
    if _area(z) < 0:
        z = z[::-1]
    return Polygon(np.stack([z.real, z.imag], axis=1), tolerance)


def hollow(shape: Polygon, outline: Outline) -> Diagnostic | None:
    """A warning about the first corner that is hollow: a contour `Polygon` takes none."""
    z = shape.corners @ np.array([1, 1j])
    turn = ((z - np.roll(z, 1)).conjugate() * (np.roll(z, -1) - z)).imag
    found = np.flatnonzero(turn < -NOTHING * 2 * shape.area)
    if not len(found):
        return None
    x, y = shape.corners[found[0]]
    message = f"corner {found[0] + 1} of the outline, at ({x:.6g}, {y:.6g}) m, is hollow"
    hint = "split it before it becomes a `Contacts.Polygon`, which has no hollows"
    return Diagnostic("C176", message, outline.span, Severity.WARNING, hint)


def extent(outline: Outline) -> float:
    """The larger side of an outline, in the units of its drawing."""
    return _side(_cut(outline, 0.0))


def _cut(outline: Outline, tolerance: float) -> Vector:
    """Points along an outline; a few of each curve where the tolerance is 0."""
    points = []
    for piece in outline.pieces:
        fine = 8 if piece.bend > 0 else 1
        n = fine if tolerance == 0 else max(1, ceil(sqrt(piece.bend / (8 * tolerance))))
        points += [piece.at(i / n) for i in range(n)]
    return np.array([*points, outline.pieces[-1].at(1.0)])


def _side(z: Vector) -> float:
    return float(max(np.ptp(z.real), np.ptp(z.imag)))


def _area(z: Vector) -> float:
    z = z - z[0]
    return float((z.conjugate() * np.roll(z, -1)).imag.sum() / 2)


def _flat(z: Vector) -> bool:
    """True where all corners lie on one line."""
    a, b = z[0], z[np.argmax(np.abs(z - z[0]))]
    return bool(np.abs(_beside(a, b - a, z)).max() <= NOTHING * _side(z))


def _plain(z: Vector, nothing: float) -> Vector:
    """Without corners that repeat, or lie on the line through their neighbours."""
    z = z[np.abs(z - np.roll(z, 1)) > nothing]
    kept: list[complex] = []
    for i, corner in enumerate(z.tolist()):
        before, after = kept[-1] if kept else z[i - 1], z[(i + 1) % len(z)]
        along = after - before
        off = abs(((corner - before) * along.conjugate()).imag)
        forward = ((corner - before).conjugate() * (after - corner)).real > 0
        if off > nothing * abs(along) or not forward:
            kept.append(corner)
    return np.array(kept)


def _crossing(z: Vector) -> complex | None:
    """A place where two sides that are no neighbours meet, or neighbours lie on each other."""
    n, nothing = len(z), NOTHING * _side(z)
    ends = np.roll(z, -1)
    for i in range(n):
        a, along = z[i], ends[i] - z[i]
        back = ends[(i + 1) % n] - ends[i]
        turned = along.conjugate() * back
        if abs(turned.imag) <= nothing * abs(along) and turned.real < 0:
            return complex(ends[i])
        others = np.arange(i + 2, n - (i == 0))
        if not len(others):
            continue
        b, c = _beside(a, along, z[others]), _beside(a, along, ends[others])
        close = np.minimum(np.abs(b), np.abs(c)) <= nothing
        for j in others[(b * c < 0) | close]:
            place = _meeting(a, along, z[j], ends[j] - z[j], nothing)
            if place is not None:
                return place
    return None


def _beside(a: complex, along: complex, z: Array) -> Vector:
    """How far points lie to the left of a line."""
    found: Vector = (np.conj(along) * (z - a)).imag / abs(along)
    return found


def _meeting(a: complex, u: complex, b: complex, v: complex, nothing: float) -> complex | None:
    """Where the sides a + s*u and b + t*v meet, s and t from 0 to 1."""
    for corner, start, way in ((b, a, u), (b + v, a, u), (a, b, v), (a + u, b, v)):
        s = ((corner - start) * way.conjugate()).real / abs(way) ** 2
        if abs(start + min(max(s, 0.0), 1.0) * way - corner) <= nothing:
            return complex(corner)
    across = (u.conjugate() * v).imag
    if across == 0:
        return None
    s = ((b - a).conjugate() * v).imag / across
    t = ((b - a).conjugate() * u).imag / across
    return complex(a + s * u) if 0 <= s <= 1 and 0 <= t <= 1 else None


def _open(outline: Outline, metre: float) -> PlanarcError:
    a, b = (metre * z for z in (outline.pieces[0].at(0.0), outline.pieces[-1].at(1.0)))
    ends = f"its ends ({a.real:.6g}, {a.imag:.6g}) m and ({b.real:.6g}, {b.imag:.6g}) m"
    said = f"is open: {ends} are {abs(b - a):.3g} m apart"
    return _refused(outline, "C174", said, "close it in the drawing")


def _refused(outline: Outline, code: str, said: str, hint: str) -> PlanarcError:
    named = f"the outline `{outline.name}`" if outline.name else "the outline"
    return UsageError(Diagnostic(code, f"{named} {said}", outline.span, hint=hint))
