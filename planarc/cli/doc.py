"""`planarc doc`: the handbook of a library as one HTML page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from planarc.cli import console
from planarc.cli.arguments import Libraries, names_file, offers, open_classes, output_option
from planarc.cli.line import Argument, Option


def doc(
    target: Annotated[
        str | None,
        Argument(
            metavar="[LIBRARY|CLASS|FILE]",
            help="What to describe; without, all libraries that are found.",
            autocompletion=offers("models"),
        ),
    ] = None,
    output: Annotated[
        Path | None,
        output_option("The page to write; by default the name of the library and `.html`."),
    ] = None,
    library: Libraries = None,
    motion: Annotated[
        bool,
        Option(
            "--motion/--no-motion", help="Run the examples, and show components moving in them."
        ),
    ] = True,
) -> int:
    """Write a page that describes all classes of a library.

    Tree, descriptions, icons, moving pictures, parameters with units and defaults, equations and
    source, with links between the classes. The page needs no network.
    """
    from planarc.catalog.handbook.gather import gather
    from planarc.catalog.handbook.motion import motions_of
    from planarc.catalog.handbook.page import write_handbook
    from planarc.cli.files import page_destination
    from planarc.cli.progress import counting_line
    from planarc.core.prose import counted
    from planarc.request.request import Request

    classes, names = open_classes(target, library)
    title = ", ".join(names)
    path = page_destination(title if len(names) == 1 else "libraries", output)
    pages = gather(classes, names)
    motions = None
    if motion:
        file = Path(target) if target is not None and names_file(target) else None
        asked = Request(file, None, tuple(library or ()))
        with counting_line() as progress:
            motions = motions_of(classes, pages, asked, progress)
    write_handbook(path, title, pages, motions)
    console.say(f"written    {path} ({counted(len(pages), 'class')})")
    return 0
