"""`planarc animate`: the moving mechanism as a picture, still or moving."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from planarc.cli import arguments as arg
from planarc.cli import console
from planarc.cli.analysis import open_model, say_json
from planarc.cli.exits import Exit
from planarc.cli.files import TABLES, check_writable
from planarc.cli.line import Argument, Option
from planarc.core.options import Redundant
from planarc.core.prose import counted

if TYPE_CHECKING:
    from planarc.view.picture.make import Made


def animate(
    target: Annotated[
        str,
        Argument(
            metavar="RESULT|MODEL",
            help="A result, .csv or .mat; or a model to run: a file, or a class of a library.",
            autocompletion=arg.offers("results"),
        ),
    ],
    class_name: arg.ClassName = None,
    output: Annotated[
        Path | None, arg.output_option("The picture: .svg, .gif, .mp4, .png.")
    ] = None,
    begin: Annotated[
        float | None, arg.time_option("--from", help="Show the run from this time on, in seconds.")
    ] = None,
    end: Annotated[
        float | None, arg.time_option("--to", help="Show the run until this time, in seconds.")
    ] = None,
    at: Annotated[
        float | None, arg.time_option(help="Show one instant instead of a motion.")
    ] = None,
    speed: Annotated[
        float | None, Option(help="Seconds of the run in a second of the picture.")
    ] = None,
    rate: Annotated[float, Option("--fps", help="Frames a second.")] = 25.0,
    width: Annotated[int, Option(help="Width in pixels; the height follows.")] = 640,
    dark: Annotated[
        bool | None,
        Option("--dark/--light", help="The ground; a .svg follows the reader's screen."),
    ] = None,
    traces: Annotated[
        list[str] | None,
        Option(
            "--trace",
            metavar="POINT",
            help="Draw the path of a part or a vector, as couplerBody.r_0CM. Repeatable.",
            autocompletion=arg.offers("variables"),
        ),
    ] = None,
    layers: Annotated[
        list[str] | None,
        Option(
            "--layer",
            metavar="LAYER",
            help="Draw forces, contacts, velocities, accelerations, paths, masses or names.",
            autocompletion=arg.offers("layers"),
        ),
    ] = None,
    model_name: Annotated[
        str | None,
        Option(
            "--model",
            metavar="FILE|CLASS",
            help="Of a RESULT: the model that made it, where the result does not tell it.",
        ),
    ] = None,
    mode: Annotated[
        int | None,
        Option(metavar="N", help="Show the N-th mode of the linear model instead of a run."),
    ] = None,
    around: Annotated[
        str,
        Option(
            metavar="WHERE",
            help="Of --mode: around `start`, `equilibrium`, or a time: 0.5 or 500ms.",
        ),
    ] = "start",
    amplitude: Annotated[float, Option(help="Of --mode: how far the largest state moves.")] = 0.2,
    stop: arg.Stop = None,
    settings: arg.Settings = None,
    library: arg.Libraries = None,
    redundant: arg.RedundantJoints = Redundant.REFUSE,
    as_json: arg.AsJson = False,
) -> int:
    """Draw the moving mechanism as a picture.

    A .svg moves by itself in every browser and needs nothing else; .gif and .png need Pillow,
    .mp4 also imageio-ffmpeg: pip install "planarc[pictures]". A .png, and any picture with --at,
    shows one instant.
    """
    from planarc.cli.motion import motion_of_mode, named_output, read_result, refuse_run, run_of
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
        refuse_run(mode, stop, settings, redundant)
        rows = read_result(Path(target), model_name, class_name, library)
    else:
        model = open_model(target, class_name, library, redundant=redundant)
        if mode is None:
            rows = run_of(model, settings, end if stop is None else stop).rows
        else:
            rows = motion_of_mode(model, settings, mode, around, amplitude)
    made = write_picture(path, rows, options, study(rows).layers if wanted else ())
    _tell(path, made, as_json)
    return Exit.DONE


def _tell(path: Path, made: Made, as_json: bool) -> None:
    if as_json:
        shown = {"frames": made.frames, "seconds": made.seconds, "speed": made.speed}
        say_json({"output": str(path), **shown, "notes": list(made.notes)})
        return
    if not console.is_quiet():
        rows = [("written", str(path))]
        if made.seconds:
            pace = "" if abs(made.speed - 1) < 1e-3 else f", {_pace(made.speed)}"
            rows.append(("shows", f"{made.seconds:.3g} s in {counted(made.frames, 'frame')}{pace}"))
        rows += [("note", note) for note in made.notes]
        console.say_rows(rows)


def _pace(speed: float) -> str:
    return f"{speed:.3g} times faster" if speed > 1 else f"{1 / speed:.3g} times slower"
