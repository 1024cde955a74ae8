"""`planarc doc`: the handbook of a library as one HTML page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planarc.cli import console
from planarc.cli.arguments import Libraries, offers, open_classes, output_option


def doc(
    target: Annotated[
        str | None,
        typer.Argument(
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
) -> int:
    """Write a page that describes all classes of a library.

    Tree, descriptions, icons, parameters with units and defaults, equations and source,
    with links between the classes. The page needs no network.
    """
    from planarc.catalog.handbook.gather import gather
    from planarc.catalog.handbook.page import write_handbook
    from planarc.cli.files import page_destination

    classes, names = open_classes(target, library)
    title = ", ".join(names)
    path = page_destination(title if len(names) == 1 else "libraries", output)
    pages = gather(classes, names)
    write_handbook(path, title, pages)
    console.say(f"written    {path} ({len(pages)} classes)")
    return 0
