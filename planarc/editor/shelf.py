"""Libraries as an editor sees them: read lazily, open texts in the place of their files.

A file of a library is parsed when a class in it is asked for, and again when it has changed on
disk; its tree is shared by all that is looked up, by whichever thread.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from msgspec import field
from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError
from planarc.core.resources import stdlib
from planarc.editor.texts import Text, Texts
from planarc.flatten.library.library import EXTENSIONS, Library
from planarc.ir import syntax
from planarc.parse.parser import parse_annotation, read
from planarc.request.reader import Reader
from planarc.request.request import DECLARED, Request, Target, roots_of

Stamp: TypeAlias = tuple[int, int]
Kept: TypeAlias = dict[Path, tuple[Stamp, syntax.StoredDefinition]]


class _Reader(Reader):
    """A reader that takes open texts first, and keeps what it parsed."""

    texts: Texts = field(default_factory=Texts)
    kept: Kept = field(default_factory=dict)
    steady: bool = True

    def __call__(self, path: Path) -> syntax.StoredDefinition:
        text = self.texts.get(path)
        if text is not None:
            return text.steady if self.steady else text.tree
        stamp = _stamp(path)
        known = self.kept.get(path)
        if known is None or stamp is None or known[0] != stamp:
            stored = Reader.__call__(self, path)
            if stamp is not None:
                self.kept[path] = stamp, stored
            return stored
        return known[1]

    def annotation(self, annotation: syntax.Annotation) -> tuple[syntax.Argument, ...]:
        path = annotation.span.source.path
        if path is None or self.texts.get(path) is None:
            return parse_annotation(annotation)
        found = read("annotation_text", annotation.span)  # of a passing edition: not kept
        if found.errors:
            raise PlanarcError(found.errors)
        arguments: tuple[syntax.Argument, ...] = found.tree or ()
        return arguments


def _stamp(path: Path) -> Stamp | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


class Shelf:
    """The open texts, with the libraries around each."""

    def __init__(self, texts: Texts, libraries: Sequence[Path] = ()) -> None:
        self.texts, self.libraries = texts, tuple(libraries)
        self._kept: Kept = {}

    def target(self, text: Text, steady: bool = True) -> Target:
        """The libraries around a text, with the text in them. `class_name` stays empty.

        Without `steady`, broken classes are as their mended text says. Raises PlanarcError.
        """
        reader = _Reader(texts=self.texts, kept=self._kept, steady=steady)
        library = Library(self.roots(text.path), reader, reader.annotation, [DECLARED])
        tree = text.steady if steady else text.tree
        if not self._is_inside(library, text):
            library.add_file(tree)
        return Target(library, "", reader)

    def around(self, text: Text) -> Library:
        """The libraries around a text that cannot be taken into them as it is."""
        reader = _Reader(texts=self.texts, kept=self._kept, steady=False)
        library = Library(self.roots(text.path), reader, reader.annotation, [DECLARED])
        unique = {c.name: c for c in reversed(text.tree.classes)}
        library.add_file(replace(text.tree, classes=tuple(unique.values()), within=None))
        return library

    def named(self, path: Path) -> tuple[Path, ...]:
        """The package around a file, and the libraries of the settings that are there."""
        around = package_around(path)
        named = [p for p in self.libraries if p.exists()]
        return (*((around,) if around else ()), *named)

    def roots(self, path: Path) -> tuple[Path, ...]:
        """The roots of libraries: those named, those of MODELICAPATH, our own."""
        return roots_of(Request(libraries=self.named(path)))

    def _is_inside(self, library: Library, text: Text) -> bool:
        """True where the file of a text is found as one of a library's."""
        name = next(iter(text.classes), None)
        if name is None or not text.path.is_absolute():
            return False
        try:
            entry = library.entry(name)
        except PlanarcError:
            return False
        return entry is not None and entry.file == text.path


def package_around(path: Path) -> Path | None:
    """The folder of the outermost package that a file belongs to."""
    found = None
    for folder in path.parents if path.is_absolute() else ():
        if not any((folder / f"package{e}").is_file() for e in EXTENSIONS):
            break
        found = folder
    return found


def is_own(path: Path) -> bool:
    """True for a file of planarc's own libraries."""
    return path.is_relative_to(stdlib())


def is_writable(path: Path) -> bool:
    return not is_own(path) and (not path.exists() or os.access(path, os.W_OK))
