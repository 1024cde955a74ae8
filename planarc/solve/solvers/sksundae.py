"""CVODE through scikit-sundae's own interface, where its library cannot be opened directly.

Every evaluation comes back to Python, so it is slower than `cvode`; steps, order and
interpolation are CVODE's. Roots are located on its interpolation, as with scipy.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from planarc.ir.program import Kernel
from planarc.solve.solvers.integrator import Cause, Counts, March, Outcome, Settings
from planarc.solve.solvers.scipy import ScipyIntegrator


class SksundaeIntegrator(ScipyIntegrator):
    """`method` is `BDF` or `Adams`. Raises ImportError where scikit-sundae is missing."""

    def __init__(self, kernel: Kernel, states: int, settings: Settings, method: str) -> None:
        from sksundae.cvode import CVODE

        super().__init__(kernel, states, settings, "BDF")
        self.name = f"cvode-{method.lower()} (scikit-sundae)"
        self._class, self._multistep = CVODE, method
        self._failed_flag = 0
        self._last = 0.0

    def _derivatives(self, t: float, y: Any, yp: Any) -> None:
        ydot = [0.0] * self._size
        self._calls += 1
        flag = self._kernel.rhs(t, y.tolist(), ydot)
        if flag != 0:
            self._failed_flag = flag
            ydot = [math.nan] * self._size  # CVODE tries a shorter step
        yp[:] = ydot

    def _make(self, limit: float) -> None:
        import numpy as np

        self._limit = limit
        options: dict[str, Any] = {"first_step": self._first} if self._first else {}
        self._solver = self._class(
            self._derivatives,
            method=self._multistep,
            rtol=self._settings.tolerance,
            atol=np.array(self._absolute),
            max_step=self._longest_step,
            **options,
        )
        self._solver.init_step(self._t, np.array(self._y))

    def _present_jacobians(self) -> int:
        return 0

    def step(self, limit: float) -> March:
        import numpy as np

        if self._solver is None:
            self._make(limit)
        self._failed_flag = 0
        found = self._solver.step(limit, method="onestep", tstop=limit)
        if not found.success or not all(map(math.isfinite, np.ravel(found.y).tolist())):
            blocked = Cause.NOT_FINITE if self._failed_flag < 0 else Cause.BLOCK
            return March(Outcome.FAILED, cause=blocked if self._failed_flag else Cause.CONVERGENCE)
        self._steps += 1
        self._dense = None
        t, y = float(np.ravel(found.t)[-1]), np.reshape(found.y, (-1, self._size))[-1].copy()
        self._last = t - self._t
        return self._rooted(t, y.tolist(), limit)

    def interpolate(self, t: float) -> Sequence[float]:
        import numpy as np

        found = self._solver.step(t, method="normal")
        return np.reshape(found.y, (-1, self._size))[-1].tolist()  # type: ignore[no-any-return]

    def last_step(self) -> float:
        return self._last

    def counts(self) -> Counts:
        return Counts(self._steps, self._calls)
