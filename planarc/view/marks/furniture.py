"""What is no solid: bearings, arrows, frames, and what stands in a corner of the picture.

In:   labels, directions
Out:  Form   from the lowest to the highest
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from planarc.view.marks.forms import FAINT, HATCH, INK, ORIGIN, PLAIN, Form, Place, line, solid
from planarc.view.marks.measure import HEAD, PIXEL, SHAFT, THIN, ZERO, L, Measure, W


def ground() -> Iterator[Form]:
    """A bearing: a triangle under its point, on hatched ground."""
    base = -0.62 * L
    yield solid("line", ORIGIN, (0.36 * W, base), (-0.36 * W, base))
    yield line(((-0.55 * W, base), (0.55 * W, base)), ZERO, THIN, HATCH)
    for i in range(6):
        x = (0.2 * i - 0.5) * W
        yield line(((x, base), (x - 0.13 * W, base - 0.25 * L)), ZERO, 1.1, HATCH)


ALONG = (1.0, 0.0)


def arrow(along: tuple[float, float], heads: int) -> Iterator[Form]:
    """An arrow from the origin by L along a unit vector."""
    u, v = along

    def at(forward: Measure, left: Measure = ZERO) -> Place:
        return u * forward - v * left, v * forward + u * left

    yield line((ORIGIN, at(L - 0.8 * HEAD)), SHAFT, 0.0, PLAIN)
    for i in range(heads):
        tip = L - 0.8 * i * HEAD
        corners = at(tip), at(tip - HEAD, 0.36 * HEAD), at(tip - HEAD, -0.36 * HEAD)
        yield Form("line", corners, PLAIN)


def frame(labels: tuple[str, ...]) -> Iterator[Form]:
    for i, (u, v) in enumerate((ALONG, (0.0, 1.0))):
        yield from arrow((u, v), 1)
        reach = L + 10.0 * PIXEL
        if i < len(labels):
            place = (u * reach, v * reach)
            yield Form("label", (place,), PLAIN, radius=13.0 * PIXEL, text=labels[i])


def corner(labels: tuple[str, ...], down: tuple[tuple[float, float], ...]) -> Iterator[Form]:
    """Small axes, and beside them the way that things fall; all in pixels."""
    for label, (u, v) in zip(labels, (ALONG, (0.0, 1.0)), strict=False):
        yield from _pixels(((0.0, 0.0), (26.0 * u, 26.0 * v)))
        place = (35.0 * u * PIXEL, 35.0 * v * PIXEL)
        yield Form("label", (place,), FAINT, radius=12.0 * PIXEL, text=label)
    for u, v in down:
        x, y = (48.0, 20.0) if labels else (0.0, 20.0)
        start, end = (x - 11.0 * u, y - 11.0 * v), (x + 13.0 * u, y + 13.0 * v)
        yield from _pixels((start, end))
        place = ((x + 11.0 * abs(v)) * PIXEL, (y + 11.0 * abs(u)) * PIXEL)
        yield Form("label", (place,), FAINT, radius=12.0 * PIXEL, text="g")


def ruler(text: str) -> Iterator[Form]:
    """A length to measure by."""
    tick = 4.0 * PIXEL
    yield line(((ZERO, tick), ORIGIN, (L, ZERO), (L, tick)), ZERO, 1.3, FAINT)
    place = (0.5 * L, 10.0 * PIXEL)
    yield Form("label", (place,), FAINT, radius=12.0 * PIXEL, text=text)


def tag(text: str, places: tuple[tuple[float, float], ...]) -> Iterator[Form]:
    """A name at the first of the places, in pixels, and a thin line to the second one."""
    (x, y), *ends = places or ((0.0, 0.0),)
    for a, b in ends:
        yield line((ORIGIN, (a * PIXEL, b * PIXEL)), ZERO, 0.8, INK)
    yield Form("label", ((x * PIXEL, y * PIXEL),), INK, radius=12.0 * PIXEL, text=text)


def _pixels(ends: tuple[tuple[float, float], tuple[float, float]]) -> Iterator[Form]:
    """A thin arrow between two places in pixels."""
    (x, y), (a, b) = ends
    length = math.hypot(a - x, b - y)
    u, v = (a - x) / length, (b - y) / length
    path = ((x * PIXEL, y * PIXEL), (a * PIXEL, b * PIXEL))
    yield line(path, ZERO, 1.3, FAINT)
    back = [(a - 7.0 * u - s * v, b - 7.0 * v + s * u) for s in (2.8, -2.8)]
    corners = (path[1], *((p * PIXEL, q * PIXEL) for p, q in back))
    yield Form("line", corners, FAINT)
