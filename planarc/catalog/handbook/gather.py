"""The contents of a handbook, gathered from the classes of a library.

In:   Library, names of classes
Out:  ClassPage   for each of them and all classes in them, parents before children

A class that cannot be read gets no page: `planarc check --all` tells what is wrong with it.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from planarc.catalog.handbook.graphics import graphics_of, placed
from planarc.catalog.handbook.head import head_of
from planarc.catalog.handbook.names import Names, elements
from planarc.catalog.handbook.pages import ClassPage, Graphic, Icon, Link, Placed, Row
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.flatten.library.library import Entry, Library
from planarc.flatten.tree.annotation import binding_of, find_argument, inside
from planarc.ir import syntax
from planarc.ir.text.expression import expression_text

_CONNECTORS = (syntax.ClassKind.CONNECTOR, syntax.ClassKind.EXPANDABLE_CONNECTOR)
_PACKAGES = (syntax.ClassKind.PACKAGE,)
_MODELS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK, syntax.ClassKind.CLASS)


def gather(library: Library, names: Sequence[str]) -> tuple[ClassPage, ...]:
    """Pages of the named classes and of all classes in them."""
    return tuple(_Gatherer(library).pages(names))


def page_of(library: Library, entry: Entry) -> ClassPage:
    """The page of one class. Raises PlanarcError where it cannot be read."""
    return _Gatherer(library).page(entry)


class _Gatherer:
    def __init__(self, library: Library) -> None:
        self._library = library
        self._names = Names(library)
        self._icons: dict[str, Icon] = {}

    def pages(self, names: Sequence[str]) -> Iterator[ClassPage]:
        stack = [self._library.entry(name) for name in reversed(names)]
        while stack:
            entry = stack.pop()
            if entry is None:
                continue
            try:
                page = self.page(entry)
            except PlanarcError:
                continue
            yield page
            stack.extend(self._library.entry(name) for name in reversed(page.children))

    def page(self, entry: Entry) -> ClassPage:
        children = [c for c in map(entry.child, entry.child_names()) if _is_public(c)]
        definition = entry.definition
        annotation = self._annotation(definition.annotation)
        info = binding_of(find_argument(inside(find_argument(annotation, "Documentation")), "info"))
        partial = "partial " if definition.partial else ""
        # The text of a package whose classes stand in it is that of its classes.
        whole = definition.kind not in _PACKAGES or not any(
            isinstance(e, syntax.ClassDef) for e in elements(definition)
        )
        return ClassPage(
            name=entry.full_name,
            kind=partial + definition.kind.value,
            comment=definition.comment,
            info=info.value if isinstance(info, syntax.String) else "",
            icon=self.icon(entry),
            bases=tuple(self._base_links(entry)),
            children=tuple(c.full_name for c in children if c is not None),
            tables=self._tables(entry),
            equations=tuple(_sections(definition)),
            source=_dedent(definition.span) if whole else "",
            file=definition.span.source.name,
            head=(*_told(definition.span.text), *self._says(entry)),
            inherited=tuple(self._inherited(entry)),
        )

    def _inherited(self, entry: Entry) -> Iterator[tuple[Link, tuple[str, ...]]]:
        """The sections of base classes, the deepest first."""
        for part in self._names.lineage(entry):
            sections = () if part is entry else tuple(_sections(part.definition))
            if sections:
                yield Link(part.full_name, part.full_name), sections

    def _says(self, entry: Entry) -> Iterator[tuple[str, str]]:
        """The declarations of a class's energy and events, its own and those of its bases."""
        energies: dict[str, str] = {}
        events: dict[str, None] = {}
        for part in self._names.lineage(entry):
            own = inside(find_argument(self._annotation(part.definition.annotation), "__planarc"))
            for kind in inside(find_argument(own, "energy")):
                if isinstance(kind, syntax.ElementModification):
                    value, rate = binding_of(kind), binding_of(find_argument(inside(kind), "rate"))
                    shown = rate if value is None else value
                    name = kind.name[0] if shown is value else f"rate of {kind.name[0]}"
                    energies[name] = "" if shown is None else expression_text(shown)
            happens = inside(find_argument(own, "event"))
            named = (e.name[0] for e in happens if isinstance(e, syntax.ElementModification))
            events |= dict.fromkeys(name.strip("'") for name in named)
        if energies:
            yield "Energy", "\n".join(f"{name} = {text}" for name, text in energies.items())
        if events:
            yield "Events", "; ".join(events)

    def _annotation(self, annotation: syntax.Annotation | None) -> tuple[syntax.Argument, ...]:
        return () if annotation is None else self._library.parse_annotation(annotation)

    # Icons ------------------------------------------------------------------------------

    def icon(self, entry: Entry) -> Icon:
        """The graphics of a class, inherited ones below its own, and its connectors."""
        known = self._icons.get(entry.full_name)
        if known is not None:
            return known
        self._icons[entry.full_name] = Icon()  # a connector may hold itself in a wrong library
        graphics: list[Graphic] = []
        connectors: list[Placed] = []
        for part in self._names.lineage(entry):
            annotation = self._annotation(part.definition.annotation)
            graphics += graphics_of(annotation)
            if entry.definition.kind not in _CONNECTORS:
                for component in _public(part.definition):
                    connectors += self._connector(part, component)
        icon = self._icons[entry.full_name] = Icon(tuple(graphics), tuple(connectors))
        return icon

    def _connector(self, scope: Entry, component: syntax.Component) -> Iterator[Placed]:
        cls = self._type(scope, component)
        if cls is not None and cls.definition.kind in _CONNECTORS:
            place = placed(self._annotation(component.annotation), self.icon(cls))
            if place is not None:
                yield place

    # Tables -----------------------------------------------------------------------------

    def _tables(self, entry: Entry) -> tuple[tuple[str, tuple[Row, ...]], ...]:
        found: dict[str, list[Row]] = {h: [] for h in _HEADINGS}
        if isinstance(entry.definition.body, syntax.Enumeration):
            literals = entry.definition.body.literals or ()
            found["Values"] = [Row(v.name, Link(entry.name), comment=v.comment) for v in literals]
        changed = self._changes(entry)
        for part in reversed(self._names.lineage(entry)):  # its own come first
            origin = None if part is entry else Link(f"from {part.name}", part.full_name)
            for component in _public(part.definition):
                cls = self._type(part, component)
                heading = _heading(component, cls)
                value = changed.get(component.name) or _value(component)
                found[heading].append(
                    Row(
                        component.name + _dimensions(component),
                        Link(str(component.type), None if cls is None else cls.full_name),
                        value,
                        self._unit(component, cls),
                        component.comment,
                        origin,
                    )
                )
        return tuple((heading, tuple(rows)) for heading, rows in found.items() if rows)

    def _changes(self, entry: Entry) -> dict[str, str]:
        """New values that extends clauses give to inherited components, the outermost wins."""
        found: dict[str, str] = {}
        for part in self._names.lineage(entry):
            for element in elements(part.definition):
                if isinstance(element, syntax.Extends) and element.modification is not None:
                    for a in element.modification.arguments:
                        if isinstance(a, syntax.ElementModification) and len(a.name) == 1:
                            value = binding_of(a)
                            if value is not None:
                                found[a.name[0]] = expression_text(value)
        return found

    def _type(self, scope: Entry, component: syntax.Component) -> Entry | None:
        return self._names.resolve(scope, component.type.names, component.type.absolute)

    def _unit(self, component: syntax.Component, cls: Entry | None) -> str:
        """The unit that the declaration gives, or the type, or what the type stands for."""
        unit = _unit_in(component.modification)
        for part in reversed(self._names.lineage(cls)) if cls is not None else ():
            body = part.definition.body
            if unit is None and isinstance(body, syntax.ShortClass):
                unit = _unit_in(body.modification)
        return unit or ""

    def _base_links(self, entry: Entry) -> Iterator[Link]:
        for base in self._names.bases(entry):
            yield Link(base.full_name, base.full_name)


def _told(text: str) -> list[tuple[str, str]]:
    """What the head of a class says to whoever uses it: not by which tests it is held."""
    return [(keyword, told) for keyword, told in head_of(text) if keyword != "Check"]


_HEADINGS = (
    "Values",
    "Parameters",
    "Constants",
    "Connectors",
    "Inputs and outputs",
    "Components",
    "Variables",
)


def _heading(component: syntax.Component, cls: Entry | None) -> str:
    match component.variability:
        case syntax.Variability.PARAMETER:
            return "Parameters"
        case syntax.Variability.CONSTANT:
            return "Constants"
    if cls is not None and cls.definition.kind in _CONNECTORS:
        return "Connectors"
    if component.causality is not syntax.Causality.NONE:
        return "Inputs and outputs"
    return "Components" if cls is not None and cls.definition.kind in _MODELS else "Variables"


def _is_public(entry: Entry | None) -> bool:
    return entry is not None and not entry.definition.prefixes.protected


def _public(definition: syntax.ClassDef) -> Iterator[syntax.Component]:
    for element in elements(definition):
        if isinstance(element, syntax.Component) and not element.prefixes.protected:
            yield element


def _value(component: syntax.Component) -> str:
    modification = component.modification
    if modification is None:
        return ""
    if modification.binding is not None:
        return expression_text(modification.binding)
    start = binding_of(find_argument(modification.arguments, "start"))
    return "" if start is None else f"start {expression_text(start)}"


def _unit_in(modification: syntax.Modification | None) -> str | None:
    value = binding_of(find_argument(modification.arguments, "unit")) if modification else None
    return value.value if isinstance(value, syntax.String) else None


def _dimensions(component: syntax.Component) -> str:
    sizes = (*component.dimensions, *component.type_dimensions)
    return f"[{','.join(map(expression_text, sizes))}]" if sizes else ""


def _sections(definition: syntax.ClassDef) -> Iterator[str]:
    body = definition.body
    if isinstance(body, syntax.ExtendsClass):
        body = body.composition
    if isinstance(body, syntax.Composition):
        end = None if definition.annotation is None else definition.annotation.span.start
        for section in body.sections:
            span = section.span
            if end is not None and span.start < end < span.end:  # the class's annotation
                span = span._replace(end=end)
                yield _dedent(span).removesuffix("annotation").rstrip()
            else:
                yield _dedent(span)


def _dedent(span: Span) -> str:
    """The text of a span, moved to the left as a whole."""
    return textwrap.dedent(" " * (span.column - 1) + span.text).rstrip()
