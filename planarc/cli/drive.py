"""`planarc drive`: the torques and forces that a motion needs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from planarc.cli import arguments as arg
from planarc.cli import console
from planarc.cli.analysis import number, open_model, say_json, say_table, split_pair, with_settings
from planarc.cli.files import save, table_destination
from planarc.cli.line import Option
from planarc.core.diagnostic import refused, usage_error
from planarc.core.files import read_plain
from planarc.core.options import Redundant
from planarc.core.prose import counted


def drive(
    target: arg.Target,
    class_name: arg.ClassName = None,
    motion: Annotated[
        list[str] | None,
        Option(
            metavar="JOINT.phi=MOTION",
            help="A formula of time, or @FILE with rows of time and value. Repeatable.",
        ),
    ] = None,
    stop: arg.Stop = None,
    intervals: arg.Intervals = None,
    settings: arg.Settings = None,
    library: arg.Libraries = None,
    redundant: arg.RedundantJoints = Redundant.REFUSE,
    output: Annotated[Path | None, arg.output_option("All variables, .csv or .mat.")] = None,
    as_json: arg.AsJson = False,
) -> int:
    """Inverse dynamics: the torques and forces that a motion needs.

    For example --motion "revA.phi=1 + 2*time"; the result holds all joint forces.
    """
    if not motion:
        raise usage_error(
            "C251", "no motion is given", hint='write `--motion "revA.phi=sin(2*time)"`'
        )
    if output is not None:
        table_destination(output)
    model = open_model(target, class_name, library, redundant=redundant)
    model, values, starts = with_settings(model, settings)
    motions = _motions(motion)
    driven = model.drive(
        motions, stop_time=stop, intervals=intervals, parameters=values, start=starts
    )
    console.complain(driven.result.warnings)
    if output is not None:
        from planarc.view.table.files import write_table
        from planarc.view.table.origin import Origin

        origin = Origin(file=model.request.file, libraries=model.request.libraries)
        save(output, lambda path: write_table(path, driven.result.rows, origin=origin))
    told = []
    for coordinate, name in driven.efforts.items():
        column = driven[name]
        told.append((coordinate, name, driven.result.unit(name), column.min(), column.max()))
    if as_json:
        efforts = {
            c: {"variable": n, "unit": u, "values": driven[n].tolist()} for c, n, u, _, _ in told
        }
        written = None if output is None else str(output)
        say_json(
            {"model": model.name, "time": driven.time.tolist(), "efforts": efforts,
             "output": written}
        )  # fmt: skip
        return 0
    console.say(f"{model.name} from t = {driven.time[0]:.6g} s to {driven.time[-1]:.6g} s")
    rows = [(c, n, u, number(low), number(high)) for c, n, u, low, high in told]
    say_table(("driven", "effort", "unit", "least", "greatest"), rows)
    if output is not None:
        console.say(f"{output} ({counted(len(driven.time), 'row')})")
    return 0


def _motions(items: Sequence[str]) -> dict[str, Any]:
    """The motions by coordinates, each given once."""
    pairs = [_motion(item) for item in items]
    motions = dict(pairs)
    twice = next((name for name in motions if sum(n == name for n, _ in pairs) > 1), None)
    if twice is not None:
        raise usage_error(
            "C256", f"the motion of `{twice}` is given twice", hint="leave one of them out"
        )
    return motions


def _motion(item: str) -> tuple[str, Any]:
    name, text = split_pair("--motion", item, '--motion "revA.phi=sin(2*time)"')
    if not text.startswith("@"):
        return name, text
    return name, read_motion(Path(text[1:]))


def read_motion(path: Path) -> tuple[list[float], list[float]]:
    """Times and values of a file: two columns, with commas, semicolons or blanks between them.

    A first line without numbers names the columns.
    """
    try:
        lines = read_plain(path).decode("utf-8-sig", "replace").splitlines()
    except OSError as problem:
        raise refused("C108", f"cannot read `{path}`", problem) from None
    rows: list[tuple[float, ...]] = []
    for at, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            row = tuple(float(cell) for cell in re.split(r"\s*[,;]\s*|\s+", line.strip()))
        except ValueError:
            row = ()
        if len(row) == 2:
            rows.append(row)
        elif rows or at > 1:
            raise usage_error(
                "C252",
                f"line {at} of `{path}` is no time and value: `{line.strip():.40}`",
                hint="write one of each in every line, as in `0.5, 1.2`",
            )
    return [t for t, _ in rows], [x for _, x in rows]
