"""What is kept of each run of a study: numbers, by name.

A metric is a text (`crank.phi` for its value at the end, `max(crank.w)`, `rms(...)` ...),
a function of the Result that gives a number or numbers by name, a list of texts, or a
mapping of names to texts and functions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from planarc.api.result import Result
from planarc.core.data import Data
from planarc.core.diagnostic import usage_error
from planarc.core.unknown import unknown_name
from planarc.ir.program import Program

Metric: TypeAlias = "str | Callable[[Result], Any] | Sequence[str] | Mapping[str, Any]"

REDUCTIONS = ("final", "max", "min", "mean", "rms", "range", "maxabs")
_CALL = re.compile(r"(\w+)\s*\((.*)\)\s*")


class Reduction(Data):
    """One number of a variable over the run; means are over time, not over rows."""

    kind: str
    variable: str

    def __call__(self, result: Result) -> float:
        x = result[self.variable]
        match self.kind:
            case "max":
                return float(np.max(x))
            case "min":
                return float(np.min(x))
            case "range":
                return float(np.ptp(x))
            case "maxabs":
                return float(np.max(np.abs(x)))
            case "mean":
                return _mean(result.time, x)
            case "rms":
                return float(np.sqrt(_mean(result.time, x * x)))
        return float(x[-1])


class Metrics(Data):
    """All numbers of a run. `names` are None where a function tells them."""

    parts: tuple[tuple[str, Callable[[Result], Any]], ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.parts)

    def __call__(self, result: Result) -> dict[str, float]:
        """The numbers of one run. Raises what a user's function raises, and TypeError for
        what is no number."""
        found: dict[str, float] = {}
        for name, part in self.parts:
            value = part(result)
            if isinstance(value, Mapping):
                found.update((str(k), _number(v)) for k, v in value.items())
            else:
                found[name] = _number(value)
        return found


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        shape = f" of shape {value.shape}" if getattr(value, "shape", ()) else ""
        raise TypeError(f"a metric is a number, not {type(value).__name__}{shape}") from None


def read_metric(metric: Metric | None, program: Program) -> Metrics:
    """Raises UsageError for unknown variables. None: the states at the end."""
    if metric is None:
        columns = {c.name for c in program.columns}
        names = [c.display for c in program.candidates if c.display in columns]
        return Metrics(tuple((n, Reduction("final", n)) for n in names))
    if isinstance(metric, str):
        return Metrics(((metric, _read(metric, program)),))
    if callable(metric):
        name = getattr(metric, "__name__", "metric")
        return Metrics(((name if name.isidentifier() else "metric", metric),))
    if isinstance(metric, Mapping):
        return Metrics(
            tuple((str(n), m if callable(m) else _read(m, program)) for n, m in metric.items())
        )
    try:
        return Metrics(tuple((m, _read(m, program)) for m in metric))
    except TypeError:
        raise usage_error(
            "C231", f"a metric is a text or a function, not {type(metric).__name__}"
        ) from None


def _read(text: Any, program: Program) -> Reduction:
    if not isinstance(text, str):
        raise usage_error("C231", f"a metric is a text or a function, not {type(text).__name__}")
    columns = {c.name for c in program.columns}
    name = text.strip()
    if name in columns:
        return Reduction("final", name)
    call = _CALL.fullmatch(name)
    if call is None or call[1] == "der":
        raise unknown_name("variable", name, columns)
    if call[1] not in REDUCTIONS:
        raise unknown_name("metric", call[1], REDUCTIONS)
    if call[2].strip() not in columns:
        raise unknown_name("variable", call[2].strip(), columns)
    return Reduction(call[1], call[2].strip())


def _mean(time: Any, x: Any) -> float:
    span = time[-1] - time[0]
    return float(np.trapezoid(x, time) / span) if span > 0 else float(x[-1])
