"""`planarc sweep`: many runs of one model, as a table."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planarc.cli import console
from planarc.cli.analysis import (
    Intervals,
    Settings,
    Stop,
    Tolerance,
    number,
    open_model,
    say_json,
    say_table,
    settings_of,
    split_pair,
)
from planarc.cli.arguments import AsJson, ClassName, Libraries, Target
from planarc.cli.exits import Exit
from planarc.cli.files import check_writable
from planarc.core.diagnostic import Diagnostic, UsageError

if TYPE_CHECKING:
    from planarc.table import Study

_SHOWN = 20


def sweep(
    target: Target,
    class_name: ClassName = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUES",
            help="0.5,0.6 or 0.5:0.9:5 (from, to, how many); with a sample 0.5:0.9. Repeatable.",
            show_default=False,
        ),
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            metavar="METRIC",
            help="A variable (at the end), or max(x), min, mean, rms, range, maxabs of it. "
            "Repeatable.",
            show_default=False,
        ),
    ] = None,
    random: Annotated[int | None, typer.Option(help="So many random points.")] = None,
    latin: Annotated[int | None, typer.Option(help="So many points of a Latin hypercube.")] = None,
    seed: Annotated[int, typer.Option(help="Of the random points.")] = 0,
    stop: Stop = None,
    intervals: Intervals = None,
    tolerance: Tolerance = None,
    settings: Settings = None,
    workers: Annotated[int | None, typer.Option(help="Processes, by default one a core.")] = None,
    limit: Annotated[float, typer.Option(help="Seconds that one run may take.")] = 60.0,
    journal: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Notes every point; with it a study is taken up again."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="The table, .csv.")
    ] = None,
    library: Libraries = None,
    as_json: AsJson = False,
) -> int:
    """Run a model for many values of its parameters, on all cores.

    For example --vary "crankBody.m=0.5:2:16" --metric "max(revA.w)". Points that fail are
    told at the end; the others go on.
    """
    from planarc.study import StudyInterrupted
    from planarc.study import sweep as run_study

    if output is not None:
        check_writable(output, "--output")
    points = _points(vary or [], random, latin, seed)
    model = open_model(target, class_name, library)
    values, starts = settings_of(model, settings)
    stopped: StudyInterrupted | None = None
    try:
        study = run_study(
            model,
            points,
            metric or None,
            stop_time=stop,
            intervals=intervals,
            tolerance=tolerance,
            parameters=values,
            start=starts,
            workers=workers,
            limit=limit,
            journal=journal,
            progress=not as_json and sys.stderr.isatty(),
        )
    except StudyInterrupted as interrupted:
        study, stopped = interrupted.study, interrupted
    if output is not None:
        study.to_csv(output)
    if as_json:
        failures = [{"point": dict(f.point), "reason": f.reason} for f in study.failures]
        say_json(
            {"ok": not study.failures, "model": model.name, "columns": list(study.columns),
             "rows": [[_plain(v) for v in row.values()] for row in study],
             "failures": failures, "output": None if output is None else str(output)}
        )  # fmt: skip
    else:
        _tell(study, output)
    if stopped is not None:
        return Exit.INTERRUPTED
    return Exit.RUN if study.failures else Exit.DONE


def _tell(study: Study, output: Path | None) -> None:
    rows: list[tuple[str, ...]] = []
    for row in study:
        if len(rows) == _SHOWN:
            break
        rows.append(tuple(number(v) if isinstance(v, float) else str(v) for v in row.values()))
    say_table(study.columns, rows)
    if len(study) > _SHOWN:
        more = "" if output else "; `--output FILE.csv` writes all"
        console.say(f"... {len(study)} points in all{more}")
    if output is not None:
        console.say(f"{output} ({len(study)} rows)")
    failures = study.failures
    console.complain(
        Diagnostic("C254", f"point {f.index + 1} ({_named(f.point)}) failed: {f.reason}")
        for f in failures[:_SHOWN]
    )
    if len(failures) > _SHOWN:
        console.complain([Diagnostic("C254", f"{len(failures)} points failed in all")])


def _named(point: Any) -> str:
    return ", ".join(f"{n} = {v:.6g}" if isinstance(v, float) else n for n, v in point.items())


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and value != value else value


def _points(vary: list[str], random: int | None, latin: int | None, seed: int) -> Any:
    from planarc import design

    if not vary:
        raise UsageError(
            Diagnostic("C255", "nothing is varied", hint='write `--vary "rod.L=0.5,0.6"`')
        )
    if random is not None and latin is not None:
        raise UsageError(Diagnostic("C256", "both `--random` and `--latin` are given"))
    pairs = [split_pair("--vary", item, '--vary "rod.L=0.5,0.6"') for item in vary]
    if random is None and latin is None:
        return design.grid({name: _values(name, text) for name, text in pairs})
    ranges: dict[str, Any] = {name: _numbers(name, text, ":") for name, text in pairs}
    if random is not None:
        return design.random(ranges, random, seed)
    return design.latin_hypercube(ranges, latin or 0, seed)


def _values(name: str, text: str) -> list[float]:
    if ":" not in text:
        return _numbers(name, text, ",")
    parts = _numbers(name, text, ":")
    if len(parts) != 3 or parts[2] != int(parts[2]) or parts[2] < 1:
        raise UsageError(
            Diagnostic(
                "C257",
                f"`{text}` says not from where to where `{name}` goes, and in how many values",
                hint=f"write `{name}=0.5:0.9:5`",
            )
        )
    low, high, count = parts[0], parts[1], int(parts[2])
    return [low + (high - low) * i / max(1, count - 1) for i in range(count)]


def _numbers(name: str, text: str, mark: str) -> list[float]:
    words = {"true": 1.0, "false": 0.0}
    try:
        return [words[t.strip()] if t.strip() in words else float(t) for t in text.split(mark)]
    except ValueError:
        raise UsageError(
            Diagnostic("C257", f"the values `{text}` of `{name}` are no numbers")
        ) from None
