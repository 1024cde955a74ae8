"""The things that a compilation looked for, found or not, to tell whether they are the same today.

The files that it read are not enough: a class file added to a folder may hide a class that was
found further out, and a model may ask for a file that is not there, or by a relative name.
"""

from __future__ import annotations

import os
from pathlib import Path
from stat import S_IFMT

from msgspec import Struct, field

from planarc.core.digest import blake2b
from planarc.core.source import SUFFIXES

#: Folders with their listings; names as they were asked for, with what they meant; files of data
#: with what they held.
Findings = tuple[list[tuple[str, str]], list[tuple[str, str, int]], list[tuple[str, str]]]


class Looked(Struct):
    """Folders that were searched for classes, files that the model itself asks for, and those of
    them whose contents it reads.

    With `open_questions` it asks for more while its equations are made.
    """

    folders: set[Path] = field(default_factory=set)
    names: set[str] = field(default_factory=set)
    contents: set[str] = field(default_factory=set)
    open_questions: bool = False

    def findings(self) -> Findings:
        """The things as they are now, as plain data."""
        folders = sorted(os.path.abspath(path) for path in self.folders)  # noqa: PTH100
        held = [(f, _held(f)) for f in sorted(os.path.abspath(n) for n in self.contents)]  # noqa: PTH100
        return [(f, _listing(f)) for f in folders], [_meaning(n) for n in sorted(self.names)], held


def same(findings: Findings) -> bool:
    """True when a look would find the same now."""
    folders, names, held = findings
    return (
        all(_listing(f) == listing for f, listing in folders)
        and all(_meaning(found[0]) == tuple(found) for found in names)
        and all(_held(f) == digest for f, digest in held)
    )


def _listing(folder: str) -> str:
    """Changes with what may be classes in a folder; empty where it cannot be listed."""
    try:
        with os.scandir(folder) as inside:
            names = sorted(e.name for e in inside if e.name.endswith(SUFFIXES) or e.is_dir())
    except OSError:
        return ""
    return blake2b(os.fsencode("\0".join(names)), digest_size=16).hexdigest()


def _held(file: str) -> str:
    """Changes with what a file holds; empty where it cannot be read."""
    try:
        return blake2b(Path(file).read_bytes(), digest_size=16).hexdigest()
    except OSError:
        return ""


def _meaning(name: str) -> tuple[str, str, int]:
    """A name, the place that it means from here, and what kind of thing is there."""
    path = Path(name).absolute()
    try:
        return name, str(path), S_IFMT(path.stat().st_mode)
    except (OSError, ValueError):
        return name, str(path), 0
