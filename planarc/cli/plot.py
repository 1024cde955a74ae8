"""`planarc plot`: curves of a result as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from msgspec.structs import replace

from planarc.cli import console
from planarc.cli.analysis import open_model
from planarc.cli.arguments import (
    Libraries,
    RedundantJoints,
    Settings,
    Stop,
    names_file,
    offers,
    open_classes,
    output_option,
)
from planarc.cli.exits import Exit
from planarc.cli.files import TABLES, check_writable
from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import usage_error
from planarc.core.options import Redundant

if TYPE_CHECKING:
    from planarc.view.table.table import Table


def plot(
    target: Annotated[
        str,
        Argument(
            metavar="RESULT|MODEL",
            help="A result, .csv or .mat, of planarc or another tool; or a model to run.",
            autocompletion=offers("results"),
        ),
    ],
    variables: Annotated[
        list[str],
        Argument(
            metavar="[CLASS] VAR...",
            help="What to draw; before it the class of a FILE that holds several models.",
            autocompletion=offers("variables"),
        ),
    ],
    output: Annotated[Path | None, output_option("The picture: .png, .svg, .pdf.")] = None,
    x: Annotated[
        str,
        Option(
            "--x",
            metavar="VAR",
            help="What lies along x.",
            autocompletion=offers("variables"),
        ),
    ] = "time",
    stop: Stop = None,
    settings: Settings = None,
    library: Libraries = None,
    redundant: RedundantJoints = Redundant.REFUSE,
) -> int:
    """Draw curves of a result.

    Variables of one unit share a panel. Needs matplotlib: pip install "planarc[plot]".
    Units are those of the file, or of the model that made it, where it is found.
    """
    from planarc.cli.motion import named_output
    from planarc.core.extras import need
    from planarc.view.picture import chart

    path = named_output(output, "planarc plot FourBar.csv revA.phi -o revA.png")
    need("matplotlib", chart.EXTRA)
    check_writable(path, "--output")
    class_name, variables = _class_of(target, variables, library)
    table, title = _table(target, class_name, settings, stop, library, redundant)
    chart.write_chart(path, table, variables, x, title)
    if not console.is_quiet():
        console.say_rows([("written", str(path))])
    return Exit.DONE


def _class_of(
    target: str, words: list[str], library: list[Path] | None
) -> tuple[str | None, list[str]]:
    """The class that stands between a file and the variables, and the variables."""
    from planarc.request.request import models_inside

    if Path(target).suffix.lower() in TABLES or not names_file(target):
        return None, words
    classes, declared = open_classes(target, library)
    first, *others = words
    meant = {first, *(f"{name}.{first}" for name in declared)}
    if not any(entry.full_name in meant for entry in models_inside(classes, declared)):
        return None, words
    if not others:
        message = f"`{first}` is a model, and nothing of it is to be drawn"
        raise usage_error("C100", message, hint="name its variables behind it")
    return first, others


def _table(
    target: str,
    class_name: str | None,
    settings: list[str] | None,
    stop: float | None,
    library: list[Path] | None,
    redundant: Redundant,
) -> tuple[Table, str]:
    """The numbers, and the name of the model where it is known."""
    from planarc.cli.motion import refuse_run, run_of

    if Path(target).suffix.lower() in TABLES:
        from planarc.view.table.files import read_table

        refuse_run(None, stop, settings, redundant)
        return _with_units(read_table(Path(target)), Path(target), library), ""
    from planarc.view.picture.chart import table_of

    result = run_of(open_model(target, class_name, library, redundant=redundant), settings, stop)
    return table_of(result.rows), result.name


def _with_units(table: Table, path: Path, library: list[Path] | None) -> Table:
    """The table with units: its own, or those of the model where that is found."""
    from planarc.cli.motion import find_model

    if table.units:
        return table
    _, compiled = find_model(path, table, library=library)
    if compiled is None:
        return table
    return replace(table, units={c.name: c.unit for c in compiled.program.columns})
