"""Newton's method for a few equations, from guesses that may be far away.

In:   a function of n unknowns with m residuals (m may be less or more than n)
Out:  Root    the point reached, its residuals, and whether they vanish

Steps are those of least norm, so that unknowns which nothing determines stay where
they are, and are limited in length, so that the branch nearest to the guess is
found and an angle does not turn round. A step that does not reduce the residuals
is halved; where that fails, damping as in Levenberg and Marquardt takes over.

The function gives None where it cannot be evaluated; such a point is stepped back from.

Reference: J. E. Dennis, R. B. Schnabel, Numerical Methods for Unconstrained
           Optimization and Nonlinear Equations, 1996, chapters 6 and 10.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from planarc.core.data import Data

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector: TypeAlias = NDArray[np.float64]
    Residuals: TypeAlias = Callable[[Vector], Vector | None]

#: Longest change of an unknown in one step, in its own measure (radians, metres).
LONGEST = 0.5
#: Singular values below this part of the largest count as zero.
RANK = 1e-9
#: Residuals below this, times their size per unit of the unknowns, count as zero.
SMALL = 1e-10


class Root(Data):
    point: Vector
    residuals: Vector
    converged: bool


def derivative(f: Residuals, z: Vector, r: Vector) -> Vector | None:
    """The Jacobian by differences, with errors of 1e-8; None where f has no value near z."""
    import numpy as np

    jacobian = np.empty((len(r), len(z)))
    for j in range(len(z)):
        for h in (1.5e-8 * max(1.0, abs(z[j])), -1.5e-8 * max(1.0, abs(z[j]))):
            moved = z.copy()
            moved[j] = z[j] + h
            beside = f(moved)
            if beside is not None:
                jacobian[:, j] = (beside - r) / (moved[j] - z[j])
                break
        else:
            return None
    return jacobian


def level_rows(jacobian: Vector) -> tuple[Vector, Vector]:
    """Rows of large numbers, as those of a stiff force, made comparable with lengths."""
    import numpy as np

    scale = np.maximum(np.abs(jacobian).max(axis=1, initial=0.0), 1.0)
    return jacobian / scale[:, None], scale


def solve(f: Residuals, guess: Vector, iterations: int = 60) -> Root:
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


def _size(r: Vector) -> float:
    import numpy as np

    return float(np.sqrt(r @ r))


def _vanish(r: Vector, jacobian: Vector) -> bool:
    """Whether residuals are zero but for rounding, measured by what moves them."""
    import numpy as np

    scale = np.maximum(np.abs(jacobian).max(axis=1, initial=0.0), 1e-3)
    return bool(np.all(np.abs(r) <= SMALL * scale))


def _newton(f: Residuals, z: Vector, r: Vector, iterations: int) -> Root:
    import numpy as np

    if not len(r) or not np.any(r):
        return Root(z, r, True)
    converged = False
    for _ in range(iterations):
        jacobian = derivative(f, z, r)
        if jacobian is None or not np.all(np.isfinite(jacobian)):
            break
        if len(z) == 0:
            return Root(z, r, _vanish(r, jacobian))
        matrix, scale = level_rows(jacobian)
        step: Vector = np.linalg.lstsq(matrix, -r / scale, rcond=RANK)[0].astype(np.float64)
        longest = float(np.max(np.abs(step)))
        if longest > LONGEST:
            step *= LONGEST / longest
        small = _vanish(r, jacobian)
        following = _line_search(f, z, r, step)
        if following is None:
            return Root(z, r, small)
        z, r = following
        converged = small or _vanish(r, jacobian)
        # One step more than needed: quadratic convergence makes it exact to rounding.
        if not np.any(r) or (small and longest < 1e-9):
            break
    return Root(z, r, converged)


def _line_search(f: Residuals, z: Vector, r: Vector, step: Vector) -> tuple[Vector, Vector] | None:
    """A part of the step that reduces the residuals."""
    size, part = _size(r), 1.0
    for _ in range(25):
        trial = z + part * step
        value = f(trial)
        if value is not None and _size(value) < (1 - 1e-4 * part) * size:
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
            if _vanish(r, jacobian):
                return _newton(f, z, r, 5)
        else:
            damping *= 4
            if damping > 1e12:
                break
        if longest < 1e-14:
            break
    return Root(z, r, _vanish(r, jacobian))
