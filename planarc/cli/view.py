"""`planarc view`: the page of a result that was written before."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planarc.cli import console
from planarc.cli.arguments import Libraries, output_option
from planarc.cli.exits import Exit
from planarc.cli.files import page_destination
from planarc.core.diagnostic import usage_error


def view(
    result: Annotated[
        Path, typer.Argument(metavar="RESULT", help="A result, .csv or .mat, also of another tool.")
    ],
    model: Annotated[
        str | None,
        typer.Option(
            "--model", metavar="FILE|CLASS", help="The model that made it: it says what is drawn."
        ),
    ] = None,
    class_name: Annotated[
        str | None, typer.Option("--class", metavar="CLASS", help="The class of the model's FILE.")
    ] = None,
    output: Annotated[Path | None, output_option("The page, .html.")] = None,
    curves: Annotated[
        list[str] | None,
        typer.Option("--curve", metavar="VAR", help="Show this curve. Repeatable."),
    ] = None,
    no_open: Annotated[bool, typer.Option("--no-open", help="Do not open a browser.")] = False,
    library: Libraries = None,
) -> int:
    """Show a result file as a page: motion, curves, energy.

    What planarc wrote says which model made it, a .csv by the file `<Class>.csv-metadata.json`
    beside it. Of other results the model is looked for: a library's class, or a file beside the
    result (or here) that declares the class that a .mat names, or that the .csv is called after.
    Without a model there are curves only, which replace no page that shows the motion.
    """
    from planarc import stages
    from planarc.api.restore import restore
    from planarc.cli.motion import find_model
    from planarc.view.page.report import write_report
    from planarc.view.scene import make_scene
    from planarc.view.table.files import read_table

    if class_name is not None and model is None:
        raise usage_error("C291", "`--class` needs a file", hint="name it with `--model FILE`")
    path = page_destination(result.stem, output)
    table = read_table(result)
    if not len(table.time):
        raise usage_error(
            "C292", f"`{result}` holds no row", hint="was the run ended before its start?"
        )
    table.refuse_unknown(curves or ())
    request, compiled = find_model(result, table, model, class_name, library)
    restored = restore(table, result.name, compiled)
    rows = restored.result
    kept: tuple[tuple[str, str], ...] = ()
    if compiled is None and output is None and _shows_motion(path):
        kept = (("kept", f"{path}, which shows the motion"),)
        path = page_destination(f"{result.stem}-curves", None)
    insight = stages.study(rows, restored.kernel) if compiled is not None else None
    scene = make_scene(rows)
    notes = restored.notes if compiled is not None else (_WITHOUT,)
    summary = [
        ("file", result.name),
        ("model", rows.program.name if compiled is not None else ""),
        ("rows", f"{len(table.time)}, t = {table.time[0]:.6g} to {table.time[-1]:.6g} s"),
    ]
    write_report(path, rows, scene, [s for s in summary if s[1]], curves, insight, notes)
    where = "unknown: curves only"
    if compiled is not None and request is not None:
        file = f" in {request.file}" if request.file else ""
        where = model or f"{request.class_name}{file}"
    told = [("model", where)]
    if not console.is_quiet():
        console.say_rows([*told, ("written", str(path)), *kept, *(("note", n) for n in notes)])
    if not no_open:
        _open(path)
    return Exit.DONE


_WITHOUT = (
    "This file holds numbers only. With its model the mechanism is drawn, too: "
    "planarc view RESULT --model FILE"
)


def _shows_motion(page: Path) -> bool:
    """True for a page of planarc's that draws a mechanism."""
    try:
        return '"items":[{' in page.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False


def _open(path: Path) -> None:
    import webbrowser

    if not webbrowser.open(path.resolve().as_uri()):
        console.warn("no browser was found: open the page by hand")
