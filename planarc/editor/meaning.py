"""What a name in a text means: the declaration behind it, wherever that stands.

In:   View, Mention
Out:  Meaning   None where nothing is found

Two mentions mean the same when their meanings have one `key`: the place of the declared name.
"""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import NOWHERE, Span
from planarc.editor.mentions import Kind, Mention, mention_at
from planarc.editor.view import View
from planarc.flatten.tree import lookup, sight
from planarc.flatten.tree.naming import name_span
from planarc.flatten.tree.nodes import Element, Instance, Scope
from planarc.ir import syntax

Key: TypeAlias = tuple[Path | str, int]


class Meaning(Data):
    """The declaration behind a name. `element` is what the stages know of a component or class;
    `literal_of` the enumeration of a literal. `attribute` is one of a predefined type, which nobody
    declares."""

    name: str
    span: Span
    element: Element | None = None
    declared: syntax.Node | None = None
    literal_of: str = ""
    attribute: bool = False

    @property
    def key(self) -> Key | None:
        if self.span is NOWHERE or self.attribute:
            return None
        source = self.span.source
        return source.path or source.name, self.span.start


def meaning_at(view: View, offset: int) -> tuple[Mention, Meaning | None] | None:
    """The name at a place of a view's text, and what it means."""
    mention = mention_at(view.text, offset)
    return None if mention is None else (mention, meaning_of(view, mention))


def meaning_of(view: View, mention: Mention) -> Meaning | None:
    try:
        return _meaning(view, mention)
    except PlanarcError:
        return None
    except RecursionError:
        return None


def _meaning(view: View, mention: Mention) -> Meaning | None:
    match mention.kind:
        case Kind.ITERATOR | Kind.LITERAL:
            owner = ".".join(mention.owner) if mention.kind is Kind.LITERAL else ""
            return Meaning(mention.name, mention.span, None, mention.declared, owner)
        case Kind.DECLARATION:
            return _declaration(view, mention)
        case Kind.IMPORT:
            return _found(view.session.root_scope, mention, mention.path)
        case Kind.MODIFIER:
            return _modifier(view, mention)
    scope = view.scope_of(mention.owner)
    if mention.declared is not None:
        if len(mention.path) > 1:
            return None
        iterator = mention.declared
        span = Span(iterator.span.source, iterator.span.start, 0)
        span = Span(span.source, span.start, span.start + len(mention.name))
        return Meaning(mention.name, span, None, iterator)
    return _found(scope, mention, mention.path)


def _declaration(view: View, mention: Mention) -> Meaning | None:
    """A declaration means itself, but one that redeclares means what it takes the place of."""
    node = mention.declared
    assert isinstance(node, syntax.Component | syntax.ClassDef)
    instance = view.scope_of(mention.owner).instance if mention.owner else view.package().instance
    element = lookup.member(instance, mention.name)
    widens = isinstance(node, syntax.ClassDef) and isinstance(node.body, syntax.ExtendsClass)
    if element is not None and (element.definition is node or node.prefixes.redeclare or widens):
        return of_element(element)
    return Meaning(mention.name, name_place(node), None, node)


def _found(scope: Scope, mention: Mention, path: tuple[str, ...]) -> Meaning | None:
    elements = sight.find_path(scope, path, mention.absolute)
    if len(elements) == len(path):
        return of_element(elements[-1])
    if elements and len(elements) == len(path) - 1:
        return literal(elements[-1], path[-1])
    return None


def _modifier(view: View, mention: Mention) -> Meaning | None:
    if mention.base is None:
        return None
    scope = view.scope_of(mention.owner)
    elements = sight.find_path(scope, mention.base.names, mention.base.absolute)
    if len(elements) < len(mention.base.names):
        return None
    return of_member(sight.opened(elements[-1]), mention.path)


def of_member(instance: Instance, path: tuple[str, ...]) -> Meaning | None:
    """The meaning of names of members, each of the one before."""
    element: Element | None = None
    for count, name in enumerate(path, 1):
        if instance.layout.builtin is not None:
            return Meaning(name, NOWHERE, element, attribute=count == len(path))
        element = lookup.member(instance, name)
        if element is None:
            return None
        if count < len(path):
            instance = sight.opened(element)
    return None if element is None else of_element(element)


def of_element(element: Element) -> Meaning:
    return Meaning(element.name, name_place(element.definition), element, element.definition)


def literal(element: Element, name: str) -> Meaning | None:
    """The literal of an enumeration that an element is or stands for."""
    cls = sight.class_behind(element)
    builtin = sight.scope_of(cls).instance.layout.builtin
    if builtin is None or name not in builtin.literals:
        return None
    for part in sight.scope_of(cls).instance.layout.parts:
        body = part.definition.body
        for node in (body.literals or ()) if isinstance(body, syntax.Enumeration) else ():
            if node.name == name:
                span = Span(node.span.source, node.span.start, node.span.start + len(name))
                return Meaning(name, span, None, node, part.cls.name)
    return Meaning(name, NOWHERE, None, None, cls.name)


def name_place(node: syntax.Declaration) -> Span:
    """The place of a declared name alone."""
    span = name_span(node)
    return span if span is NOWHERE else Span(span.source, span.start, span.start + len(node.name))
