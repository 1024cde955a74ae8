"""What a place in a text can name, and what the names there mean.

In:   Scope        of a class, opened as a class: no sizes and conditions are evaluated
Out:  Element      the declaration behind a name, whose definition has its place in a text
      Candidate    a name that may be written there

Made for those who look at texts that may be wrong: a class is opened without the elements that
stand in the way, such as an `extends` of nothing.

Example: in `model M  extends Nothing;  Real x; end M;` the name `x` is found.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.flatten.library.library import split_name
from planarc.flatten.tree import lookup, predefined
from planarc.flatten.tree.demand import class_of, layout_of, static_instance
from planarc.flatten.tree.inherit import make_layout
from planarc.flatten.tree.modify import merge
from planarc.flatten.tree.nodes import Class, Element, Instance, Layout, Scope, Session
from planarc.flatten.tree.redeclare import effective_component
from planarc.ir import syntax

_TRIES = 20


def lenient_layout(cls: Class) -> Layout:
    """The layout of a class without what is wrong in it."""
    for _ in range(_TRIES):
        try:
            return make_layout(cls)
        except PlanarcError as problem:
            cls.definition = _without(cls.definition, problem)
    cls.definition = replace(cls.definition, body=syntax.Composition(cls.definition.span))
    return make_layout(cls)


def _without(definition: syntax.ClassDef, problem: PlanarcError) -> syntax.ClassDef:
    """A class without the elements that an error points at; else without bases; else empty."""
    composition = definition.composition
    if composition is None:
        return replace(definition, body=syntax.Composition(definition.span))
    spans = [d.span for d in problem.diagnostics if d.span is not None]
    kept = tuple(
        e
        for e in composition.elements
        if not any(
            e.span.start <= s.start < e.span.end and e.span.source is s.source for s in spans
        )
    )
    if len(kept) == len(composition.elements):
        kept = tuple(e for e in kept if not isinstance(e, syntax.Extends))
    if len(kept) == len(composition.elements):
        kept = ()
    return replace(definition, body=replace(composition, elements=kept))


def open_class(session: Session, name: str) -> Class | None:
    """A class by its full name. Raises PlanarcError where its file is wrong."""
    cls: Class | None = None
    instance = session.root_scope.instance
    for step in split_name(name):
        element = lookup.member(instance, step)
        if element is None or not element.is_class:
            return None
        cls = class_of(element)
        instance = static_instance(cls)
    return cls


def scope_of(cls: Class) -> Scope:
    """The scope of a class's own text."""
    return static_instance(cls).scope()


def class_behind(element: Element) -> Class:
    """The class of a component, or the one that a class element stands for."""
    if element.is_class:
        return class_of(element)
    definition, scope, _ = effective_component(element)
    return lookup.find_class(scope, definition.type)


def opened(element: Element) -> Instance:
    """An element opened as a class: its members, redeclared as its modifiers say."""
    if element.is_class:
        return static_instance(class_of(element))
    definition, scope, mod = effective_component(element)
    cls = lookup.find_class(scope, definition.type)
    mod = merge(mod, cls.mod, element.name) if cls.mod else mod
    parent = element.scope.instance
    return Instance(cls, layout_of(cls), None, mod, parent, parent.session)


def find_path(scope: Scope, names: Iterable[str], absolute: bool = False) -> list[Element]:
    """The elements that the names of a reference mean, as far as they are found."""
    first, *rest = names
    root = scope.session.root_scope.instance
    if absolute:
        element = lookup.member(root, first)
    else:
        found = lookup.find(scope, first)
        element = None if found is None else found[0]
    elements: list[Element] = []
    while element is not None:
        elements.append(element)
        if len(elements) > len(rest):
            break
        try:
            element = lookup.member(opened(element), rest[len(elements) - 1])
        except PlanarcError:
            break
    return elements


class Candidate(Data):
    """A name in sight. `declaration` is None for a class whose file nobody has read."""

    name: str
    declaration: syntax.Declaration | None
    protected: bool = False
    depth: int = 0  # classes between it and the place


def members(instance: Instance, classes: bool = True) -> Iterator[Candidate]:
    """The members of an instance, inherited ones too; last the classes that have own files."""
    layout = instance.layout
    for name, (index, declaration) in layout.members.items():
        if classes or isinstance(declaration, syntax.Component):
            hidden = declaration.prefixes.protected or layout.parts[index].protected
            yield Candidate(name, declaration, hidden)
    if not classes:
        return
    for part in layout.parts:
        entry = part.cls.entry
        if entry is not None and entry.open:
            for name in entry.child_names():
                if name not in layout.members:
                    yield Candidate(name, None)


def in_sight(scope: Scope) -> Iterator[Candidate]:
    """All that a text can name without a dot, the nearest first."""
    current: Scope | None = scope
    depth = 0
    while current is not None:
        for found in members(current.instance):
            yield replace(found, depth=depth)
        for clause in current.part.imports:
            yield from (replace(c, depth=depth) for c in _imported(current, clause))
        encapsulated = current.part.definition.encapsulated
        current = None if encapsulated else current.parent
        depth += 1
    for name in scope.session.library.top_names():
        yield Candidate(name, None, depth=depth)
    for name in predefined.NAMES:
        yield Candidate(name, None, depth=depth)


def _imported(scope: Scope, clause: syntax.Import) -> Iterator[Candidate]:
    root = scope.session.root_scope
    if clause.wildcard:
        found = find_path(root, clause.path)
        if len(found) == len(clause.path) and found[-1].is_class:
            yield from (c for c in members(opened(found[-1])) if not c.protected)
        return
    for name in clause.names or (clause.alias or clause.path[-1],):
        # Not by the name: in a text that is being written, a component may hide it.
        path = (*clause.path, name) if clause.names else clause.path
        found = find_path(root, path)
        yield Candidate(name, found[-1].definition if len(found) == len(path) else None)
