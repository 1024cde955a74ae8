"""`planarc gallery`: a contact sheet of all examples, each in motion."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.arguments import Libraries, output_option
from planarc.cli.exits import Exit
from planarc.cli.files import PAGES, check_writable, file_stem, page_destination
from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import Severity, refused, usage_error
from planarc.core.prose import ticked

if TYPE_CHECKING:
    from planarc.catalog.examples import Shown
    from planarc.view.page.gallery import Card

_LIBRARY = "PlanarMultiBody.Examples"


def gallery(
    targets: Annotated[
        list[str] | None,
        Argument(
            metavar="[PACKAGE|FOLDER|FILE]...", help=f"Where the examples are; without, {_LIBRARY}."
        ),
    ] = None,
    output: Annotated[Path | None, output_option("The page, .html.")] = None,
    reports: Annotated[
        Path | None,
        Option(
            "--reports",
            metavar="FOLDER",
            help="Write the whole report of each into this folder, and link it.",
        ),
    ] = None,
    library: Libraries = None,
) -> int:
    """Run all examples, and show them in motion on one page.

    An example is a model with an experiment annotation. One that fails is shown with its message,
    and makes exit code 1.
    """
    from planarc.catalog.examples import find_examples, run_examples
    from planarc.cli.progress import counting_line
    from planarc.view.page.gallery import render_gallery
    from planarc.view.storage import write_text

    named = tuple(targets or (_LIBRARY,))
    path = page_destination("gallery", output)
    examples = find_examples(named, tuple(library or ()))
    if not examples:
        raise usage_error(
            "C293",
            f"there is no example in {ticked(named)}",
            hint="an example is a model with `annotation(experiment(StopTime=...))`",
        )
    if reports is not None:
        _make_folder(reports)
        check_writable(reports / "report.html", "--reports")
    with counting_line() as progress:
        shown = [(s, _card(s, reports, path)) for s in run_examples(examples, progress)]
    write_text(path, render_gallery(" and ".join(named), [card for _, card in shown]))
    bad = [s for s, _ in shown if s.problem is not None and s.problem.severity is Severity.ERROR]
    console.complain([s.problem for s in bad if s.problem is not None])
    if not console.is_quiet():
        rows = [("examples", f"{len(shown)}, {len(bad)} failed" if bad else str(len(shown)))]
        console.say_rows([*rows, ("written", str(path))])
    return Exit.MODEL if bad else Exit.DONE


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise refused("C123", f"cannot make the folder `{folder}`", problem) from None


def _card(shown: Shown, reports: Path | None, page: Path) -> Card:
    from planarc.insight.facts import count_text
    from planarc.view.page.gallery import Card
    from planarc.view.scene import make_scene

    example, result = shown.example, shown.result
    problem = "" if shown.problem is None else shown.problem.message
    title = example.name.rpartition(".")[2]
    if result is None:
        return Card(title, example.description, problem=problem)
    mechanism = result.program.mechanism
    facts = "" if mechanism is None else count_text(mechanism).partition(" (")[0]
    link = ""
    if reports is not None:
        from planarc.cli.job import write_page

        name = ".".join(file_stem(part) for part in example.name.split("."))
        report = reports / f"{name}{PAGES[0]}"
        write_page(report, result, shown.kernel)
        link = Path(os.path.relpath(report, page.parent)).as_posix()
    return Card(title, example.description, facts, make_scene(result), problem, link)
