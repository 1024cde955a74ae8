"""The table of a study as curves or points, by matplotlib.

In:   Study, the metrics to draw, the parameter along x
Out:  axes, a panel for each metric

Points that differ in other parameters lie on curves of their own, named by these; where there are
too many for that, as in a random sample, they are dots, coloured by the next parameter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from planarc.core.arrays import Vector
from planarc.core.diagnostic import usage_error
from planarc.core.extras import need
from planarc.core.unknown import refuse_unknown
from planarc.view.picture.chart import EXTRA, with_unit

#: Curves in one panel, at most.
_MOST = 10


class Study(Protocol):
    """What is drawn of a study."""

    @property
    def columns(self) -> tuple[str, ...]: ...
    @property
    def parameters(self) -> tuple[str, ...]: ...
    @property
    def metrics(self) -> tuple[str, ...]: ...
    @property
    def rows(self) -> Sequence[tuple[Mapping[str, Any], Any]]: ...
    @property
    def units(self) -> Mapping[str, str]: ...
    def __getitem__(self, name: str) -> Vector: ...


def plot_study(study: Study, metrics: Sequence[str], x: str | None, axes: Any) -> Any:
    """The axes of the panels, as an array where there are several. Raises UsageError C201, C202
    (a parameter without numbers), C221 (no matplotlib)."""
    shown = tuple(metrics) or study.metrics
    along = x or next(iter(study.parameters), None)
    if along is None:
        raise usage_error("C202", "nothing was varied, so that there is no curve")
    if not shown:
        raise usage_error("C202", "the study has no metric, so that there is no curve")
    refuse_unknown("column", (*shown, along), study.columns)
    if axes is None:
        pyplot = need("matplotlib.pyplot", EXTRA)
        size = (6.4, 1.2 + 3.0 * len(shown))
        axes = pyplot.subplots(len(shown), sharex=True, figsize=size, layout="constrained")[1]
    panels = [axes] if len(shown) == 1 else list(axes)
    places = _numbers(study, along)
    others = [
        n
        for n in study.parameters
        if n != along and len({str(p.get(n)) for p, _ in study.rows}) > 1
    ]
    groups = _groups(study, others)
    for name, panel in zip(shown, panels, strict=True):
        values = study[name]
        if len(groups) <= _MOST and any(len(rows) > 1 for rows in groups.values()):
            _curves(panel, places, values, groups)
        else:
            colors = _numbers(study, others[0]) if others else None
            dots = panel.scatter(places, values, c=colors, s=18)
            if others:
                panel.figure.colorbar(dots, ax=panel, label=_label(study, others[0]))
        panel.set_ylabel(_label(study, name))
        panel.grid(True, alpha=0.3)
        panel.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel(_label(study, along))
    return axes


def _groups(study: Study, others: Sequence[str]) -> Mapping[str, list[int]]:
    """The rows of each curve, by its name."""
    found: dict[str, list[int]] = {}
    for i, (point, _) in enumerate(study.rows):
        name = ", ".join(f"{n} = {_text(point.get(n))}" for n in others)
        found.setdefault(name, []).append(i)
    return found


def _curves(panel: Any, places: Vector, values: Vector, groups: Mapping[str, list[int]]) -> None:
    for name, rows in groups.items():
        order = sorted((i for i in rows if np.isfinite(values[i])), key=lambda i: places[i])
        panel.plot(places[order], values[order], marker="o", ms=3, lw=1.4, label=name)
    if len(groups) > 1:
        panel.legend(fontsize="small", framealpha=0.9)


def _numbers(study: Study, name: str) -> Vector:
    try:
        return np.array(study[name], dtype=float)
    except (TypeError, ValueError):
        hint = "give another one as `x`"
        raise usage_error("C202", f"the values of `{name}` are no numbers", hint=hint) from None


def _label(study: Study, name: str) -> str:
    return with_unit(name, study.units.get(name, ""))


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
