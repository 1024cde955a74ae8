"""`planarc animate`: the moving mechanism as a picture, still or moving."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planarc.cli import console
from planarc.cli.analysis import Settings, Stop, open_model, with_settings
from planarc.cli.arguments import (
    AsJson,
    ClassName,
    Libraries,
    RedundantJoints,
    make_request,
)
from planarc.cli.exits import Exit
from planarc.cli.files import TABLES, check_writable
from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.core.options import Redundant

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.api.result import Result
    from planarc.ir.result import Result as Rows
    from planarc.view.picture.make import Made


def animate(
    target: Annotated[
        str,
        typer.Argument(
            metavar="RESULT|MODEL",
            help="A result, .csv or .mat; or a model to run: a file, or a class of a library.",
            show_default=False,
        ),
    ],
    class_name: ClassName = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="The picture: .svg, .gif, .mp4, .png."),
    ] = None,
    begin: Annotated[
        float | None, typer.Option("--from", help="Show the run from this time on, in seconds.")
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", help="Show the run until this time, in seconds.")
    ] = None,
    at: Annotated[
        float | None, typer.Option(metavar="TIME", help="Show one instant instead of a motion.")
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Seconds of the run in a second of the picture.")
    ] = None,
    rate: Annotated[float, typer.Option("--fps", help="Frames a second.")] = 25.0,
    width: Annotated[int, typer.Option(help="Width in pixels; the height follows.")] = 640,
    dark: Annotated[
        bool | None,
        typer.Option(
            "--dark/--light",
            help="The ground; a .svg follows the reader's screen.",
            show_default=False,
        ),
    ] = None,
    traces: Annotated[
        list[str] | None,
        typer.Option(
            "--trace",
            metavar="POINT",
            help="Draw the path of a part or a vector, as couplerBody.r_0CM. Repeatable.",
            show_default=False,
        ),
    ] = None,
    layers: Annotated[
        list[str] | None,
        typer.Option(
            "--layer",
            metavar="LAYER",
            help="Draw forces, velocities, accelerations or paths. Repeatable.",
            show_default=False,
        ),
    ] = None,
    model_name: Annotated[
        str | None,
        typer.Option(
            "--model",
            metavar="FILE|CLASS",
            help="Of a RESULT: the model that made it, where it is not found by its name.",
            show_default=False,
        ),
    ] = None,
    mode: Annotated[
        int | None,
        typer.Option(metavar="N", help="Show the N-th mode of the linear model instead of a run."),
    ] = None,
    around: Annotated[
        str,
        typer.Option(
            metavar="WHERE", help="Of --mode: around `start`, `equilibrium`, or a time in seconds."
        ),
    ] = "start",
    amplitude: Annotated[
        float, typer.Option(help="Of --mode: how far the largest state moves.")
    ] = 0.2,
    stop: Stop = None,
    settings: Settings = None,
    library: Libraries = None,
    redundant: RedundantJoints = Redundant.REFUSE,
    as_json: AsJson = False,
) -> int:
    """Draw the moving mechanism as a picture.

    A .svg moves by itself in every browser and needs nothing else; .gif and .png need Pillow,
    .mp4 also imageio-ffmpeg: pip install "planarc[pictures]". A .png, and any picture with --at,
    shows one instant.
    """
    from planarc.stages import study
    from planarc.view.picture.make import (
        PictureOptions,
        check_installed,
        check_suffix,
        write_picture,
    )
    from planarc.view.picture.motion import When

    path = named_output(output, "planarc animate four_bar.pmo -o four_bar.gif")
    check_installed(check_suffix(path))
    check_writable(path, "--output")
    when = When(begin, end, speed, rate)
    wanted = tuple(layers or ())
    options = PictureOptions(when, at, width, dark, tuple(traces or ()), wanted)
    if Path(target).suffix.lower() in TABLES:
        _refuse_run(mode, stop, settings)
        rows = _read(Path(target), model_name, class_name, library)
    else:
        model = open_model(target, class_name, library, redundant=redundant)
        if mode is None:
            rows = run_of(model, settings, end if stop is None else stop).rows
        else:
            rows = _mode(model, settings, mode, around, amplitude).rows
    made = write_picture(path, rows, options, study(rows).layers if wanted else ())
    _tell(path, made, as_json)
    return Exit.DONE


def named_output(output: Path | None, example: str) -> Path:
    if output is None:
        raise UsageError(
            Diagnostic("C270", "`--output` is missing", hint=f"write e.g. `{example}`")
        )
    return output


def _refuse_run(mode: int | None, stop: float | None, settings: list[str] | None) -> None:
    """What belongs to a run has no meaning for one that is over."""
    for given, name in ((mode, "--mode"), (stop, "--stop"), (settings, "--set")):
        if given is not None:
            raise UsageError(
                Diagnostic(
                    "C272",
                    f"`{name}` needs a model: a result is not run again",
                    hint="name the model instead of the result",
                )
            )


def _read(
    path: Path, model: str | None, class_name: str | None, library: list[Path] | None
) -> Rows:
    """A result that was written before, with the model that says what is drawn."""
    from planarc.api.restore import compile_guess, compile_request, find_request, restore
    from planarc.view.table.files import read_table

    table = read_table(path)
    compiled = None
    if model is not None:
        compiled = compile_request(make_request(model, class_name, library))
    else:
        name = class_name or table.model or path.stem
        guess = find_request(name, (path.parent, Path()), tuple(library or ()))
        compiled = None if guess is None else compile_guess(guess, table)
    if compiled is None:
        raise UsageError(
            Diagnostic(
                "C273",
                f"no model is found that made `{path}`: it says what is drawn",
                hint="name it with `--model FILE`",
            )
        )
    return restore(table, path.name, compiled).result


def run_of(model: Model, settings: list[str] | None, stop: float | None) -> Result:
    """A run of the model; one that ends before its time is told, and taken as far as it went."""
    from planarc.api.result import RunStopped

    model, values, starts = with_settings(model, settings)
    try:
        return model.simulate(stop, parameters=values, start=starts)
    except RunStopped as stopped:
        if not len(stopped.result):
            raise
        console.complain(stopped.diagnostics)
        return stopped.result


def _mode(
    model: Model, settings: list[str] | None, number: int, around: str, amplitude: float
) -> Result:
    """A small motion of one mode, drawn large."""
    model, values, starts = with_settings(model, settings)
    try:
        where: float | str = float(around)
    except ValueError:
        where = around
    linear = model.linearize(where, parameters=values, start=starts)
    if not 1 <= number <= len(linear.modes):
        raise UsageError(
            Diagnostic(
                "C271",
                f"there is no mode {number}: the linear model has {len(linear.modes)}",
                hint="`planarc linearize` lists them",
            )
        )
    return linear.motion(number - 1, amplitude)


def _tell(path: Path, made: Made, as_json: bool) -> None:
    import json

    if as_json:
        console.say(
            json.dumps(
                {
                    "ok": True,
                    "output": str(path),
                    "frames": made.frames,
                    "seconds": made.seconds,
                    "speed": made.speed,
                    "notes": list(made.notes),
                }
            )
        )
        return
    if not console.is_quiet():
        rows = [("written", str(path))]
        if made.seconds:
            pace = "" if abs(made.speed - 1) < 1e-3 else f", {_pace(made.speed)}"
            rows.append(("shows", f"{made.seconds:.3g} s in {made.frames} frames{pace}"))
        rows += [("note", note) for note in made.notes]
        console.say_rows(rows)


def _pace(speed: float) -> str:
    return f"{speed:.3g} times faster" if speed > 1 else f"{1 / speed:.3g} times slower"
