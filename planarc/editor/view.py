"""The names around a text: its classes opened as far as they can be, for lookups.

A view belongs to one edition of the open texts. It is made at once; classes are opened, and files
of libraries read, when somebody asks.
"""

from __future__ import annotations

from functools import cached_property

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import MAKERS, open_session
from planarc.flatten.tree import sight
from planarc.flatten.tree.nodes import Class, Scope, Session

#: The passes for whoever looks at texts that may be wrong.
LENIENT = replace(MAKERS, layout=sight.lenient_layout)


class View:
    def __init__(self, shelf: Shelf, text: Text) -> None:
        self.text, self._shelf = text, shelf

    @cached_property
    def session(self) -> Session:
        return open_session(self.library, LENIENT)

    @cached_property
    def library(self) -> Library:
        try:
            return self._shelf.target(self.text, steady=False).library
        except PlanarcError:  # a class twice, or a package that is not there
            return self._shelf.around(self.text)

    def class_at(self, offset: int) -> str:
        """The full name of the innermost class around a place; "" outside of all."""
        return self.text.class_at(offset)

    def scope_at(self, offset: int) -> Scope:
        """The scope of the innermost class around a place that can be opened."""
        package, chain = self.text.chain(offset)
        return self.scope(package, tuple(c.name for c in chain))

    def scope_of(self, owner: tuple[str, ...]) -> Scope:
        """The scope of a class of the text, by the names of the classes around and its own."""
        return self.scope(".".join(self.text.tree.within or ()), owner)

    def package(self) -> Scope:
        """The scope of the package that holds the text's classes."""
        package = tuple(self.text.tree.within or ())
        return self.scope("", package) if package else self.session.root_scope

    def scope(self, package: str, names: tuple[str, ...]) -> Scope:
        """The scope of a class in a package, or of the next one around it."""
        for count in range(len(names), 0, -1):
            cls = self.find(".".join(([package] if package else []) + list(names[:count])))
            if cls is not None:
                try:
                    return sight.scope_of(cls)
                except PlanarcError:
                    continue
        return self.session.root_scope

    def find(self, name: str) -> Class | None:
        """A class by its full name; None where there is none, or its file cannot be read."""
        try:
            return sight.open_class(self.session, name)
        except PlanarcError:
            return None
