"""The names that may be written at a place: members, classes, modifiers, connectors, literals.

In:   View, Context
Out:  Item   the likely ones first, by their `rank`
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.editor import hover
from planarc.editor.context import Context, Where, context_at
from planarc.editor.view import View
from planarc.editor.words import ANNOTATIONS, DECLARING, STATING, VALUING
from planarc.flatten.tree import lookup, predefined, sight
from planarc.flatten.tree.nodes import CONNECTOR_KINDS, RECORD_KINDS, Element, Instance, Scope
from planarc.flatten.tree.sight import Candidate
from planarc.flatten.typing import builtins
from planarc.ir import syntax

_MOST = 1000


class Sort(Enum):
    COMPONENT = "component"
    PARAMETER = "parameter"
    CLASS = "class"
    PACKAGE = "package"
    FUNCTION = "function"
    LITERAL = "literal"
    KEYWORD = "keyword"
    ATTRIBUTE = "attribute"


class Item(Data):
    """A name that may be written. `insert` is what is written, where that is not the name alone. Of
    an `unread` class nobody has read the file: `told_of` does."""

    name: str
    sort: Sort
    detail: str = ""
    description: str = ""
    insert: str = ""
    rank: int = 5
    unread: bool = False


def complete(view: View, offset: int) -> tuple[Context, list[Item]]:
    """The items at a place, with its context."""
    context = context_at(view.text, offset)
    found: dict[str, Item] = {}
    for item in _items(view, offset, context):
        if item.name not in found and len(found) < _MOST:
            found[item.name] = item
    return context, list(found.values())


def _items(view: View, offset: int, context: Context) -> Iterator[Item]:
    match context.where:
        case Where.NOWHERE:
            return
        case Where.NAME:
            yield from _new_names(view.scope_at(offset), context)
            return
        case Where.ANNOTATION:
            last = context.path[-1] if context.path else ""
            for name in ANNOTATIONS.get(last, ()):
                yield Item(name, Sort.ATTRIBUTE, insert=name, rank=1)
            return
    scope = view.scope_at(offset)
    if context.where is Where.CONNECT:
        yield from _connectors(scope, context)
        return
    if context.before:
        yield from _members(scope, context)
        return
    if context.where is Where.MODIFIER:
        yield from _modifiers(scope, context)
        return
    if context.where is Where.CALL:
        yield from _named_arguments(scope, context)
    if context.argument:
        yield from _literals_for(scope, context)
    types = context.where in (Where.DECLARATION, Where.TYPE)
    words: Iterable[str] = VALUING
    if context.where is Where.DECLARATION:
        words = DECLARING
    elif context.where is Where.EQUATION:
        words = STATING
    elif types:
        words = ()
    for candidate in sight.in_sight(scope):
        if types and isinstance(candidate.declaration, syntax.Component):
            continue
        yield _item(candidate, 2 + min(candidate.depth, 3))
    yield from (Item(w, Sort.KEYWORD, rank=7) for w in words)
    if not types:
        yield from (Item(n, Sort.FUNCTION, "built-in function", rank=6) for n in builtins.names())


def _new_names(scope: Scope, context: Context) -> Iterator[Item]:
    """The name of a component after its class, such as `revolute`, or `revolute1` beside one."""
    found = sight.find_path(scope, context.head) if context.head else []
    if not found or len(found) != len(context.head):
        return
    if not found[-1].is_class or _is_variable(found[-1]):
        return
    word = context.head[-1]
    name = word[:1].lower() + word[1:]
    taken = {c.name for c in sight.in_sight(scope) if isinstance(c.declaration, syntax.Component)}
    free = (f"{name}{n or ''}" for n in range(len(taken) + 1))
    yield Item(next(n for n in free if n not in taken and n != word), Sort.COMPONENT, "a new name")


def told_of(view: View, offset: int, path: Sequence[str]) -> tuple[str, str] | None:
    """The kind and the description of a class in sight; its file is read for it."""
    found = sight.find_path(view.scope_at(offset), path)
    node = found[-1].definition if len(found) == len(path) else None
    return None if node is None else (_detail(node), node.comment)


def _item(candidate: Candidate, rank: int = 3) -> Item:
    node = candidate.declaration
    if node is None:
        return Item(candidate.name, Sort.CLASS, rank=rank, unread=True)
    return Item(candidate.name, sort_of(node), _detail(node), node.comment, rank=rank)


def sort_of(node: syntax.Declaration) -> Sort:
    if isinstance(node, syntax.Component):
        fixed = node.variability in (syntax.Variability.PARAMETER, syntax.Variability.CONSTANT)
        return Sort.PARAMETER if fixed else Sort.COMPONENT
    kind = node.kind
    if kind is syntax.ClassKind.PACKAGE:
        return Sort.PACKAGE
    return Sort.FUNCTION if kind is syntax.ClassKind.FUNCTION else Sort.CLASS


def _detail(node: syntax.Declaration) -> str:
    return str(node.type) if isinstance(node, syntax.Component) else node.kind.value


# Behind a dot ----------------------------------------------------------------------------------


def _members(scope: Scope, context: Context) -> Iterator[Item]:
    elements = sight.find_path(scope, context.before)
    if len(elements) != len(context.before):
        return
    element = elements[-1]
    try:
        instance = sight.opened(element)
    except PlanarcError:
        return
    builtin = instance.layout.builtin
    if builtin is not None and element.is_class:
        yield from (Item(n, Sort.LITERAL, instance.cls.name, rank=1) for n in builtin.literals)
        return
    for candidate in sight.members(instance, classes=element.is_class):
        if not candidate.protected:
            yield _item(candidate, 2)


# Modifiers and arguments -------------------------------------------------------------------------


def _instance(scope: Scope, context: Context) -> Instance | None:
    """What the brackets around belong to, opened."""
    elements = sight.find_path(scope, context.head) if context.head else []
    if not elements or len(elements) != len(context.head):
        return None
    try:
        instance = sight.opened(elements[-1])
        for name in context.path:
            element = lookup.member(instance, name)
            if element is None:
                return None
            instance = sight.opened(element)
    except PlanarcError:
        return None
    return instance


def _modifiers(scope: Scope, context: Context) -> Iterator[Item]:
    instance = _instance(scope, context)
    if instance is None:
        return
    if instance.layout.builtin is not None:
        for name, words in hover.ATTRIBUTES.items():
            yield Item(name, Sort.ATTRIBUTE, "attribute", words, f"{name}=", 1)
        return
    for candidate in sight.members(instance, classes=False):
        if candidate.protected or not isinstance(candidate.declaration, syntax.Component):
            continue
        yield _modifier(instance, candidate.name, candidate.declaration)
    yield from (Item(w, Sort.KEYWORD, rank=7) for w in ("each", "final", "redeclare"))


def _modifier(instance: Instance, name: str, node: syntax.Component) -> Item:
    """A modifier with the type, default and unit of what it modifies."""
    detail, insert = str(node.type), name
    element = lookup.member(instance, name)
    binding = node.modification.binding if node.modification else None
    if binding is not None:
        detail += f" = {binding.span.text}"
    if element is not None and _is_variable(element):
        insert = f"{name}="
        unit = hover.attribute(element, "unit")
        detail += f"  [{unit}]" if unit else ""
    sort = sort_of(node)
    return Item(name, sort, detail, node.comment, insert, 1 if sort is Sort.PARAMETER else 4)


def _is_variable(element: Element) -> bool:
    try:
        return sight.opened(element).layout.builtin is not None
    except PlanarcError:
        return False


def _named_arguments(scope: Scope, context: Context) -> Iterator[Item]:
    instance = _instance(scope, context)
    if instance is None:
        return
    inputs = syntax.Causality.INPUT
    is_record = instance.layout.kind in RECORD_KINDS
    for candidate in sight.members(instance, classes=False):
        node = candidate.declaration
        if isinstance(node, syntax.Component) and (node.causality is inputs or is_record):
            yield Item(
                candidate.name, Sort.PARAMETER, str(node.type), node.comment,
                f"{candidate.name}=", 1,
            )  # fmt: skip


def _literals_for(scope: Scope, context: Context) -> Iterator[Item]:
    """The literals of the enumeration that a modifier or argument takes."""
    instance = _instance(scope, context)
    try:
        if instance is None:
            return
        if instance.layout.builtin is not None:
            states = predefined.STATE_SELECT if context.argument == "stateSelect" else None
            for name in () if states is None else states.literals:
                yield Item(f"StateSelect.{name}", Sort.LITERAL, "StateSelect", rank=0)
            return
        element = lookup.member(instance, context.argument)
        if element is None or element.is_class:
            return
        cls = sight.class_behind(element)
        builtin = sight.scope_of(cls).instance.layout.builtin
    except PlanarcError:
        return
    if builtin is not None:
        written = str(element.definition.type) if isinstance(
            element.definition, syntax.Component
        ) else cls.name  # fmt: skip
        seen = sight.find_path(scope, written.split("."))
        head = written if len(seen) == written.count(".") + 1 else cls.name
        for name in builtin.literals:
            yield Item(f"{head}.{name}", Sort.LITERAL, cls.name, rank=0)


# Connectors -----------------------------------------------------------------------------------


def _connectors(scope: Scope, context: Context) -> Iterator[Item]:
    """The connectors in sight; as a second argument those of the first one's kind."""
    wanted: frozenset[str] | None = None
    if context.first:
        elements = sight.find_path(scope, context.first)
        if len(elements) == len(context.first):
            wanted = _shape(elements[-1])
    inside = scope.instance
    if context.before:
        elements = sight.find_path(scope, context.before)
        if len(elements) != len(context.before):
            return
        inside = sight.opened(elements[-1])
    for name, element in lookup.components(inside):
        if element.protected and context.before:
            continue
        shape = _shape(element)
        if shape is not None:
            if wanted is None or shape == wanted:
                yield Item(name, Sort.COMPONENT, _detail(element.definition), rank=1)
            continue
        if context.before:
            continue
        for inner, connector in _own_connectors(element):
            if (wanted is None or _shape(connector) == wanted) and (name, inner) != context.first:
                node = connector.definition
                yield Item(f"{name}.{inner}", Sort.COMPONENT, _detail(node), node.comment, rank=2)


def _own_connectors(element: Element) -> Iterator[tuple[str, Element]]:
    try:
        instance = sight.opened(element)
    except PlanarcError:
        return
    for name, inner in lookup.components(instance):
        if not inner.protected and _shape(inner) is not None:
            yield name, inner


def _shape(element: Element) -> frozenset[str] | None:
    """The names in a connector, by which two fit; None for what is none."""
    try:
        layout = sight.opened(element).layout
    except PlanarcError:
        return None
    if layout.kind not in CONNECTOR_KINDS:
        return None
    if layout.builtin is not None:
        return frozenset((layout.builtin.base.name,))
    return frozenset(layout.members)
