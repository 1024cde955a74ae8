"""`planarc export`: a model as a file that other tools run, a browser, or a C compiler."""

from __future__ import annotations

import os
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.arguments import (
    ClassName,
    Libraries,
    RedundantJoints,
    Target,
    choose_backend,
    make_request,
    output_option,
    read_pattern,
)
from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import usage_error
from planarc.core.options import Backend, Redundant

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.export.c.source import Source
    from planarc.export.fmu import Fmu
    from planarc.export.wishes import Wishes


class Form(StrEnum):
    FMU = "fmu"
    PAGE = "page"
    C = "c"


class Version(StrEnum):
    TWO = "2"
    THREE = "3"


def export(
    form: Annotated[Form, Argument(metavar="fmu|page|c", help="What to write.")],
    target: Target,
    class_name: ClassName = None,
    output: Annotated[
        Path | None,
        output_option(
            "The file to write, for `c` the folder; by default NAME.fmu, NAME_live.html or NAME, "
            "here."
        ),
    ] = None,
    outputs: Annotated[
        str | None,
        Option(
            "--outputs",
            metavar="REGEX",
            help="Outputs: variables whose names this regular expression matches anywhere. "
            "Without, the model's own, or all coordinates where it has none.",
        ),
    ] = None,
    input: Annotated[
        list[str] | None,
        Option(
            "--input",
            metavar="NAME",
            help="Make a variable an input: a torque or force that the model gives, the signal of "
            "a source, the coordinate of a joint. Repeatable.",
        ),
    ] = None,
    parameters: Annotated[
        str | None,
        Option(
            "--parameters",
            metavar="REGEX",
            help="Parameters that can be set: those whose names this matches anywhere. Without, "
            "all that `--set` takes.",
        ),
    ] = None,
    platforms: Annotated[
        str | None,
        Option(
            "--platforms",
            metavar="NAMES",
            help="With commas between them, as x86_64-linux,x86_64-windows. Without, all.",
        ),
    ] = None,
    stiff: Annotated[
        bool,
        Option(
            "--stiff",
            help="Integrate with an implicit method (FMUs: in co-simulation): for hard springs and "
            "strong dampers. The parameter `_stiff` of an FMU changes it.",
        ),
    ] = False,
    source: Annotated[
        bool,
        Option(
            "--source",
            help="Put the code into the FMU as C99, too: for platforms that planarc has no code "
            "for, and for reading.",
        ),
    ] = False,
    fmi: Annotated[Version, Option(help="The version of the standard.")] = Version.THREE,
    redundant: RedundantJoints = Redundant.REFUSE,
    library: Libraries = None,
) -> int:
    """Write a model as an FMU, as a page that runs it, or as C.

    An FMU, which other simulators run, holds the model as machine code for Linux, Windows and
    macOS, for model exchange and co-simulation. A page holds it for the browser that opens it,
    with sliders for its parameters, start values and inputs; it needs no planarc, no server and
    no network. C is what people read and a microcontroller compiles: C99 in a folder, with a small
    program that writes the outputs. All begin in the assembly that `planarc simulate` finds. The
    options from `--outputs` to `--fmi` are those of FMUs; C has all but `--platforms`, `--source`
    and `--fmi`, a page has `--input` and `--stiff`.
    """
    from msgspec.structs import replace

    from planarc.compiler import compile_model
    from planarc.export.wishes import Wishes

    if form is not Form.FMU:
        alone: dict[str, object] = {
            "platforms": platforms,
            "source": source or None,
            "fmi": None if fmi is Version.THREE else fmi,
        }
        others: dict[str, object] = {"outputs": outputs, "parameters": parameters}
        given = alone if form is Form.C else others | alone
        _refuse_given(form, [name for name, value in given.items() if value is not None])
    wishes = Wishes(
        int(fmi),
        read_pattern(outputs, "--outputs"),
        read_pattern(parameters, "--parameters"),
        None if platforms is None else tuple(platforms.replace(",", " ").split()),
        stiff,
        source,
    )
    backend = choose_backend(Backend.NATIVE)
    request = make_request(target, class_name, library, redundant)
    compiled = compile_model(replace(request, inputs=tuple(input or ())), backend)
    if form is Form.PAGE:
        return _page(compiled, output, stiff)
    write = _source if form is Form.C else _fmu
    return write(compiled, output, wishes)


def _refuse_given(form: Form, names: Sequence[str]) -> None:
    for name in names:
        raise usage_error(
            "C100", f"`export {form}` has no option `--{name}`", hint="it is one of `export fmu`"
        )


def _place(compiled: Compiled, output: Path | None, ending: str, kind: str = "") -> Path:
    """The file to write, by default of the model's name and its `kind`. Raises UsageError C121,
    C123."""
    from planarc.cli.files import check_writable, file_stem

    path = output or Path(f"{file_stem(compiled.program.name)}{kind}{ending}")
    if path.suffix.lower() != ending:
        raise usage_error(
            "C121", f"`--output {path}` has no ending that planarc writes", hint=f"use `{ending}`"
        )
    check_writable(path, "--output")
    console.complain(compiled.warnings)
    return path


def _page(compiled: Compiled, output: Path | None, stiff: bool) -> int:
    from planarc.cli.files import save
    from planarc.compiler import run
    from planarc.core.options import RunOptions
    from planarc.core.prose import counted
    from planarc.export.page.held import taken
    from planarc.export.page.page import make_page
    from planarc.view.storage import write_text

    path = _place(compiled, output, ".html", "_live")  # NAME.html is the report of a run
    taken(compiled.program, stiff)  # before it runs
    page = make_page(compiled, run(compiled, RunOptions()), stiff)
    save(path, lambda place: write_text(place, page.text))
    _tell(("written", str(path)), ("interface", f"{counted(page.fields, 'field')} to set"))
    return 0


def _fmu(compiled: Compiled, output: Path | None, wishes: Wishes) -> int:
    from planarc.cli.files import save
    from planarc.export.fmu import make_fmu
    from planarc.view.storage import write_bytes

    path = _place(compiled, output, ".fmu")
    made = make_fmu(compiled, wishes)
    save(path, lambda place: write_bytes(place, made.data))
    written = "written", f"{path} (FMI {wishes.version}.0)"
    alone = "kind", "co-simulation alone: a crowd takes steps of its own (`_step`)"
    _tell(written, ("interface", _interface(made)), *() if made.exchange else (alone,))
    return 0


def _source(compiled: Compiled, output: Path | None, wishes: Wishes) -> int:
    from planarc.cli.files import check_writable, file_stem, save
    from planarc.export.c.source import is_own_source, make_source
    from planarc.view.storage import write_folder

    path = output or Path(file_stem(compiled.program.name))
    if path.exists() and not path.is_dir():
        raise usage_error(
            "C123", f"cannot write `{path}`: it is a file", hint="give `--output` a folder"
        )
    if not path.exists():
        check_writable(path, "--output")
    console.complain(compiled.warnings)
    made = make_source(compiled, wishes)
    foreign = [path / name for name in made.files if not is_own_source(path / name)]
    if output is None and foreign:
        raise usage_error(
            "C122",
            f"`{foreign[0]}` exists and was not written by planarc",
            hint="move it away, or name another folder with `--output`",
        )
    save(path, lambda place: write_folder(place, made.files))
    written = "written", f"{path}{os.sep}: {', '.join(made.files)}"
    _tell(written, ("interface", _interface(made)))
    return 0


def _tell(*rows: tuple[str, str]) -> None:
    if not console.is_quiet():
        console.say_rows(list(rows))


def _interface(made: Fmu | Source) -> str:
    from planarc.core.prose import counted

    numbers = (
        counted(made.inputs, "input"),
        counted(made.outputs, "output"),
        counted(made.parameters, "parameter"),
        counted(made.states, "state"),
    )
    return ", ".join(numbers)
