"""`planarc view`: the page of a result that was written before."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from msgspec.structs import replace

from planarc.cli import console
from planarc.cli.arguments import Libraries, output_option
from planarc.cli.exits import Exit
from planarc.cli.files import page_destination
from planarc.cli.line import Argument, Option
from planarc.core.data import Data
from planarc.core.diagnostic import UsageError, usage_error

if TYPE_CHECKING:
    from planarc.ir.insight import Insight
    from planarc.ir.result import Result
    from planarc.view.page.runs import Shown
    from planarc.view.table.table import Table


def view(
    result: Annotated[
        list[Path],
        Argument(
            metavar="RESULT...",
            help="A result, .csv or .mat, also of another tool; others are laid beside the first.",
        ),
    ],
    model: Annotated[
        str | None,
        Option(
            "--model", metavar="FILE|CLASS", help="The model that made it: it says what is drawn."
        ),
    ] = None,
    class_name: Annotated[
        str | None, Option("--class", metavar="CLASS", help="The class of the model's FILE.")
    ] = None,
    output: Annotated[Path | None, output_option("The page, .html.")] = None,
    curves: Annotated[
        list[str] | None,
        Option("--curve", metavar="VAR", help="Show this curve. Repeatable."),
    ] = None,
    no_open: Annotated[bool, Option("--no-open", help="Do not open a browser.")] = False,
    library: Libraries = None,
) -> int:
    """Show results as a page: motion, curves, energy.

    With several results the first plays; the others are pale behind it, and their curves lie
    beside its curves. What planarc wrote says which model made it, a .csv by the file
    `<Class>.csv-metadata.json` beside it. Of other results the model is looked for: a library's
    class, or a file beside the result (or here) that declares the class that a .mat names, or that
    the .csv is called after. Without a model there are curves only, which replace no page that
    shows the motion.
    """
    from planarc.view.page.report import write_report

    if class_name is not None and model is None:
        raise usage_error("C291", "`--class` needs a file", hint="name it with `--model FILE`")
    first, *others = result
    stem = first.stem.replace(".", "_")
    path = page_destination(f"{stem}-runs" if others else stem, output)
    found = [_read(file, model, class_name, library) for file in result]
    main = found[0]
    main.table.refuse_unknown(curves or ())
    kept: tuple[tuple[str, str], ...] = ()
    if not main.where and output is None and _shows_motion(path):
        kept = (("kept", f"{path}, which shows the motion"),)
        path = page_destination(f"{path.stem}-curves", None)
    shown = _shown(result, found)
    time = main.table.time
    summary = [
        ("file", first.name),
        ("model", shown[0].result.program.name if main.where else ""),
        ("rows", f"{len(time)}, t = {time[0]:.6g} to {time[-1]:.6g} s"),
        ("beside it", ", ".join(file.name for file in others)),
    ]
    write_report(
        path,
        shown[0].result,
        shown[0].scene,
        [row for row in summary if row[1]],
        curves,
        shown[0].insight,
        notes := tuple(dict.fromkeys(note for one in found for note in one.notes)),
        shown[0].label,
        shown[1:],
    )
    if not console.is_quiet():
        told = [("model", main.where or _unknown(main.table)), ("written", str(path))]
        console.say_rows([*told, *kept, *(("note", n) for n in notes)])
    if not no_open:
        _open(path)
    return Exit.DONE


class _Found(Data):
    """A result with its model; `where` says where that stands, nothing without one."""

    table: Table
    where: str
    result: Result
    insight: Insight | None
    notes: tuple[str, ...]


def _read(
    file: Path, model: str | None, class_name: str | None, library: list[Path] | None
) -> _Found:
    from planarc import stages
    from planarc.api.restore import restore
    from planarc.cli.motion import find_model
    from planarc.view.table.files import read_table

    table = read_table(file)
    if not len(table.time):
        raise usage_error(
            "C292", f"`{file}` holds no row", hint="was the run ended before its start?"
        )
    try:
        request, compiled = find_model(file, table, model, class_name, library)
    except UsageError as error:
        raise _by_option(error) from None
    restored = restore(table, file.name, compiled)
    if compiled is None or request is None:
        return _Found(table, "", restored.result, None, (_WITHOUT,))
    where = model or f"{request.class_name}{f' in {request.file}' if request.file else ''}"
    insight = stages.study(restored.result, restored.kernel)
    return _Found(table, where, restored.result, insight, restored.notes)


def _by_option(error: UsageError) -> UsageError:
    """The same error, with the option that names the class here."""
    hint = "name one of them with `--class`"
    return UsageError(
        tuple(
            replace(d, hint=hint)
            if d.code in ("C106", "C107") and d.hint and "of them" in d.hint
            else d
            for d in error.diagnostics
        )
    )


def _shown(files: Sequence[Path], found: Sequence[_Found]) -> list[Shown]:
    """The runs with labels: the parameters by which they differ, or else their files."""
    from planarc.view.page.runs import Shown, labels_of
    from planarc.view.scene import make_scene

    origins = [one.table.origin for one in found]
    told = [{} if origin is None else origin.parameters for origin in origins]
    labels = labels_of([one.result for one in found], told, [str(file) for file in files])
    return [
        Shown(label, one.result, make_scene(one.result), one.insight)
        for label, one in zip(labels, found, strict=True)
    ]


def _unknown(table: Table) -> str:
    """Why there are curves only."""
    origin = table.origin
    if origin is None or origin.file is None or origin.file.is_file():
        return "unknown: curves only"
    return f"{origin.model}, but there is no file {origin.file}: curves only"


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
        console.tell("no browser was found: open the page by hand")
