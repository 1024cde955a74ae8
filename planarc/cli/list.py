"""`planarc list`: the classes of a file or of a library."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.arguments import Libraries, offers, open_classes
from planarc.cli.line import Argument

if TYPE_CHECKING:
    from planarc.flatten.library.library import Entry, Library


def list_classes(
    target: Annotated[
        str | None,
        Argument(
            metavar="[FILE|PACKAGE]",
            help="A .pmo or .mo file, or a package; without, the libraries that are found.",
            autocompletion=offers("models"),
        ),
    ] = None,
    library: Libraries = None,
) -> int:
    """List classes with their kinds and descriptions."""
    if target is not None and Path(target).is_dir():
        classes, _ = open_classes(None, [Path(target), *(library or ())])
        own = type(classes)((Path(target),), classes.parse_file, classes.parse_annotation)
        names = own.top_names()
    else:
        classes, names = open_classes(target, library)
    found = _entries(classes, names) if target is None else _below(classes, names)
    console.say("\n".join(_line(entry) for entry in found))
    return 0


def _entries(classes: Library, names: Sequence[str]) -> Iterator[Entry]:
    for name in names:
        entry = classes.entry(name)
        if entry is not None:
            yield entry


def _below(classes: Library, names: Sequence[str]) -> tuple[Entry, ...]:
    """The named classes and all that they hold, parents before children."""
    found = []
    stack = list(_entries(classes, names))[::-1]
    while stack:
        entry = stack.pop()
        found.append(entry)
        children = (entry.child(name) for name in reversed(entry.child_names()))
        stack.extend(child for child in children if child is not None)
    return tuple(found)


def _line(entry: Entry) -> str:
    definition = entry.definition
    kind = f"partial {definition.kind.value}" if definition.partial else definition.kind.value
    comment = f' "{definition.comment}"' if definition.comment else ""
    return console.plain(f"{kind} {entry.full_name}{comment}")
