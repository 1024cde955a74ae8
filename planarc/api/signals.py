"""Functions of time that a user gives: inputs of a model, and motions that drive it.

A signal is a number, a function `f(t)`, or a table: a pair (times, values), or rows of
them. Tables go through their points as a cubic spline where second derivatives are needed,
and on straight lines where they are not; a run stops at their `corners`, and at those that a
function shows at the rows of the run. A motion may also be three functions: position, velocity,
acceleration; those that are not given come from differences of high order.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, MutableSequence, Sequence
from typing import Any, TypeAlias, TypeGuard

import numpy as np

from planarc.api.corners import corners
from planarc.core.arrays import Vector
from planarc.core.diagnostic import UsageError, usage_error
from planarc.ir.kernel import Capabilities, Kernel

#: A number, a function of time, or a table of (times, values).
Signal: TypeAlias = "float | Callable[[float], float] | Sequence[Any] | Any"
#: Position, velocity and acceleration at a time.
Motion: TypeAlias = "Callable[[float], tuple[float, float, float]]"

#: Weights of the differences of order eight, for steps 0 to 4 on either side.
_FIRST = (0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280)
_SECOND = (-205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560)


def read_signal(name: str, given: Signal) -> Callable[[float], float]:
    """The signal as a function of time, of finite numbers. Raises UsageError C210, C211."""
    if callable(given):
        return _checked(name, given)
    if isinstance(given, int | float):
        value = _finite(name, given, 0.0)
        return lambda t: value
    times, values = read_table(name, given)
    return lambda t: float(np.interp(t, times, values))


def read_signals(
    given: Mapping[str, Signal], inputs: Sequence[str], span: float
) -> dict[str, Callable[[float], float]]:
    """Each input as a function of time, and those of its derivatives that are inputs, too.

    `der(u)` of a table is the slope of its straight lines, to the right at a point. Where
    `der(der(u))` is needed, the table is a spline, so that all three belong together. A table
    that jumps has neither.
    """
    found = {name: read_signal(name, s) for name, s in given.items()}
    for name, signal in given.items():
        rate, second = f"der({name})", f"der(der({name}))"
        if second in inputs or (rate in inputs and callable(signal)):
            motion = read_motion(name, signal, span)
            wanted = {name: 0, rate: 1, second: 2}
            found |= {
                n: lambda t, f=motion, i=i: f(t)[i]  # type: ignore[misc]
                for n, i in wanted.items()
                if n in inputs and (n == name or n not in given)
            }
        elif rate in inputs and rate not in given:
            found[rate] = _slope(name, signal)
    return found


def read_corners(given: Mapping[str, Signal], rows: Vector) -> list[float]:
    """The instants, ascending, at which signals bend so much that a run must stop there.

    A function is looked at where the run has `rows`, so that what these show was felt, too.
    """
    moving = {n: s for n, s in given.items() if not isinstance(s, int | float)}
    tables = [_seen(n, s, rows) if callable(s) else read_table(n, s) for n, s in moving.items()]
    return sorted({t for table in tables for t in corners(*table).tolist()})


def _seen(name: str, function: Callable[[float], Any], rows: Vector) -> tuple[Vector, Vector]:
    """A function as a table. Where it has no value nothing is known yet: the run may end before."""
    signal = _checked(name, function)

    def value(t: float) -> float:
        try:
            return signal(t)
        except UsageError:
            return math.nan

    values = np.array([value(t) for t in rows.tolist()])
    known = np.isfinite(values)
    return rows[known], values[known]


def _slope(name: str, given: Signal) -> Callable[[float], float]:
    if isinstance(given, int | float):
        return lambda t: 0.0
    times, values = _read_smooth(name, given)
    slopes = [0.0, *(np.diff(values) / np.diff(times)).tolist(), 0.0]
    return lambda t: slopes[int(np.searchsorted(times, t, "right"))]


def read_motion(name: str, given: Signal, span: float) -> Motion:
    """A motion over a run of `span` seconds, with two derivatives."""
    if _is_three(given):
        q, v, a = (_checked(name, f) for f in given)
        return lambda t: (q(t), v(t), a(t))
    if callable(given):
        return _differences(_checked(name, given), span)
    if isinstance(given, int | float):
        value = _finite(name, given, 0.0)
        return lambda t: (value, 0.0, 0.0)
    times, values = _read_smooth(name, given)
    if len(times) < 4:
        raise usage_error(
            "C210", f"the motion of `{name}` needs at least 4 points, not {len(times)}"
        )
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(times, values)
    v, a = spline.derivative(1), spline.derivative(2)
    return lambda t: (float(spline(t)), float(v(t)), float(a(t)))


def table_span(name: str, given: Any) -> tuple[float, float] | None:
    """The first and the last time of a motion that is a table."""
    if callable(given) or isinstance(given, int | float | str) or _is_three(given):
        return None
    times, _ = read_table(name, given)
    return float(times[0]), float(times[-1])


def _is_three(given: Any) -> TypeGuard[Sequence[Callable[[float], float]]]:
    """True for three functions: position, velocity and acceleration."""
    return isinstance(given, tuple | list) and len(given) == 3 and all(map(callable, given))


def read_table(name: str, given: Any) -> tuple[Vector, Vector]:
    """Ascending times and values. Two points at one time are a jump, as in rows at an event."""
    try:
        table = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim == 2 and table.shape[0] != 2 and table.shape[1] == 2:
        table = table.T
    if table.ndim != 2 or table.shape[0] != 2 or table.shape[1] < 2:
        raise usage_error(
            "C210",
            f"`{name}` takes a number, a function of time or a table (times, values)",
            hint="give two sequences of equal length, with at least two points",
        )
    times, values = table
    if not np.all(np.isfinite(table)) or not np.all(np.diff(times) >= 0):
        raise usage_error("C210", f"the table of `{name}` must be finite, with times that ascend")
    return _without_repetitions(times, values)


def _without_repetitions(times: Vector, values: Vector) -> tuple[Vector, Vector]:
    """Of the points at one time the first and the last, and one alone where these agree."""
    first, last = np.diff(times, prepend=-np.inf) > 0, np.diff(times, append=np.inf) > 0
    begun = values[first][np.cumsum(first) - 1]
    kept = first | (last & (values != begun))
    return times[kept], values[kept]


def _read_smooth(name: str, given: Any) -> tuple[Vector, Vector]:
    """A table without jumps, for whoever needs a derivative of it."""
    times, values = read_table(name, given)
    jumps = times[1:][np.diff(times) == 0]
    if len(jumps):
        raise usage_error(
            "C210",
            f"the table of `{name}` jumps at t = {jumps[0]:g} s, and its derivative is needed",
            hint="let it change within a time, if short: give the second point a later one",
        )
    return times, values


def _checked(name: str, function: Callable[[float], Any]) -> Callable[[float], float]:
    _expect_time(name, function)

    def call(t: float) -> float:
        try:
            value = function(t)
        except Exception as problem:
            what = f"{type(problem).__name__}: {problem}"
            raise usage_error(
                "C211", f"the function for `{name}` fails at t = {t:.6g} s: {what}"
            ) from problem
        return _finite(name, value, t)

    return call


def _expect_time(name: str, function: Callable[..., Any]) -> None:
    """Refuse what cannot be called with the time alone, where Python tells."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return
    try:
        signature.bind(0.0)
    except TypeError:
        raise usage_error(
            "C211",
            f"the function for `{name}` takes `{signature}`, and is called with the time",
            hint="write `lambda t: ...`",
        ) from None


def _finite(name: str, value: Any, t: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) and math.isfinite(t):  # a search that fails may come by anywhere
        raise usage_error(
            "C211", f"the value for `{name}` at t = {t:.6g} s is no finite number: {value!r:.40}"
        )
    return number


def _differences(f: Callable[[float], float], span: float) -> Motion:
    h = max(span, 1e-6) / 2000

    def motion(t: float) -> tuple[float, float, float]:
        middle = f(t)
        v, a = 0.0, _SECOND[0] * middle
        for k in range(1, 5):
            above, below = f(t + k * h), f(t - k * h)
            v += _FIRST[k] * (above - below)
            a += _SECOND[k] * (above + below)
        return middle, v / h, a / h**2

    return motion


class ForcedKernel:
    """A kernel whose inputs, or parameters, follow functions of time.

    `force(t)` gives the values by slot. It stands between an integrator and the kernel,
    so that every evaluation sees the values of its own time. A run stops at the `corners` of the
    functions.
    """

    def __init__(
        self,
        kernel: Kernel,
        force: Callable[[float], Mapping[int, float]],
        begin: float,
        corners: Sequence[float] = (),
    ) -> None:
        self.inner, self._values, self._begin, self._corners = kernel, force, begin, corners
        self.w: MutableSequence[float] = kernel.w
        self.history = kernel.history

    def force(self, t: float) -> None:
        """Set the values of this time."""
        for slot, value in self._values(t).items():
            self.w[slot] = value

    @property
    def selection(self) -> Sequence[int]:
        return self.inner.selection

    @property
    def capabilities(self) -> Capabilities:
        """A way to the start and corners: every evaluation comes by here, to see the values of its
        time."""
        return Capabilities(lead=self.inner.capabilities.lead, corners=self._corners)

    def __getattr__(self, name: str) -> Any:
        """The kernel's own attribute, for whatever takes no time."""
        return getattr(self.inner, name)

    def origin(self, block: int) -> list[float]:
        return self.inner.origin(block)

    def settle(self, block: int, values: Sequence[float]) -> None:
        self.inner.settle(block, values)

    def parameters(self) -> int:
        flag = self.inner.parameters()
        self.force(self._begin)
        return flag

    def rhs(self, t: float, y: Sequence[float], ydot: MutableSequence[float]) -> int:
        self.force(t)
        return self.inner.rhs(t, y, ydot)

    def outputs(self, t: float, y: Sequence[float]) -> int:
        self.force(t)
        return self.inner.outputs(t, y)

    def residuals(self, t: float, u: Sequence[float], r: MutableSequence[float]) -> int:
        self.force(t)
        return self.inner.residuals(t, u, r)

    def roots(self, t: float, y: Sequence[float], g: MutableSequence[float]) -> int:
        self.force(t)
        return self.inner.roots(t, y, g)
