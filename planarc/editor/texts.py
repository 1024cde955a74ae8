"""The texts that are open in an editor, each read as far as it can be.

A text on which somebody types is wrong most of the time. So it is read with its slips mended,
and of a class that is broken the last good tree is kept: other classes that use it are checked
against that one.

    model A ... end A;      good: A, B           model A Real x    broken: A
    model B  A a; end B;                    ->   model B  A a; end B;      checked with the old A
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError, mistake
from planarc.core.source import Source, Span
from planarc.ir import syntax
from planarc.parse.parser import read

Classes = dict[str, syntax.ClassDef]


class Text:
    """One edition of a text. Immutable, but read only when asked for."""

    def __init__(self, path: Path, content: str, version: int = 0, good: Classes | None = None):
        self.path, self.version = path, version
        self.source = Source(str(path), content.replace("\r\n", "\n"), path)
        self._good = good or {}

    @cached_property
    def _read(self) -> tuple[syntax.StoredDefinition, tuple[Diagnostic, ...]]:
        span = Span(self.source, 0, len(self.source.text))
        empty = syntax.StoredDefinition(span, ())
        try:
            found = read("stored_definition", span)
        except PlanarcError as problem:
            return empty, problem.diagnostics
        except Exception as problem:  # a mistake of ours: the server goes on
            return empty, (mistake(problem),)
        return found.tree or empty, found.errors

    @property
    def tree(self) -> syntax.StoredDefinition:
        """The tree of this edition, slips mended."""
        return self._read[0]

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The mistakes of syntax in the text."""
        return self._read[1]

    @cached_property
    def classes(self) -> Classes:
        """The classes of the text by their full names, each before those in it."""
        return dict(classes_in(self.tree))

    @cached_property
    def broken(self) -> frozenset[str]:
        """The classes in whose own text, not in that of a class inside, syntax is wrong."""
        return frozenset(
            name
            for name, definition in self.classes.items()
            if any(_is_own(definition, e) for e in self.errors)
        )

    @cached_property
    def good(self) -> Classes:
        """The last good trees of its classes."""
        if not self.errors:
            return self.classes
        return self._good | {n: c for n, c in self.classes.items() if n not in self.broken}

    @cached_property
    def steady(self) -> syntax.StoredDefinition:
        """The tree with last good classes in the place of broken ones."""
        if not self.errors:
            return self.tree
        prefix = ".".join(self.tree.within or ())
        kept = self._lost(prefix)
        classes = tuple(self._steady(c, _joined(prefix, c.name)) for c in self.tree.classes)
        unique = {c.name: c for c in (*kept, *reversed(classes))}
        return replace(self.tree, classes=tuple(unique.values()))

    def _steady(self, definition: syntax.ClassDef, name: str) -> syntax.ClassDef:
        if name in self.broken and definition.kind is not syntax.ClassKind.PACKAGE:
            return self._good.get(name, definition)
        body = definition.body
        if not isinstance(body, syntax.Composition):
            return definition
        elements = tuple(
            self._steady(e, f"{name}.{e.name}") if isinstance(e, syntax.ClassDef) else e
            for e in body.elements
        )
        kept = self._lost(name) if name in self.broken else ()
        return replace(definition, body=replace(body, elements=(*elements, *kept)))

    def _lost(self, package: str) -> tuple[syntax.ClassDef, ...]:
        """Classes that were there, and still begin in the text, but could not be read."""
        start = len(package) + 1 if package else 0
        return tuple(
            definition
            for name, definition in self._good.items()
            if name.rpartition(".")[0] == package
            and name not in self.classes
            and re.search(rf"\b[a-z]+\s+{re.escape(name[start:])}\b", self.source.text)
        )

    def chain(self, offset: int) -> tuple[str, tuple[syntax.ClassDef, ...]]:
        """The classes around a place, the outermost first, and the package that holds them."""
        found: list[syntax.ClassDef] = []
        inside = [c for c in self.tree.classes if _holds(c, offset)]
        while inside:
            found.append(inside[-1])
            inside = [c for c in nested(inside[-1]) if _holds(c, offset)]
        return ".".join(self.tree.within or ()), tuple(found)

    def class_at(self, offset: int) -> str:
        """The full name of the innermost class around a place; "" outside of all."""
        package, chain = self.chain(offset)
        names = [c.name for c in chain]
        return ".".join(([package] if package and names else []) + names)


def classes_in(tree: syntax.StoredDefinition) -> Iterator[tuple[str, syntax.ClassDef]]:
    """All classes of a file by their full names, each before those in it."""
    prefix = ".".join(tree.within or ())
    stack = [(_joined(prefix, c.name), c) for c in reversed(tree.classes)]
    while stack:
        name, definition = stack.pop()
        yield name, definition
        stack += [(f"{name}.{c.name}", c) for c in reversed(list(nested(definition)))]


def nested(definition: syntax.ClassDef) -> Iterator[syntax.ClassDef]:
    composition = definition.composition
    elements = () if composition is None else composition.elements
    return (e for e in elements if isinstance(e, syntax.ClassDef))


def _joined(package: str, name: str) -> str:
    return f"{package}.{name}" if package else name


def _holds(definition: syntax.ClassDef, offset: int) -> bool:
    return definition.span.start <= offset <= definition.span.end


def _is_own(definition: syntax.ClassDef, error: Diagnostic) -> bool:
    if error.span is None or not _holds(definition, error.span.start):
        return False
    return not any(_holds(c, error.span.start) for c in nested(definition))


class Texts:
    """The open texts by their paths; what is not saved has a path of its own, such as
    `untitled:1`."""

    def __init__(self) -> None:
        self._open: dict[Path, Text] = {}

    def put(self, path: Path, content: str, version: int = 0) -> Text:
        """A new edition of a text."""
        before = self._open.get(path)
        good = None if before is None else before.good
        self._open[path] = Text(path, content, version, good)
        return self._open[path]

    def close(self, path: Path) -> None:
        self._open.pop(path, None)

    def get(self, path: Path) -> Text | None:
        return self._open.get(path)

    def __iter__(self) -> Iterator[Text]:
        return iter(tuple(self._open.values()))
