"""The numbers that are kept of each run of a study, by name.

A metric is a text (`crank.phi` for its value at the end, `max(crank.w)`, `rms(...)` ...),
a function of the Result that gives a number or numbers by name, a list of texts, or a
mapping of names to texts and functions.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from planarc.api.result import Result
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity, UsageError, usage_error
from planarc.core.prose import ticked
from planarc.core.unknown import refuse_unknown, unknown_name
from planarc.ir.program import Program
from planarc.study.extremum import highest, lowest, rises, rows_alone

Metric: TypeAlias = "str | Callable[[Result], Any] | Sequence[str] | Mapping[str, Any]"

_CALL = re.compile(r"(\w+)\s*\((.*)\)\s*")


def _mean(result: Result, name: str, square: bool = False) -> float:
    """The mean over time, not over rows, of a variable or its square: between rows that tell its
    slopes, it is on the cubics through these."""
    time, x, slopes = result.time, result[name], rises(result, name)
    span = time[-1] - time[0]
    if not span > 0:
        return float(x[-1] ** 2 if square else x[-1])
    h = np.diff(time)
    ends = x * x if square else x
    area = np.sum(h * (ends[1:] + ends[:-1])) / 2
    if slopes is not None:
        bends = 2 * x * slopes if square else slopes
        area += np.sum(h**2 * (bends[:-1] - bends[1:])) / 12
    return float(area / span)


REDUCTIONS: Mapping[str, Callable[[Result, str], float]] = {
    "final": lambda result, name: float(result[name][-1]),
    "mean": _mean,
    "rms": lambda result, name: math.sqrt(max(0.0, _mean(result, name, square=True))),
}
#: Those that take the highest and lowest places of a variable, between the rows, too.
EXTREMA: Mapping[str, Callable[[Result, str], float]] = {
    "max": highest,
    "min": lowest,
    "range": lambda result, name: highest(result, name) - lowest(result, name),
    "maxabs": lambda result, name: max(highest(result, name), -lowest(result, name)),
}
#: All that a metric may be made with, in the order of the help.
KINDS = ("final", "max", "min", "mean", "rms", "range", "maxabs")


class Reduction(Data):
    """One number of a variable over the run."""

    kind: str
    variable: str

    def __call__(self, result: Result) -> float:
        if self.kind in EXTREMA:
            return EXTREMA[self.kind](result, self.variable)
        return REDUCTIONS[self.kind](result, self.variable)


class Metrics(Data):
    """All numbers of a run, by names that nothing that is `varied` has."""

    parts: tuple[tuple[str, Callable[[Result], Any]], ...]
    varied: frozenset[str] = frozenset()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.parts)

    def __call__(self, result: Result) -> dict[str, float]:
        """The numbers of one run. Raises what a user's function raises, and TypeError for
        what is no number, UsageError where it names its own like what is varied."""
        found: dict[str, float] = {}
        for name, part in self.parts:
            value = part(result)
            if isinstance(value, Mapping):
                found.update((str(k), _number(v)) for k, v in value.items())
            else:
                found[name] = _number(value)
        for name in self.varied & found.keys():
            raise _taken(name)
        return found

    def beside(self, varied: Iterable[str]) -> Metrics:
        """The metrics in a table that has columns of what is varied: the value of that itself is
        there already. Raises UsageError (C231) for another metric of such a name."""
        known = frozenset(varied)
        for name, part in self.parts:
            if name in known and part != Reduction("final", name):
                raise _taken(name)
        return Metrics(tuple(p for p in self.parts if p[0] not in known), known)


def _taken(name: str) -> UsageError:
    return usage_error(
        "C231",
        f"`{name}` is varied, and no metric beside it has its name",
        hint="give the metric another name",
    )


def judge_metrics(metrics: Metrics, program: Program) -> Iterator[Diagnostic]:
    """Warnings of extrema for which the rows count alone."""
    for name, part in metrics.parts:
        if not isinstance(part, Reduction) or part.kind not in EXTREMA:
            continue
        if rows_alone(program, part.variable):
            yield Diagnostic(
                "C231",
                f"`{name}` is that of the rows: between them `{part.variable}` may hang on a past"
                " that they do not hold",
                program.delays[0].span,
                severity=Severity.WARNING,
                hint="take more rows (`intervals`) where it has narrow peaks",
            )


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        shape = f" of shape {value.shape}" if getattr(value, "shape", ()) else ""
        raise TypeError(f"a metric is a number, not {type(value).__name__}{shape}") from None


def read_metric(metric: Metric | None, program: Program) -> Metrics:
    """The metrics; of None the states at the end. Raises UsageError for unknown variables."""
    named: Any
    if metric is None:
        columns = {c.name for c in program.columns}
        named = {c.display: c.display for c in program.candidates if c.display in columns}
    elif callable(metric):
        name = getattr(metric, "__name__", "metric")
        named = {name if name.isidentifier() else "metric": metric}
    elif isinstance(metric, str):
        named = {metric: metric}
    else:
        named = metric
    try:
        pairs = named.items() if isinstance(named, Mapping) else [(m, m) for m in named]
    except TypeError:
        raise _no_metric(metric) from None
    return Metrics(tuple((str(n), m if callable(m) else _read(m, program)) for n, m in pairs))


def _no_metric(given: object) -> UsageError:
    return usage_error("C231", f"a metric is a text or a function, not {type(given).__name__}")


def _read(text: Any, program: Program) -> Reduction:
    if not isinstance(text, str):
        raise _no_metric(text)
    columns = {c.name for c in program.columns}
    name = text.strip()
    if name in columns:
        return Reduction("final", name)
    call = _CALL.fullmatch(name)
    method = re.fullmatch(r"(.+)\.(\w+)\(\)", name)
    if method is not None and method[1] in columns:
        hint = f"write `{method[2]}({method[1]})`" if method[2] in KINDS else None
        message = f"a metric is a name, or a function of one, not `{name}`"
        raise usage_error("C231", message, hint=hint or f"choose among {ticked(KINDS)}")
    if name.count("(") != name.count(")"):
        sign = ")" if name.count("(") > name.count(")") else "("
        message = f"a `{sign}` is missing in the metric `{name}`"
        raise usage_error("C231", message, hint="write `max(x)`, or the name alone")
    if call is None or call[1] == "der":
        raise unknown_name("variable", name, columns)
    kind, variable = call[1], call[2].strip()
    refuse_unknown("metric", (kind,), KINDS)
    inner = re.fullmatch(r"abs\((.+)\)", variable)
    if inner and kind == "max":
        hint = f"write `maxabs({inner[1]})`"
        raise usage_error("C231", f"a metric is of a variable, not of `{variable}`", hint=hint)
    if variable not in columns and re.search(r"[-+*/^(]", variable.replace("der(", "")):
        hint = "declare a variable for it in the model, or give a function in Python"
        raise usage_error("C231", f"a metric is of a variable, not of `{variable}`", hint=hint)
    refuse_unknown("variable", (variable,), columns)
    return Reduction(kind, variable)
