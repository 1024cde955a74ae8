"""Several runs on one page: the first plays, the others are pale in the picture and dashed.

In:   Shown   runs with labels
Out:  values for `json`: label, scene and curves of each run but the first

Together they have the room of a page: each has its share of rows and characters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from planarc.core.data import Data
from planarc.ir.insight import Insight
from planarc.ir.result import Result
from planarc.view.page.data import ROOM, choose_rows, curve_data, scene_data, shown_unit
from planarc.view.page.figures import Figure
from planarc.view.page.typeset import unit
from planarc.view.scene import Scene

#: The most parameters that a label tells.
MOST = 3


class Shown(Data):
    """A run on a page: `label` is what tells it from the others."""

    label: str
    result: Result
    scene: Scene
    insight: Insight | None = None


def run_data(runs: Sequence[Shown], figures: Sequence[Figure], share: int) -> list[dict[str, Any]]:
    """What the page carries of runs beside its own, each of which has so large a share of it."""
    return [_run(run, figures, share) for run in runs]


def labels_of(
    results: Sequence[Result], told: Sequence[Mapping[str, float]], names: Sequence[str]
) -> list[str]:
    """What tells runs from each other: `told` parameters that differ, or else their names.

    A parameter that one of them does not tell has its value in that run's model.
    """
    changed = dict.fromkeys(name for own in told for name in own)
    columns = [{n: float(r[n][0]) for n in changed if n in r and len(r.time)} for r in results]
    values = [{**column, **own} for column, own in zip(columns, told, strict=True)]
    different = [n for n in changed if len({v.get(n) for v in values}) > 1]
    units = {c.name: shown_unit(c) for c in results[0].program.columns if c.name in different}
    labels = [_label({n: v[n] for n in different if n in v}, units) for v in values]
    return labels if len(set(labels)) == len(labels) else list(names)


def _label(values: Mapping[str, float], units: Mapping[str, tuple[float, str]]) -> str:
    shown = []
    for name, value in list(values.items())[:MOST]:
        factor, kind = units.get(name, (1.0, ""))
        shown.append(f"{name} = {value * factor:.4g} {unit(kind)}".strip())
    return ", ".join(shown)


def _run(run: Shown, figures: Sequence[Figure], share: int) -> dict[str, Any]:
    rows = choose_rows(run.result, figures, 4 * len(run.scene.items), share)
    series = () if run.insight is None else run.insight.series
    curves = curve_data(run.result, figures, rows, series, ROOM // share)
    return {
        "label": run.label,
        "scene": scene_data(run.scene, rows),
        "curves": {**curves, "figures": []},
    }
