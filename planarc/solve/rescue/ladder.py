"""Ways to a root for a system of equations where plain Newton steps from the guess find none.

In:   Function   residuals and slopes of as many equations as unknowns; the guess
Out:  Found      one after the other: a root, and the way that led there

    line search     Newton's steps, cut until they lessen the residuals
    beside          the same from points beside the guess: the slope of x^2 is 0 at x = 0
    least squares   a trust region, for slopes that are nearly singular
    apart           the same as beside, from further and further away
    homotopy        from f(x) = f(guess), or from x = guess, to f(x) = 0 along the curve
                    between, also where it turns back (pseudo-arclength)

Of roots that one way finds, the nearest to the guess comes first. Whoever asks tries a root
where it is needed, and asks for the next one where it does not serve.

Example: x^2 = 9 from x = 0: line search finds a slope of 0, beside gives 3.

Reference: E. L. Allgower, K. Georg, Introduction to Numerical Continuation Methods,
           2003, chapters 2 and 11.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Protocol, TypeAlias

from planarc.core.data import Data

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

    Residuals: TypeAlias = Callable[[Vector], Vector | None]

#: Lengths of the moves away from the guess, beside it and apart, relative to max(1, |x|).
BESIDE, APART = (1e-3, 0.1), (1.0, 10.0, 100.0)
#: Directions of these moves: a constant part and a part that changes sign.
DIRECTIONS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
#: Largest step of a root, relative to its largest unknown, in the unknowns' own measure.
CONVERGED = 1e-9
#: Distance, relative likewise, below which two roots are one.
SAME = 1e-6
#: Distance of a root beyond which others are looked for first.
FAR = 3.0
#: Steps of Newton's method, halvings of one, steps along a curve.
STEPS, HALVINGS, ALONG = 60, 40, 300
#: Number of unknowns above which curves are not followed.
LARGEST = 60


class Function(Protocol):
    def __call__(self, x: Vector) -> Vector | None:
        """The residuals; None where one of them is not finite."""

    def slopes(self, x: Vector) -> Vector | None:
        """Their derivatives, a row for each residual."""


Way: TypeAlias = "Callable[[Function, Vector], Iterator[list[Vector]]]"


class Found(Data):
    point: Vector
    way: str


def climb(f: Function, guess: Vector) -> Iterator[Found]:
    """Roots, those of the gentlest way first; the ones that lie far away come last."""
    known: list[Vector] = []
    far: list[tuple[float, Found]] = []
    for way, roots in WAYS.items():
        for group in roots(f, guess):
            for root in sorted(group, key=lambda x: distance(x, guess)):
                if all(distance(root, x) > SAME for x in known):
                    known.append(root)
                    found, way_off = Found(root, way), distance(root, guess)
                    if way_off > FAR:
                        far.append((way_off, found))
                    else:
                        yield found
    yield from (found for _, found in sorted(far, key=lambda pair: pair[0]))


def distance(x: Vector, y: Vector) -> float:
    return float(abs((x - y) / abs(y).clip(1.0)).max())


# Ways -----------------------------------------------------------------------------------


def _directly(f: Function, guess: Vector) -> Iterator[list[Vector]]:
    yield _from(f, (guess,))


def _from(f: Function, guesses: Iterable[Vector]) -> list[Vector]:
    return [x for guess in guesses if (x := newton(f, guess)) is not None]


def _around(guess: Vector, length: float) -> list[Vector]:
    """The points so far from the guess."""
    import numpy as np

    signs = np.cos(np.pi * np.arange(len(guess)))
    size = length * abs(guess).clip(1.0)
    return [guess + size * (a + b * signs) for a, b in DIRECTIONS]


def _moved(lengths: tuple[float, ...]) -> Way:
    def roots(f: Function, guess: Vector) -> Iterator[list[Vector]]:
        for length in lengths:
            yield _from(f, _around(guess, length))

    return roots


def moved(guess: Vector) -> Iterator[tuple[str, list[Vector]]]:
    """The points beside a guess, then those apart, by the words that tell of them."""
    for way, lengths in ((_BESIDE, BESIDE), (_APART, APART)):
        for length in lengths:
            yield way, _around(guess, length)


def _least_squares(f: Function, guess: Vector) -> Iterator[list[Vector]]:
    import numpy as np
    from scipy.optimize import least_squares

    slopes = f.slopes(guess)
    if f(guess) is None or slopes is None:
        return
    sizes = _row_sizes(slopes)
    nothing = np.full(len(guess), np.nan)

    def scaled(x: Vector) -> Vector:
        r = f(x)
        return nothing if r is None else r / sizes

    def tilted(x: Vector) -> Vector:
        found = f.slopes(x)
        return np.zeros_like(slopes) if found is None else found / sizes[:, None]

    best = least_squares(scaled, guess, tilted, x_scale="jac", max_nfev=4 * STEPS)
    yield _from(f, (best.x,))


def _along(f: Function, guess: Vector) -> Iterator[list[Vector]]:
    """Newton's homotopy and that of the fixed point."""
    here, slopes = f(guess), f.slopes(guess)
    if here is None or slopes is None or len(guess) > LARGEST:
        return
    sizes = _row_sizes(slopes)
    for fixed in (False, True):
        end = follow(f, guess, here, sizes, fixed)
        yield [] if end is None else _from(f, (end,))


_BESIDE, _APART = "a guess beside the start", "a guess apart from the start"
#: By the words that tell of them.
WAYS: dict[str, Way] = {
    "a line search": _directly,
    _BESIDE: _moved(BESIDE),
    "least squares": _least_squares,
    _APART: _moved(APART),
    "a homotopy": _along,
}


# Newton's method ------------------------------------------------------------------------


def newton(f: Function, x: Vector) -> Vector | None:
    """A root by steps that lessen the residuals."""
    import numpy as np

    r = f(x)
    for _ in range(STEPS):
        slopes = None if r is None else f.slopes(x)
        if r is None or slopes is None:
            return None
        sizes = _row_sizes(slopes)
        step: Vector = np.asarray(
            np.linalg.lstsq(slopes / sizes[:, None], -r / sizes, rcond=1e-14)[0], float
        )
        small = _is_small(slopes, step, x)
        following = _shortened(f, x, step, sizes, float(np.linalg.norm(r / sizes)))
        if following is None:
            return x if small and _vanish(r, slopes, x) else None
        x, r = following
        if small and _vanish(r, slopes, x):
            return x
    # A root where slopes vanish too is never reached: each step goes a part of the way.
    return x if (abs(step) <= SAME * abs(x).clip(1.0)).all() else None


def _shortened(
    f: Function, x: Vector, step: Vector, sizes: Vector, size: float
) -> tuple[Vector, Vector] | None:
    import numpy as np

    if size == 0.0:
        return None
    part = 1.0
    for _ in range(HALVINGS):
        moved = x + part * step
        r = f(moved)
        if r is not None and np.linalg.norm(r / sizes) < (1 - 1e-4 * part) * size:
            return moved, r
        part *= 0.5
    return None


def _row_sizes(slopes: Vector) -> Vector:
    sizes: Vector = abs(slopes).max(axis=1, initial=0.0)
    sizes[sizes == 0.0] = 1.0
    return sizes


def _terms(slopes: Vector, x: Vector) -> Vector:
    """The largest term of each equation, or what an unknown of 1e-20 makes."""
    terms: Vector = abs(slopes * x).max(axis=1, initial=0.0)
    return terms.clip(1e-20 * _row_sizes(slopes))


def _is_small(slopes: Vector, step: Vector, x: Vector) -> bool:
    """Whether a step is small beside each unknown, or beside the terms of each equation."""
    changes = abs(slopes * step) <= CONVERGED * _terms(slopes, x)[:, None]
    return bool((changes.all(axis=0) | (abs(step) <= CONVERGED * abs(x))).all())


def _vanish(r: Vector, slopes: Vector, x: Vector) -> bool:
    """Whether residuals are small beside the terms of their equations."""
    return bool((abs(r) <= 1e3 * CONVERGED * _terms(slopes, x)).all())


# Curves ---------------------------------------------------------------------------------


def follow(f: Function, start: Vector, here: Vector, sizes: Vector, fixed: bool) -> Vector | None:
    """Where the curve of (x, way) that begins at (start, 0) has way = 1.

    0 = f(x) - (1 - way)*f(start), or for a fixed point way*f(x) + (1 - way)*(x - start).
    """
    import numpy as np

    scale = abs(start).clip(1.0)

    def value(z: Vector) -> Vector | None:
        r = f(start + scale * z[:-1])
        if r is None:
            return None
        way = z[-1]
        point = way * r / sizes + (1 - way) * z[:-1] if fixed else (r - (1 - way) * here) / sizes
        return np.asarray(point)

    def slopes(z: Vector) -> Vector | None:
        x, way = start + scale * z[:-1], z[-1]
        r, found = f(x), f.slopes(x)
        if r is None or found is None:
            return None
        inner = found * scale / sizes[:, None]
        if fixed:
            return np.column_stack([way * inner + (1 - way) * np.eye(len(x)), r / sizes - z[:-1]])
        return np.column_stack([inner, here / sizes])

    end = _arc(value, slopes, np.zeros(len(start) + 1))
    return None if end is None else start + scale * end[:-1]


def _arc(value: Residuals, slopes: Residuals, z: Vector) -> Vector | None:
    """The first point with last number 1 on the curve value(z) = 0, which begins at z."""
    import numpy as np

    ahead = np.zeros_like(z)
    ahead[-1] = 1.0
    length = 0.05
    for _ in range(ALONG):
        here = slopes(z)
        if here is None:
            return None
        tangent = np.linalg.svd(here)[2][-1]
        tangent = tangent if tangent @ ahead >= 0 else -tangent
        corrected = _back(value, slopes, z + length * tangent)
        if corrected is None or np.linalg.norm(corrected - z) > 2 * length:
            length *= 0.4
            if length < 1e-9:
                return None
            continue
        if corrected[-1] >= 1.0:
            part = (1.0 - z[-1]) / (corrected[-1] - z[-1])
            end: Vector = z + part * (corrected - z)
            return end
        ahead, z, length = corrected - z, corrected, min(1.5 * length, 10.0)
    return None


def _back(value: Residuals, slopes: Residuals, z: Vector) -> Vector | None:
    """A point of the curve near z."""
    import numpy as np

    for _ in range(6):
        r, here = value(z), slopes(z)
        if r is None or here is None:
            return None
        step = np.linalg.lstsq(here, -r, rcond=None)[0]
        z = z + step
        if np.linalg.norm(step) < 1e-7 * (1.0 + np.linalg.norm(z)):
            return z
    return None
