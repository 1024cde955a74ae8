"""The page of a study: some of its points run again, and laid beside each other.

A study keeps metrics only. Of a few points, spread over it evenly, the runs are made again for
the page; their labels are the points.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planarc import stages
from planarc.cli.settings import Setting, sort_settings

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.study.table import Study
    from planarc.view.page.runs import Shown

#: The most runs of a page: more cannot be told apart.
RUNS = 6


def write_study_page(
    path: Path,
    model: Model,
    study: Study,
    values: Mapping[str, Any],
    starts: Mapping[str, Any],
    **times: Any,
) -> None:
    """Write the page of a study, of which a point at least did not fail. Raises UsageError where
    the file cannot be written."""
    from planarc.view.page.report import write_report

    points = [point for point, metrics in study.rows if metrics is not None]
    last = len(points) - 1
    chosen = sorted({round(i * last / (RUNS - 1)) for i in range(RUNS)})
    shown = [_run(model, points[i], values, starts, times) for i in chosen]
    first, *others = shown
    summary = [
        ("model", model.name),
        ("points", f"{len(study)}, of which {len(shown)} are shown"),
        ("varied", ", ".join(study.parameters)),
    ]
    write_report(
        path, first.result, first.scene, summary, None, first.insight, (), first.label, others
    )


def _run(
    model: Model,
    point: Mapping[str, Any],
    values: Mapping[str, Any],
    starts: Mapping[str, Any],
    times: Mapping[str, Any],
) -> Shown:
    from planarc.view.page.runs import Shown
    from planarc.view.scene import make_scene

    parameters = {p.name for p in model.program.parameter_slots}
    own, begun = sort_settings([Setting(n, v) for n, v in point.items()], parameters)
    result = model.simulate(parameters={**values, **own}, start={**starts, **begun}, **times)
    label = ", ".join(f"{name} = {_text(value)}" for name, value in point.items())
    insight = stages.study(result.rows, model.compiled().load())
    return Shown(label, result.rows, make_scene(result.rows), insight)


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
