"""`planarc simulate`: compile a model, run it, write what came out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from planarc.cli import arguments as arg
from planarc.cli.line import Option
from planarc.cli.settings import read_settings
from planarc.core.diagnostic import usage_error
from planarc.core.options import FIXED_STEP, Backend, Contacts, Redundant, RunOptions, Solver
from planarc.core.prose import listed

_FIXED_STEP = f"Steps of this length, with {listed(FIXED_STEP, 'or')}, or of contacts."


def simulate(
    target: arg.Target,
    class_name: arg.ClassName = None,
    start: Annotated[float | None, arg.time_option(help="Start time in seconds.")] = None,
    stop: arg.Stop = None,
    interval: Annotated[
        float | None, arg.time_option(help="Seconds from one row of the result to the next.")
    ] = None,
    intervals: Annotated[
        int | None, Option(help="Number of intervals, instead of their length.")
    ] = None,
    tolerance: arg.Tolerance = None,
    solver: Annotated[Solver, Option(help="The integrator.")] = Solver.AUTO,
    fixed_step: Annotated[
        float | None,
        arg.time_option(help=_FIXED_STEP),
    ] = None,
    contact: Annotated[
        Contacts | None,
        Option(
            help="What rigid contacts do is found at events, or step by step, for very many of "
            "them: by default where the model has a crowd."
        ),
    ] = None,
    backend: Annotated[
        Backend | None,
        Option(help="How equations are run: by default native code, where llvmlite is installed."),
    ] = None,
    redundant: arg.RedundantJoints = Redundant.REFUSE,
    settings: arg.Settings = None,
    start_from: Annotated[
        str | None,
        Option(
            "--start-from",
            metavar="PLACE",
            help="Start at the `equilibrium`, at `assembly 2` as `planarc assemble` counts, or at "
            "the last row of a result, whatever initial equations say.",
        ),
    ] = None,
    library: arg.Libraries = None,
    output: Annotated[Path | None, arg.output_option("Result file, .csv or .mat.")] = None,
    report: Annotated[
        Path | None, Option(metavar="FILE", help="Page with motion and curves, .html.")
    ] = None,
    no_output: Annotated[bool, Option("--no-output", help="Write no result file.")] = False,
    no_report: Annotated[bool, Option("--no-report", help="Write no page.")] = False,
    variables: arg.Pattern = None,
    units: Annotated[
        bool, Option("--units", help="Write units behind the names in a .csv file.")
    ] = False,
    assembly: Annotated[
        bool,
        Option(
            "--assembly",
            help="Do not run: list all ways to put the mechanism together, as start values.",
        ),
    ] = False,
    as_json: arg.AsJson = False,
) -> int:
    """Run a model and write its results.

    Times, rows and tolerance are those of the model's experiment annotation, unless given.
    Without options, <Class>.csv and <Class>.html are written into the working directory.
    A .mat file also holds parameters and constants; a .csv file does where --variables names them.
    """
    _refuse_both(output, no_output, "output")
    _refuse_both(report, no_report, "report")
    if assembly:
        _refuse_files(output, report)
        from planarc.cli.analysis import open_model
        from planarc.cli.assemble import tell_assemblies

        model = open_model(target, class_name, library, backend, redundant)
        return tell_assemblies(model, settings, as_json)
    from planarc.cli.job import Job, Run

    options = RunOptions(
        start=start,
        stop=stop,
        interval=interval,
        intervals=intervals,
        tolerance=tolerance,
        solver=solver,
        fixed_step=fixed_step,
        backend=arg.choose_backend(backend),
        redundant=redundant,
        contact=contact,
    )
    job = Job(
        arg.make_request(target, class_name, library, redundant),
        options,
        read_settings(settings or ()),
        output,
        report,
        no_output,
        no_report,
        arg.read_pattern(variables),
        units,
        start_from,
    )
    return Run(job, as_json).finish()


def _refuse_both(path: Path | None, refused: bool, name: str) -> None:
    if path is not None and refused:
        raise usage_error("C112", f"both `--{name}` and `--no-{name}` are given", hint="give one")


def _refuse_files(output: Path | None, report: Path | None) -> None:
    """Refuse to name files beside `--assembly`, which writes none."""
    for name, path in (("output", output), ("report", report)):
        if path is not None:
            raise usage_error(
                "C112",
                f"both `--assembly` and `--{name}` are given, but `--assembly` writes no file",
                hint="give one",
            )
