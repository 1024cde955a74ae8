"""`planarc list`: the classes of a file or of a library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.arguments import Libraries, offers, open_classes
from planarc.cli.line import Argument
from planarc.core.source import model_files

if TYPE_CHECKING:
    from planarc.flatten.library.library import Entry, Library


def list_classes(
    target: Annotated[
        str | None,
        Argument(
            metavar="[FILE|FOLDER|PACKAGE]",
            help="A .pmo or .mo file, a folder or a package; without, all libraries.",
            autocompletion=offers("models"),
        ),
    ] = None,
    library: Libraries = None,
) -> int:
    """List classes with their kinds and descriptions."""
    console.say("\n".join(map(_line, _found(target, library or ()))))
    return 0


def _found(target: str | None, libraries: Sequence[Path]) -> Iterable[Entry]:
    if target is not None and Path(target).is_dir():
        return _in_folder(Path(target), libraries)
    classes, names = open_classes(target, libraries)
    return _entries(classes, names) if target is None else _below(classes, names)


def _in_folder(folder: Path, libraries: Sequence[Path]) -> Iterator[Entry]:
    """The packages in a folder, or the one that it is, and files that stand by themselves."""
    around = [folder, *libraries]
    classes, _ = open_classes(None, around)
    own = type(classes)((folder,), classes.parse_file, classes.parse_annotation)
    found = [entry.full_name for entry in _entries(own, own.top_names())]
    yield from _below(own, found)
    if own.package_file(folder) is None:
        for file in model_files(folder):
            alone, names = open_classes(str(file), around)
            yield from _below(alone, [n for n in names if n not in found])


def _entries(classes: Library, names: Sequence[str]) -> Iterator[Entry]:
    for name in names:
        entry = classes.entry(name)
        if entry is not None and _is_held(entry):
            yield entry


def _is_held(entry: Entry) -> bool:
    """False for the name of a file that holds no such class, as scripts beside packages do."""
    from planarc.flatten.library.library import Misnamed

    try:
        return bool(entry.definition)
    except Misnamed:
        return False


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
