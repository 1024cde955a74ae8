"""`planarc animate`: the moving mechanism as a picture, still or moving."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from planarc.cli import console
from planarc.cli.analysis import open_model, say_json
from planarc.cli.arguments import AsJson, ClassName, Libraries, RedundantJoints, Settings, Stop
from planarc.cli.exits import Exit
from planarc.cli.files import TABLES, check_writable
from planarc.cli.motion import motion_of_mode, named_output, read_result, refuse_run, run_of
from planarc.core.options import Redundant

if TYPE_CHECKING:
    from planarc.view.picture.make import Made

TargetOrResult: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="RESULT|MODEL",
        help="A result, .csv or .mat; or a model to run: a file, or a class of a library.",
        show_default=False,
    ),
]
Output: TypeAlias = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="The picture: .svg, .gif, .mp4, .png."),
]
From: TypeAlias = Annotated[
    float | None, typer.Option("--from", help="Show the run from this time on, in seconds.")
]
To: TypeAlias = Annotated[
    float | None, typer.Option("--to", help="Show the run until this time, in seconds.")
]
Instant: TypeAlias = Annotated[
    float | None, typer.Option(metavar="TIME", help="Show one instant instead of a motion.")
]
Speed: TypeAlias = Annotated[
    float | None, typer.Option(help="Seconds of the run in a second of the picture.")
]
Rate: TypeAlias = Annotated[float, typer.Option("--fps", help="Frames a second.")]
Width: TypeAlias = Annotated[int, typer.Option(help="Width in pixels; the height follows.")]
Dark: TypeAlias = Annotated[
    bool | None,
    typer.Option(
        "--dark/--light", help="The ground; a .svg follows the reader's screen.", show_default=False
    ),
]
Traces: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--trace",
        metavar="POINT",
        help="Draw the path of a part or a vector, as couplerBody.r_0CM. Repeatable.",
        show_default=False,
    ),
]
Layers: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--layer",
        metavar="LAYER",
        help="Draw forces, velocities, accelerations or paths. Repeatable.",
        show_default=False,
    ),
]
ModelName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--model",
        metavar="FILE|CLASS",
        help="Of a RESULT: the model that made it, where it is not found by its name.",
        show_default=False,
    ),
]
Mode: TypeAlias = Annotated[
    int | None,
    typer.Option(metavar="N", help="Show the N-th mode of the linear model instead of a run."),
]
Around: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="WHERE", help="Of --mode: around `start`, `equilibrium`, or a time in seconds."
    ),
]
Amplitude: TypeAlias = Annotated[
    float, typer.Option(help="Of --mode: how far the largest state moves.")
]


def animate(
    target: TargetOrResult,
    class_name: ClassName = None,
    output: Output = None,
    begin: From = None,
    end: To = None,
    at: Instant = None,
    speed: Speed = None,
    rate: Rate = 25.0,
    width: Width = 640,
    dark: Dark = None,
    traces: Traces = None,
    layers: Layers = None,
    model_name: ModelName = None,
    mode: Mode = None,
    around: Around = "start",
    amplitude: Amplitude = 0.2,
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
        refuse_run(mode, stop, settings)
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
            rows.append(("shows", f"{made.seconds:.3g} s in {made.frames} frames{pace}"))
        rows += [("note", note) for note in made.notes]
        console.say_rows(rows)


def _pace(speed: float) -> str:
    return f"{speed:.3g} times faster" if speed > 1 else f"{1 / speed:.3g} times slower"
