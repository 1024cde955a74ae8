"""`planarc sweep`: many runs of one model, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from planarc.cli import arguments as arg
from planarc.cli import console
from planarc.cli.analysis import number, open_model, say_json, say_table, split_pair, with_settings
from planarc.cli.exits import Exit
from planarc.cli.files import csv_destination, report_destination, save
from planarc.cli.line import Option
from planarc.cli.progress import is_seen
from planarc.cli.settings import Given, read_values
from planarc.core.diagnostic import Diagnostic, UsageError, usage_error
from planarc.core.interruption import Interruption
from planarc.core.options import Redundant
from planarc.core.prose import counted
from planarc.core.render import to_json

if TYPE_CHECKING:
    from planarc.study.table import Study

_SHOWN = 20


def sweep(
    target: arg.Target,
    class_name: arg.ClassName = None,
    vary: Annotated[
        list[str] | None,
        Option(
            metavar="NAME=VALUES",
            help="0.5,0.6 or 0.5:0.9:5 (from, to, how many), or 5cm:9cm:5; with a sample 0.5:0.9. "
            "Repeatable.",
            autocompletion=arg.offers("settings"),
        ),
    ] = None,
    metric: Annotated[
        list[str] | None,
        Option(
            metavar="METRIC",
            help="A variable (at the end), or max(x), min, mean, rms, range, maxabs of it. "
            "Repeatable.",
            autocompletion=arg.offers("metrics"),
        ),
    ] = None,
    random: Annotated[int | None, Option(help="So many random points.")] = None,
    latin: Annotated[int | None, Option(help="So many points of a Latin hypercube.")] = None,
    seed: Annotated[int, Option(help="Of the random points.")] = 0,
    stop: arg.Stop = None,
    intervals: arg.Intervals = None,
    tolerance: arg.Tolerance = None,
    settings: arg.Settings = None,
    workers: Annotated[int | None, Option(help="Processes, by default one a core.")] = None,
    limit: Annotated[float, Option(help="Seconds that one run may take.")] = 60.0,
    journal: Annotated[
        Path | None,
        Option(metavar="FILE", help="Notes every point; with it a study is taken up again."),
    ] = None,
    output: Annotated[Path | None, arg.output_option("The table, .csv.")] = None,
    report: Annotated[
        Path | None,
        Option(metavar="FILE", help="A page with some of the runs side by side, .html."),
    ] = None,
    library: arg.Libraries = None,
    redundant: arg.RedundantJoints = Redundant.REFUSE,
    as_json: arg.AsJson = False,
) -> int:
    """Run a model for many values of its parameters, on all cores.

    For example --vary "crankBody.m=0.5:2:16" --metric "max(revA.w)". Points that fail are
    told at the end; the others go on. `--report` shows up to six of them, spread evenly: the motion
    of the first, the others pale behind it, their curves and peaks beside each other.
    """
    from planarc.study.sweep import StudyInterrupted
    from planarc.study.sweep import sweep as run_study

    if output is not None:
        csv_destination(output)
    if report is not None:
        report_destination(report)
    if not vary and class_name and "=" in class_name:
        raise usage_error("C255", "nothing is varied", hint=f'write `--vary "{class_name}"`')
    points = _points(vary or [], random, latin, seed)
    model = open_model(target, class_name, library, redundant=redundant)
    model, values, starts = with_settings(model, settings)
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
            progress=not as_json and is_seen(),
        )
    except StudyInterrupted as interrupted:
        study, stopped = interrupted.study, interrupted
    refused: tuple[Diagnostic, ...] = ()
    if output is not None:
        with Interruption() as late:
            try:
                save(output, study.to_csv)
            except UsageError as problem:
                refused = problem.diagnostics
        if late.asked and stopped is None:
            stopped = StudyInterrupted(study)
    if report is not None and stopped is None and len(study) > len(study.failures):
        from planarc.cli.sweep_page import write_study_page

        times = {"stop_time": stop, "intervals": intervals, "tolerance": tolerance}
        try:
            write_study_page(report, model, study, values, starts, **times)
            if not as_json:
                console.say(f"{report}")
        except UsageError as problem:
            refused += problem.diagnostics
    if as_json:
        failures = [{"point": dict(f.point), "reason": f.reason} for f in study.failures]
        told = [*study.warnings, *refused]
        said = {"diagnostics": [to_json(d) for d in told]} if told else {}
        written = None if output is None or refused else str(output)
        say_json(
            {"ok": not study.failures and not refused, "model": model.name,
             "columns": list(study.columns),
             "rows": [[_plain(v) for v in row.values()] for row in study],
             "failures": failures, "output": written, **said}
        )  # fmt: skip
    else:
        _tell(study, output, refused)
    if stopped is not None:
        return Exit.INTERRUPTED
    if refused:
        return Exit.USAGE
    return Exit.RUN if study.failures else Exit.DONE


def _tell(study: Study, output: Path | None, refused: Sequence[Diagnostic]) -> None:
    """The table; all of it where its file could not be written."""
    shown = len(study) if refused else _SHOWN
    rows = [tuple(map(_shown, row.values())) for row in islice(study, shown)]
    say_table(study.columns, rows)
    if len(study) > shown:
        more = "" if output else "; `--output FILE.csv` writes all"
        console.say(f"... {len(study)} points in all{more}")
    if output is not None and not refused:
        console.say(f"{output} ({counted(len(study), 'row')})")
    console.complain(study.warnings)
    failures = study.failures
    console.complain(
        Diagnostic("C254", f"point {f.index + 1} ({_named(f.point)}) failed: {f.reason}")
        for f in failures[:_SHOWN]
    )
    if len(failures) > _SHOWN:
        console.complain([Diagnostic("C254", f"{len(failures)} points failed in all")])
    console.complain(refused)


def _named(point: Any) -> str:
    return ", ".join(f"{n} = {_shown(v)}" for n, v in point.items())


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return f"{{{', '.join(map(_shown, value))}}}"
    return number(value) if isinstance(value, float) else str(value)


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and value != value else value


def _points(vary: list[str], random: int | None, latin: int | None, seed: int) -> Any:
    from planarc.study import points as design

    if not vary:
        raise usage_error("C255", "nothing is varied", hint='write `--vary "rod.L=0.5,0.6"`')
    if random is not None and latin is not None:
        raise usage_error("C112", "both `--random` and `--latin` are given")
    pairs = [split_pair("--vary", item, '--vary "rod.L=0.5,0.6"') for item in vary]
    axes = dict(pairs)
    if len(axes) < len(pairs):
        twice = next(n for i, (n, _) in enumerate(pairs) if n in dict(pairs[:i]))
        raise usage_error("C256", f"`--vary {twice}` is given twice", hint="give all values in one")
    if random is None and latin is None:
        return design.grid({name: _values(name, text) for name, text in pairs})
    ranges = {name: _range(name, text) for name, text in pairs}
    if random is not None:
        return design.random(ranges, random, seed)
    return design.latin_hypercube(ranges, latin or 0, seed)


def _values(name: str, text: str) -> Sequence[Given]:
    if ":" not in text:
        return read_values(name, text)
    parts, unit = _numbers(name, text)
    if len(parts) != 3 or parts[2] != int(parts[2]) or parts[2] < 1:
        ends = text if len(parts) == 2 else "0.5:0.9"
        raise usage_error(
            "C257",
            f"`{text}` says not from where to where `{name}` goes, and in how many values",
            hint=f"write `{name}={ends}:5`, or take a sample with `--random` or `--latin`",
        )
    low, high, count = parts[0], parts[1], int(parts[2])
    if low == high and count > 1:
        raise usage_error(
            "C257",
            f"the values `{text}` of `{name}` are all the same: a range is FROM:TO:HOW_MANY",
            hint=f"write `{name}={low:g}:{low + 1:g}:{count}`",
        )
    values = [low + (high - low) * i / max(1, count - 1) for i in range(count)]
    return [f"{value!r} {unit}" for value in values] if unit else values


def _range(name: str, text: str) -> tuple[float | str, float | str]:
    parts, unit = _numbers(name, text)
    if len(parts) != 2:
        raise usage_error(
            "C257",
            f"`{text}` is no range from which a sample of `{name}` can be taken",
            hint=f"write `{name}=0.5:0.9`",
        )
    low, high = (f"{value!r} {unit}" if unit else value for value in parts)
    return low, high


def _numbers(name: str, text: str) -> tuple[list[float], str]:
    """Numbers with colons between them, and the unit that those have which tell one."""
    from planarc.core.quantity import split

    parts = [split(part) or (part, "") for part in text.split(":")]
    units = {unit for _, unit in parts if unit}
    if len(units) > 1:
        raise usage_error("C257", f"the values `{text}` of `{name}` have several units")
    try:
        return [float(number) for number, _ in parts], "".join(units)
    except ValueError:
        raise usage_error("C257", f"the values `{text}` of `{name}` are no numbers") from None
