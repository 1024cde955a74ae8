"""Explicit Runge-Kutta steps of many runs, each with its own time and length.

The method is DOP853 of order 8, with the coefficients that SciPy publishes in its class
of that name. It asks for one value of the derivatives at a time, of all runs, so that
the text's cost is shared; and it remembers nothing from step to step, so that states can
be exchanged for free.

Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
           2nd ed. 1993, sections II.5 and II.6.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]
    Rhs = Callable[[Numbers, Numbers], Numbers]

SAFETY, SMALLEST, LARGEST = 0.9, 0.2, 8.0
ORDER = 8


def first_length(y: Numbers, f: Numbers, atol: Numbers, rtol: float, span: float) -> Numbers:
    """A step so short that y changes by a hundredth of itself."""
    import numpy as np

    scale = atol + rtol * np.abs(y)
    size, speed = _mean(y / scale), _mean(f / scale)
    small = (size < 1e-5) | (speed < 1e-5)
    guess = np.where(small, 1e-6, 0.01 * size / np.where(small, 1.0, speed))
    return np.minimum(guess, span)


def _mean(values: Numbers) -> Numbers:
    import numpy as np

    squares: Numbers = np.mean(values * values, axis=0)
    return np.sqrt(squares)


class Step:
    """One attempt: `y`, `f` at its end, `error` of each run, where 1 is the tolerance."""

    def __init__(
        self,
        rhs: Rhs,
        t: Numbers,
        y: Numbers,
        f: Numbers,
        h: Numbers,
        atol: Numbers,
        rtol: float,
    ) -> None:
        import numpy as np

        method = _method()
        stages = method.n_stages
        self._rhs, self._h, self._t, self._y0, self._f0 = rhs, h, t, y, f
        self._k = k = np.empty((method.A_EXTRA.shape[1], *y.shape))
        k[0] = f
        for s in range(1, stages):
            k[s] = rhs(t + method.C[s] * h, y + h * np.tensordot(method.A[s, :s], k[:s], 1))
        self.y = y + h * np.tensordot(method.B, k[:stages], 1)
        self.f = k[stages] = rhs(t + h, self.y)
        scale = atol + rtol * np.maximum(np.abs(y), np.abs(self.y))
        five = np.sum((np.tensordot(method.E5, k[: stages + 1], 1) / scale) ** 2, axis=0)
        three = np.sum((np.tensordot(method.E3, k[: stages + 1], 1) / scale) ** 2, axis=0)
        below = np.sqrt((five + 0.01 * three) * len(y))
        self.error = np.abs(h) * five / np.where(below > 0, below, 1.0)

    def factor(self) -> Numbers:
        """What the next length should be, in parts of this one; nan asks for much less."""
        import numpy as np

        error = np.where(np.isnan(self.error), np.inf, np.maximum(self.error, 1e-16))
        return np.clip(SAFETY * error ** (-1 / ORDER), SMALLEST, LARGEST)

    def between(self) -> Callable[[Numbers], Numbers]:
        """y at times within the step, to order 7. Costs three more derivatives."""
        import numpy as np

        method, k, h = _method(), self._k, self._h
        for s in range(method.n_stages + 1, len(k)):
            row = method.A_EXTRA[s - method.n_stages - 1]
            change = h * np.tensordot(row[:s], k[:s], 1)
            k[s] = self._rhs(
                self._t + method.C_EXTRA[s - method.n_stages - 1] * h, self._y0 + change
            )
        change = self.y - self._y0
        parts = [change, h * self._f0 - change, 2 * change - h * (self.f + self._f0)]
        parts += list(h * np.tensordot(method.D, k, 1))
        length = np.where(h > 0, h, 1.0)

        def value(t: Numbers) -> Numbers:
            x = (t - self._t) / length
            y = np.zeros_like(self._y0)
            for i, part in enumerate(reversed(parts)):
                y = (y + part) * (x if i % 2 == 0 else 1 - x)
            return y + self._y0

        return value


def _method() -> Any:
    from scipy.integrate import DOP853

    return DOP853
