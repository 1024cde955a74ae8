"""The meaning of names in a library, as far as text can tell.

In:   Entry, a name as it is written there
Out:  Entry   the class, None when it is predefined or cannot be found

The same search as `flatten.tree.lookup`, without modifiers and redeclarations: own
classes, those of base classes, imports, then outwards. Enough for links.

Example: `SI.Force` in `PlanarMultiBody.Forces.Spring` is `Modelica.Units.SI.Force`.

Reference: Modelica Language Specification 3.6, sections 5.3 and 13.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.library.library import Entry, Library
from planarc.ir import syntax


class Names:
    """Looks names up in one library, and remembers what it found."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self._found: dict[tuple[str, str], Entry | None] = {}
        self._bases: dict[str, tuple[Entry, ...]] = {}

    def resolve(
        self, scope: Entry | None, names: Sequence[str], absolute: bool = False
    ) -> Entry | None:
        """The class that a name means in a class."""
        if not names:
            return None
        entry = self._library.top(names[0]) if absolute else self._first(scope, names[0])
        for name in names[1:]:
            if entry is None:
                return None
            entry = self._member(entry, name)
        return entry

    def parent(self, entry: Entry) -> Entry | None:
        package = entry.full_name.rpartition(".")[0]
        return self._library.entry(package) if package else None

    def bases(self, entry: Entry) -> tuple[Entry, ...]:
        """The classes that a class extends, those that can be found."""
        known = self._bases.get(entry.full_name)
        if known is None:
            # Names in an extends clause are looked up while the bases are not known yet.
            self._bases[entry.full_name] = ()
            found = (self.resolve(entry, r.names, r.absolute) for r in base_refs(entry.definition))
            known = tuple(base for base in found if base is not None and base is not entry)
            self._bases[entry.full_name] = known
            self._found.clear()
        return known

    def lineage(self, entry: Entry) -> tuple[Entry, ...]:
        """All base classes of a class, the deepest first, and the class itself."""
        order: dict[str, Entry] = {}
        stack: list[tuple[Entry, bool]] = [(entry, False)]
        entered: set[str] = set()
        while stack:
            item, done = stack.pop()
            if done:
                order[item.full_name] = item
            elif item.full_name not in entered:
                entered.add(item.full_name)
                stack.append((item, True))
                stack.extend((base, False) for base in reversed(self.bases(item)))
        return tuple(order.values())

    def _first(self, scope: Entry | None, name: str) -> Entry | None:
        key = (scope.full_name if scope else "", name)
        if key in self._found:
            return self._found[key]
        self._found[key] = None
        found = None
        here = scope
        while here is not None and found is None:
            found = self._member(here, name) or self._imported(here, name)
            here = None if here.definition.encapsulated else self.parent(here)
        if found is None:
            found = self._library.top(name)
        self._found[key] = found
        return found

    def _member(self, entry: Entry, name: str) -> Entry | None:
        for part in reversed(self.lineage(entry)):
            try:
                child = part.child(name)
            except PlanarcError:
                continue
            if child is not None:
                return child
        return None

    def _imported(self, entry: Entry, name: str) -> Entry | None:
        for element in elements(entry.definition):
            if not isinstance(element, syntax.Import):
                continue
            if element.wildcard or name in element.names:
                package = self._library.entry(".".join(element.path))
                found = None if package is None else self._member(package, name)
                if found is not None:
                    return found
            elif not element.names and name == (element.alias or element.path[-1]):
                return self._library.entry(".".join(element.path))
        return None


def elements(definition: syntax.ClassDef) -> tuple[syntax.Element, ...]:
    body = definition.body
    if isinstance(body, syntax.ExtendsClass):
        body = body.composition
    return body.elements if isinstance(body, syntax.Composition) else ()


def base_refs(definition: syntax.ClassDef) -> Iterator[syntax.Ref]:
    """The base classes of a class as written; a short class extends what it stands for."""
    if isinstance(definition.body, syntax.ShortClass):
        yield definition.body.base
    for element in elements(definition):
        if isinstance(element, syntax.Extends):
            yield element.base
