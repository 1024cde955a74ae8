"""Newton's method for a few equations, from guesses that may be far away.

In:   a function of n unknowns with m residuals (m may be less or more than n)
Out:  Root    the point reached, its residuals, and whether they vanish

Steps are those of least norm, so that unknowns which nothing determines stay where
they are, and are limited in length, so that the branch nearest to the guess is
found and an angle does not turn round; but not where the equations are linear on the
way, as in a torque of which nothing but a filter knows. A step that does not reduce the residuals
is halved; where that fails, damping as in Levenberg and Marquardt takes over.

The function gives None where it cannot be evaluated; such a point is stepped back from.

Reference: J. E. Dennis, R. B. Schnabel, Numerical Methods for Unconstrained
           Optimization and Nonlinear Equations, 1996, chapters 6 and 10.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from planarc.core.data import Data
from planarc.ir.newton import (
    DIFFERENCE,
    ENOUGH,
    LESS,
    LONGEST,
    MOST_HALVINGS,
    SMALL,
    SMALLEST_ROW,
    STRAIGHT,
)
from planarc.runtime.differences import one_sided

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

    #: A function; it may have a method `slopes` for its Jacobian, and `root` for its root near a
    #: guess where that is found without search.
    Residuals: TypeAlias = Callable[[Vector], Vector | None]
    Slopes: TypeAlias = Callable[[Vector], Vector | None]
    Straight: TypeAlias = Callable[[Vector], "Root | None"]

#: Singular values below this part of the largest count as zero.
RANK = 1e-9


class Root(Data):
    point: Vector
    residuals: Vector
    converged: bool


def derivative(f: Residuals, z: Vector, r: Vector) -> Vector | None:
    """The Jacobian, as the function's own `slopes` tell it, or by differences; None where
    there is none."""
    slopes: Slopes | None = getattr(f, "slopes", None)
    return differences(f, z, r) if slopes is None else slopes(z)


def differences(f: Residuals, z: Vector, r: Vector) -> Vector | None:
    """The Jacobian with errors of 1e-8; None where f has no value near z."""
    return one_sided(f, z, [DIFFERENCE * max(1.0, abs(v)) for v in z], r, either=True)


def kernel_of(jacobian: Vector, part: float) -> Vector:
    """An orthonormal basis, in columns, of what changes no row; singular values below this
    part of the largest count as zero."""
    import numpy as np

    _, sizes, directions = np.linalg.svd(level_rows(jacobian)[0])
    least = part * max(1e-300, float(sizes[0])) if len(sizes) else 0.0
    basis: Vector = directions[sum(s > least for s in sizes.tolist()) :].T
    return basis


def level_rows(jacobian: Vector) -> tuple[Vector, Vector]:
    """Rows of large numbers, as those of a stiff force, made comparable with lengths."""
    scale = _at_least(1.0, _row_sizes(jacobian))
    return jacobian / scale[:, None], scale


def _row_sizes(jacobian: Vector) -> Vector:
    sizes: Vector = abs(jacobian).max(axis=1, initial=0.0)
    return sizes


def solve(f: Residuals, guess: Vector, iterations: int = 60) -> Root:
    """The root that the function itself finds, or by `search`."""
    straight: Straight | None = getattr(f, "root", None)
    if straight is not None and (found := straight(guess)) is not None:
        return found
    return search(f, guess, iterations)


def search(f: Residuals, guess: Vector, iterations: int = 60) -> Root:
    """Newton with least-norm steps and a line search, then Levenberg and Marquardt."""
    import numpy as np

    r = f(guess)
    if r is None:  # perhaps a singular position: begin beside it
        guess = guess + 1e-3 * np.cos(1.0 + 2.0 * np.arange(len(guess)))
        r = f(guess)
    if r is None:
        return Root(guess, np.array([np.nan]), False)
    root = _newton(f, guess, r, iterations)
    if root.converged:
        return root
    damped = _levenberg_marquardt(f, guess, r, 3 * iterations)
    if not damped.converged:
        polished = _newton(f, damped.point, damped.residuals, iterations)
        damped = polished if _size(polished.residuals) <= _size(damped.residuals) else damped
    if damped.converged or _size(damped.residuals) < _size(root.residuals):
        return damped
    return root


def solve_near(f: Residuals, guess: Vector, iterations: int) -> Root:
    """Newton alone, for a guess that is near if it is any good."""
    import numpy as np

    r = f(guess)
    return Root(guess, np.array([np.nan]), False) if r is None else _newton(f, guess, r, iterations)


def _at_least(least: float, sizes: Vector) -> Any:
    """What `sizes.clip(least)` gives, sooner."""
    import numpy as np

    return np.maximum(sizes, least)


def _size(r: Vector) -> float:
    return math.sqrt(r @ r)


def _vanish(r: Vector, sizes: Vector) -> bool:
    """Whether residuals are zero but for rounding, measured by the rows that move them."""
    return bool((abs(r) <= SMALL * _at_least(SMALLEST_ROW, sizes)).all())


def _newton(f: Residuals, z: Vector, r: Vector, iterations: int) -> Root:
    import numpy as np

    if not r.any():
        return Root(z, r, True)
    converged = False
    for _ in range(iterations):
        jacobian = derivative(f, z, r)
        if jacobian is None:
            break
        sizes = _row_sizes(jacobian)
        if not math.isfinite(sizes.sum()):
            break
        small = _vanish(r, sizes)
        if len(z) == 0:
            return Root(z, r, small)
        scale = _at_least(1.0, sizes)
        step: Vector = np.linalg.lstsq(jacobian / scale[:, None], -r / scale, rcond=RANK)[0]
        longest = float(abs(step).max())
        if longest > LONGEST and not _straight(f, z, r, step):
            step *= LONGEST / longest
        following = _line_search(f, z, r, step, 1 if small else MOST_HALVINGS)
        if following is None:
            return Root(z, r, small)
        z, r = following
        converged = small or _vanish(r, sizes)
        # One step more than needed: quadratic convergence makes it exact to rounding.
        if not r.any() or (small and longest < ENOUGH):
            break
    return Root(z, r, converged)


def _straight(f: Residuals, z: Vector, r: Vector, step: Vector) -> bool:
    """Whether a whole step leads to the root at once, so that no branch can be missed."""
    beyond = f(z + step)
    return beyond is not None and _size(beyond) < STRAIGHT * _size(r)


def _line_search(
    f: Residuals, z: Vector, r: Vector, step: Vector, tries: int
) -> tuple[Vector, Vector] | None:
    """A part of the step that reduces the residuals."""
    size, part = _size(r), 1.0
    for _ in range(tries):
        trial = z + part * step
        value = f(trial)
        if value is not None and _size(value) < (1 - (1 - LESS) * part) * size:
            return trial, value
        part *= 0.5
    return None


def _levenberg_marquardt(f: Residuals, z: Vector, r: Vector, iterations: int) -> Root:
    import numpy as np

    damping, jacobian = 1e-3, derivative(f, z, r)
    if jacobian is None or len(z) == 0:
        return Root(z, r, False)
    for _ in range(iterations):
        gradient = jacobian.T @ r
        hessian = jacobian.T @ jacobian
        diagonal = np.maximum(np.diag(hessian), 1e-8 * max(1e-300, float(np.trace(hessian))))
        step = np.linalg.lstsq(hessian + damping * np.diag(diagonal), -gradient, rcond=None)[0]
        longest = float(np.max(np.abs(step)))
        if longest > LONGEST:
            step *= LONGEST / longest
        value = f(z + step)
        if value is not None and _size(value) < _size(r):
            z, r = z + step, value
            damping = max(damping / 5, 1e-14)
            jacobian = derivative(f, z, r)
            if jacobian is None:
                return Root(z, r, False)
            if _vanish(r, _row_sizes(jacobian)):
                return _newton(f, z, r, 5)
        else:
            damping *= 4
            if damping > 1e12:
                break
        if longest < 1e-14:
            break
    return Root(z, r, _vanish(r, _row_sizes(jacobian)))
