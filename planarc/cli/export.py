"""`planarc export`: a model as a file that other tools run."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from planarc.cli import console
from planarc.cli.arguments import (
    ClassName,
    Libraries,
    Target,
    choose_backend,
    make_request,
    output_option,
    read_pattern,
)
from planarc.core.diagnostic import usage_error
from planarc.core.options import Backend


class Form(StrEnum):
    FMU = "fmu"


class Version(StrEnum):
    TWO = "2"
    THREE = "3"


def export(
    form: Annotated[Form, typer.Argument(metavar="fmu", help="What to write.")],
    target: Target,
    class_name: ClassName = None,
    output: Annotated[
        Path | None, output_option("The file to write; by default NAME.fmu, in this folder.")
    ] = None,
    outputs: Annotated[
        str | None,
        typer.Option(
            "--outputs",
            metavar="REGEX",
            help="Outputs: variables whose names this regular expression matches anywhere. "
            "Without, the model's own, or all coordinates where it has none.",
        ),
    ] = None,
    input: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            metavar="NAME",
            help="Make a variable an input: a torque or force that the model gives, the signal of "
            "a source, the coordinate of a joint. Repeatable.",
        ),
    ] = None,
    parameters: Annotated[
        str | None,
        typer.Option(
            "--parameters",
            metavar="REGEX",
            help="Parameters that can be set: those whose names this matches anywhere. Without, "
            "all that `--set` takes.",
        ),
    ] = None,
    platforms: Annotated[
        str | None,
        typer.Option(
            "--platforms",
            metavar="NAMES",
            help="With commas between them, as x86_64-linux,x86_64-windows. Without, all.",
        ),
    ] = None,
    fmi: Annotated[Version, typer.Option(help="The version of the standard.")] = Version.THREE,
    library: Libraries = None,
) -> int:
    """Write a model as an FMU, which other simulators run.

    It holds the model as machine code for Linux, Windows and macOS, for model exchange and
    co-simulation. It begins in the assembly that `planarc simulate` finds.
    """
    from msgspec.structs import replace

    from planarc.cli.files import check_writable, file_stem, save
    from planarc.compiler import compile_model
    from planarc.core.prose import counted
    from planarc.export.fmu import Wishes, make_fmu
    from planarc.view.storage import write_bytes

    wishes = Wishes(
        int(fmi),
        read_pattern(outputs, "--outputs"),
        read_pattern(parameters, "--parameters"),
        None if platforms is None else tuple(filter(None, platforms.replace(",", " ").split())),
    )
    backend = choose_backend(Backend.NATIVE)
    request = make_request(target, class_name, library)
    compiled = compile_model(replace(request, inputs=tuple(input or ())), backend)
    path = output or Path(f"{file_stem(compiled.program.name)}.fmu")
    if path.suffix.lower() != ".fmu":
        raise usage_error(
            "C121", f"`--output {path}` has no ending that planarc writes", hint="use `.fmu`"
        )
    check_writable(path, "--output")
    console.complain(compiled.warnings)
    made = make_fmu(compiled, wishes)
    save(path, lambda place: write_bytes(place, made.data))
    numbers = (
        counted(made.inputs, "input"),
        counted(made.outputs, "output"),
        counted(made.parameters, "parameter"),
        counted(made.states, "state"),
    )
    console.say(f"written    {path} (FMI {fmi}.0)")
    console.say(f"interface  {', '.join(numbers)}")
    return 0
