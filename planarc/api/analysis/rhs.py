"""The equations of a model as a function: for integrators, optimisers and observers of others.

In:   Model, RunOptions; then time, states and inputs
Out:  Rhs    dx/dt = f(t, x, u), its Jacobian, and all other variables

    f = model.rhs()
    f(0.0, f.x0)                # derivatives of f.states
    A, B = f.jacobian(0.0, f.x0)

The states are those that the model chooses at its start, and stay so. Relations keep the truth that
they have there, so that the function is smooth; `settle` gives them that of another point. Loops go
on from where they were evaluated last, so that they stay on their branch. Where a rigid contact
rests, what integrators need to keep it closed is in the function: `linearize` has the modes of the
mechanism alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.api.analysis.linearize import jacobian
from planarc.api.analysis.point import open_point
from planarc.api.values import finite
from planarc.core.arrays import Vector
from planarc.core.diagnostic import PlanarcError, usage_error
from planarc.core.options import RunOptions
from planarc.core.unknown import refuse_unknown

if TYPE_CHECKING:
    from planarc.api.model import Model


class Rhs:
    """The derivatives of the states, as a function `f(t, x, u)`.

    `x` are the values of `states`, `u` those of `inputs` (without it they stay as they are). `t0`,
    `x0` and `u0` are time, states and inputs at the start. The object is a function with a memory
    of its own: give each thread one, and call it along a motion, since a loop that closes in
    several ways stays in that of the call before.
    """

    def __init__(self, model: Model, options: RunOptions) -> None:
        self._point = point = open_point(model, options)
        self._slots = [point.program.slots[n] for n in point.program.inputs]
        self._columns = {c.name: (c.slot, c.sign) for c in point.program.columns}
        self._sizes = len(point.y), len(self._slots)
        self.name = point.program.name
        self.states, self.inputs = point.names, point.program.inputs
        self.t0, self.x0 = point.t, point.y.copy()
        self.u0: Vector = np.array([float(point.kernel.w[s]) for s in self._slots])

    def __call__(self, t: float, x: Sequence[float] | Vector, u: Any = None) -> Vector:
        """dx/dt, of the shape (n,). Raises UsageError C203 for other numbers of states or inputs,
        PlanarcError R470 where the equations have no solution."""
        y, point = self._take(t, x, u), self._point
        try:
            rates = point.rhs(y)
        except PlanarcError:  # far from the last point, the start may be nearer
            point.accept(self.x0, self.t0)
            point.t = float(t)
            rates = point.rhs(y)
        point.kernel.accept(point.t)
        return rates

    def jacobian(
        self, t: float, x: Sequence[float] | Vector, u: Any = None
    ) -> tuple[Vector, Vector]:
        """The matrices df/dx and df/du, of the shapes (n, n) and (n, m) with n states and m inputs.
        Where a rigid contact rests, they hold what keeps it closed, eigenvalues at -10/s, too;
        `Model.linearize` leaves that out. Raises what the call raises."""
        y = self._take(t, x, u)
        self._point.accept(y)
        found, _ = jacobian(self._point)
        return found[:, : len(y)], found[:, len(y) :]

    def outputs(
        self, t: float, x: Sequence[float] | Vector, u: Any = None, *, names: Sequence[str]
    ) -> Vector:
        """The values of the variables `names` there, as many, in SI units. Raises UnknownName."""
        refuse_unknown("variable", names, self._columns)
        w = self._point.outputs(self._take(t, x, u))
        return np.array([sign * w[slot] for slot, sign in (self._columns[n] for n in names)])

    def settle(self, t: float, x: Sequence[float] | Vector, u: Any = None) -> bool:
        """Give relations the truth that they have there, as at an event; true where one changed."""
        self._point.accept(self._take(t, x, u))
        return self._point.settle()

    def _take(self, t: float, x: Any, u: Any) -> Vector:
        """The states; time and inputs are set."""
        if getattr(t, "ndim", 0):  # as `odeint` calls it
            hint = "call it as f(t, x); `scipy.integrate.odeint` does so with `tfirst=True`"
            raise usage_error("C203", "`t` takes one number, not an array", hint=hint)
        self._point.t = finite("t", t, "s")
        if u is not None:
            for slot, value in zip(self._slots, self._numbers("u", u, 1).tolist(), strict=True):
                self._point.kernel.w[slot] = value
        return self._numbers("x", x, 0)

    def _numbers(self, name: str, given: Any, kind: int) -> Vector:
        if isinstance(given, Mapping):
            names = (self.states, self.inputs)[kind]
            refuse_unknown("state" if kind == 0 else "input", given, names)
            base = (self.x0, self.u0)[kind]
            given = [given.get(n, b) for n, b in zip(names, base, strict=True)]
        try:
            found = np.atleast_1d(np.asarray(given, dtype=float))
        except (TypeError, ValueError):
            raise usage_error("C202", f"`{name}` takes numbers, not `{given!r:.60}`") from None
        if found.shape != (self._sizes[kind],):
            wanted = f"{self._sizes[kind]} numbers"
            raise usage_error("C203", f"`{name}` takes {wanted}, not the shape {found.shape}")
        if not np.all(np.isfinite(found)):
            raise usage_error("C202", f"`{name}` must hold finite numbers")
        return found

    def __repr__(self) -> str:
        given = f"; inputs {', '.join(self.inputs)}" if self.inputs else ""
        return f"<f(t, x, u) of {self.name}: states {', '.join(self.states)}{given}>"
