"""The replaceable parts of a model, and what may stand in their place.

In:   Library, the parts of a model (component, class)
Out:  Choice   a component that its class declares replaceable, with all classes that fit

What fits extends the constraining class (`constrainedby`, else the declared one) and is neither
partial nor obsolete. Looked for is in the packages of the constraining class and in the user's
file. Files of a package are only read when their text extends something of a fitting name.

Example: the cam follower of the paper's figures 4 and 5

    Choice("contact.curve1", "PlanarMultiBody.Curves.Ellipse", options=(Circle, ...))

Reference: Modelica Language Specification 3.6, sections 7.3.2 and 7.3.4.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from planarc.catalog.handbook.names import Names, elements
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import model_files
from planarc.flatten.library.library import Entry, Library
from planarc.ir import syntax
from planarc.ir.flat import Part

_EXTENDS = re.compile(r"(?:\bextends|=)\s+\.?((?:\w+\.)*\w+)")


class Option(Data):
    name: str  # of the class, in full
    description: str


class Choice(Data):
    """A replaceable component by its path, and the class that is there now."""

    component: str
    description: str
    current: str
    options: tuple[Option, ...]


def choices_of(library: Library, model: str, parts: Sequence[Part]) -> tuple[Choice, ...]:
    """All replaceable components of a model that have more than one class that fits."""
    finder = _Finder(library)
    classes = {p.name: p.class_name for p in parts}
    found = []
    for owner, class_name in {"": model, **classes}.items():
        if "[" in owner:
            continue
        for component, constraint in finder.replaceable(class_name):
            path = f"{owner}.{component.name}" if owner else component.name
            current = classes.get(path)
            if current is None:
                continue
            options = finder.fitting(constraint)
            if current not in {o.name for o in options}:
                here = finder.option(current)
                options = (here, *options) if here else options
            if len(options) > 1:
                found.append(Choice(path, component.comment, current, options))
    return tuple(found)


def numbers_of(library: Library, class_name: str) -> set[str]:
    """The public parameters of a class that a modifier may set to a number."""
    entry = library.entry(class_name)
    if entry is None:
        return set()
    return {
        element.name
        for part in Names(library).lineage(entry)
        for element in elements(part.definition)
        if isinstance(element, syntax.Component)
        and element.variability is syntax.Variability.PARAMETER
        and not (element.prefixes.final or element.prefixes.protected or element.dimensions)
    }


def _is_old(definition: syntax.ClassDef) -> bool:
    """Whether the class is kept for its name alone, which its annotation calls obsolete."""
    note = definition.annotation
    return note is not None and "obsolete" in note.span.text


class _Finder:
    def __init__(self, library: Library) -> None:
        self._library = library
        self._names = Names(library)
        self._fitting: dict[str, tuple[Option, ...]] = {}

    def replaceable(self, class_name: str) -> Iterator[tuple[syntax.Component, Entry]]:
        """The replaceable components that a class declares or inherits, with what constrains."""
        entry = self._library.entry(class_name)
        if entry is None:
            return
        for part in self._names.lineage(entry):
            for element in elements(part.definition):
                if not isinstance(element, syntax.Component) or not element.prefixes.replaceable:
                    continue
                base = element.type if element.constraint is None else element.constraint.base
                constraint = self._names.resolve(part, base.names, base.absolute)
                if constraint is not None:
                    yield element, constraint

    def option(self, class_name: str) -> Option | None:
        entry = self._library.entry(class_name)
        return None if entry is None else Option(class_name, entry.definition.comment)

    def fitting(self, constraint: Entry) -> tuple[Option, ...]:
        """The classes that extend the constraining one, in the order of their names."""
        known = self._fitting.get(constraint.full_name)
        if known is None:
            known = self._fitting[constraint.full_name] = self._find(constraint)
        return known

    def _find(self, constraint: Entry) -> tuple[Option, ...]:
        found: dict[str, Option] = {}
        for entry in (constraint, *self._candidates(constraint)):
            try:
                definition = entry.definition
                lineage = {e.full_name for e in self._names.lineage(entry)}
            except PlanarcError:  # a class that cannot be read is none to choose
                continue
            if constraint.full_name in lineage and not (definition.partial or _is_old(definition)):
                found[entry.full_name] = Option(entry.full_name, definition.comment)
        return tuple(sorted(found.values(), key=lambda o: o.name.rpartition(".")[2].lower()))

    def _candidates(self, constraint: Entry) -> Iterator[Entry]:
        """Classes whose text extends something called as the constraining class, or as a class
        that does."""
        texts = dict(self._files(constraint))
        wanted, done = {constraint.name}, set[str]()
        while True:
            reached = [n for n, bases in texts.items() if n not in done and bases & wanted]
            if not reached:
                break
            for name in reached:
                done.add(name)
                entry = self._library.entry(name)
                for inner in self._inside(entry) if entry else ():
                    wanted.add(inner.name)
                    yield inner
        for name in self._library.top_names():
            if self._library.added(name) is not None:
                entry = self._library.entry(name)
                yield from self._inside(entry) if entry else ()

    def _files(self, constraint: Entry) -> Iterator[tuple[str, set[str]]]:
        """The classes of the package's files, with the last names of what they extend."""
        top = self._library.top(constraint.full_name.partition(".")[0])
        if top is None or top.folder is None:
            return
        for path in filter(Path.is_file, model_files(top.folder, below=True)):
            folders = path.relative_to(top.folder).parts[:-1]
            last = () if path.stem == "package" else (path.stem,)
            bases = _EXTENDS.findall(path.read_text("utf-8", errors="replace"))
            yield ".".join((top.full_name, *folders, *last)), {b.rpartition(".")[2] for b in bases}

    def _inside(self, entry: Entry) -> Iterator[Entry]:
        """A class and all classes in its own text."""
        stack = [entry]
        while stack:
            item = stack.pop()
            yield item
            inner = (e.name for e in elements(item.definition) if isinstance(e, syntax.ClassDef))
            stack += [c for c in map(item.child, inner) if c is not None]
