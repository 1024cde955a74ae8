"""The findings of `planarc check --all`: the causes of failures and a table, or all as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator

from planarc.catalog.survey import Cause, Count, Survey
from planarc.cli.console import plain
from planarc.core.prose import shortened
from planarc.core.render import in_order, render
from planarc.core.render import to_json as diagnostic_to_json

NAMED = 3  # classes named below a cause; the others are counted


def as_text(survey: Survey) -> tuple[str, str]:
    """The causes, each once, with the classes that fail by it; and the table."""
    causes = "\n".join(_cause(cause) for cause in survey.causes())
    return causes, "\n".join(_table(survey)) + "\n"


def _cause(cause: Cause) -> str:
    names = shortened([f"`{plain(name)}`" for name in cause.names], NAMED)
    return f"{render(cause.diagnostic)}  in: {names}\n"


def _table(survey: Survey) -> Iterator[str]:
    """One row a package, and their sum.

    package                       models   good    bad   per cent   others
    PlanarMultiBody.Joints            12     12      0      100.0        4
    """
    counts = survey.packages()
    rows = counts if len(counts) == 1 else (*counts, survey.total)
    width = max(len(plain(count.package)) for count in rows) if rows else 0
    yield f"{'package':{width}}  models    good     bad  per cent  others"
    for i, count in enumerate(rows):
        if i and i == len(counts):
            yield "-" * (width + 42)
        yield _row(count, width)


def _row(count: Count, width: int) -> str:
    percent = "-" if count.percent is None else f"{_rounded_down(count.percent):.1f}"
    return (
        f"{plain(count.package):{width}}  {count.good + count.bad:6}  {count.good:6}  "
        f"{count.bad:6}  {percent:>8}  {count.others:6}"
    )


def _rounded_down(percent: float) -> float:
    """The percentage rounded down: 100.0 means all."""
    return int(percent * 10) / 10


def to_json(survey: Survey) -> str:
    """One JSON object, on one line."""
    packages = [{"package": count.package, **_numbers(count)} for count in survey.packages()]
    classes = [
        {
            "name": finding.name,
            "kind": finding.kind,
            "verdict": finding.verdict.value,
            "diagnostics": [diagnostic_to_json(d) for d in in_order(finding.diagnostics)],
        }
        for finding in survey.findings
    ]
    head = {"ok": survey.total.bad == 0, "target": survey.target, **_numbers(survey.total)}
    return json.dumps({**head, "packages": packages, "classes": classes})


def _numbers(count: Count) -> dict[str, int | float | None]:
    percent = None if count.percent is None else _rounded_down(count.percent)
    return {"good": count.good, "bad": count.bad, "percent": percent, "others": count.others}
