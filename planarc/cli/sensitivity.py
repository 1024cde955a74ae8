"""`planarc sensitivity`: how results change with parameters."""

from __future__ import annotations

from math import isnan, nan
from pathlib import Path
from typing import Annotated

from planarc.cli import arguments as arg
from planarc.cli import console
from planarc.cli.analysis import number, open_model, say_json, say_table, with_settings
from planarc.cli.files import csv_destination, save
from planarc.cli.line import Option
from planarc.core.diagnostic import usage_error
from planarc.core.options import Redundant
from planarc.core.prose import counted


def sensitivity(
    target: arg.Target,
    class_name: arg.ClassName = None,
    parameter: Annotated[
        list[str] | None,
        Option(
            metavar="NAME",
            help="A parameter. Repeatable.",
            autocompletion=arg.offers("parameters"),
        ),
    ] = None,
    variable: Annotated[
        list[str] | None,
        Option(
            metavar="NAME",
            help="A variable. Repeatable; by default those that may be states.",
            autocompletion=arg.offers("variables"),
        ),
    ] = None,
    stop: arg.Stop = None,
    intervals: arg.Intervals = None,
    tolerance: arg.Tolerance = None,
    settings: arg.Settings = None,
    library: arg.Libraries = None,
    redundant: arg.RedundantJoints = Redundant.REFUSE,
    output: Annotated[Path | None, arg.output_option("A table over time, .csv.")] = None,
    as_json: arg.AsJson = False,
) -> int:
    """Tell how results change with parameters, over time.

    They are integrated together with the motion.
    """
    if not parameter:
        raise usage_error("C253", "no parameter is named", hint="write `--parameter body.m`")
    if output is not None:
        csv_destination(output)
    model = open_model(target, class_name, library, redundant=redundant)
    model, values, starts = with_settings(model, settings)
    found = model.sensitivities(
        parameter,
        stop_time=stop,
        intervals=intervals,
        tolerance=tolerance,
        values=values,
        start=starts,
    )
    variables = list(variable or model.states)
    pairs = {(v, p): found[v, p] for v in variables for p in found.parameters}
    if output is not None:
        from planarc.view.storage import write_rows

        head = ("time", *(f"d({v})/d({p})" for v, p in pairs))
        columns = (found.time.tolist(), *(x.tolist() for x in pairs.values()))
        save(output, lambda path: write_rows(path, head, zip(*columns, strict=True)))
    if as_json:
        table = [
            {"variable": v, "parameter": p, "values": [None if isnan(d) else d for d in x.tolist()]}
            for (v, p), x in pairs.items()
        ]
        say_json(
            {"model": model.name, "method": found.method, "derivatives": found.derivatives,
             "time": found.time.tolist(), "sensitivities": table,
             "output": None if output is None else str(output)}
        )  # fmt: skip
        return 0
    end = number(float(found.time[-1]))
    how = {
        ("equations", "formulas"): "from formulas",
        ("equations", "differences"): "from differences of the equations",
    }.get((found.method, found.derivatives), "from differences of runs")
    console.say(f"{model.name}: derivatives {how}, and the largest until t = {end} s")
    rows = [(v, p, number(x[-1]), number(_largest(x.tolist()))) for (v, p), x in pairs.items()]
    say_table(("variable", "parameter", "at the end", "largest"), rows)
    if any(isnan(d) for x in pairs.values() for d in x.tolist()):
        console.tell("nan: events at this time move with the parameter to both sides of it")
    if output is not None:
        console.say(f"{output} ({counted(len(found.time), 'row')})")
    return 0


def _largest(values: list[float]) -> float:
    """The largest size of those that are known."""
    return max((abs(d) for d in values if not isnan(d)), default=nan)
