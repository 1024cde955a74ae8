"""Text and mechanism: which component a place of the text belongs to, and where one is declared."""

from __future__ import annotations

import re

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.editor.meaning import name_place
from planarc.editor.mentions import Kind, mention_at
from planarc.editor.view import View
from planarc.flatten.tree import lookup, sight
from planarc.ir import syntax


def part_at(view: View, offset: int) -> tuple[str, str] | None:
    """The class around a place, and the full name of the component under it."""
    name = view.class_at(offset)
    if not name:
        return None
    mention = mention_at(view.text, offset)
    if mention is not None and not mention.is_type and mention.path:
        if mention.kind is Kind.REFERENCE:
            found = sight.find_path(view.scope_at(offset), mention.path)
            path = mention.path[: len(found)]
            while path and not _is_part(view, offset, path):
                path = path[:-1]
            if path:
                return name, ".".join(path)
        elif mention.kind is Kind.DECLARATION and isinstance(mention.declared, syntax.Component):
            return name, mention.name
    declared = _declared_on(view, offset)
    return None if declared is None else (name, declared)


def _is_part(view: View, offset: int, path: tuple[str, ...]) -> bool:
    """True for a component that is no variable."""
    found = sight.find_path(view.scope_at(offset), path)
    if len(found) != len(path) or found[-1].is_class:
        return False
    try:
        return sight.opened(found[-1]).layout.builtin is None
    except PlanarcError:
        return False


def _declared_on(view: View, offset: int) -> str | None:
    """The component whose declaration holds a place, from its type to its `;`."""
    _, chain = view.text.chain(offset)
    composition = chain[-1].composition if chain else None
    for element in () if composition is None else composition.elements:
        if isinstance(element, syntax.Component) and element.name:
            start = min(element.type.span.start, element.span.start)
            if start <= offset <= element.span.end + 1:
                return element.name
    return None


def place_of(view: View, class_name: str, component: str) -> Span | None:
    """The declaration of a component of a class; of its longest part that a file declares."""
    cls = view.find(class_name)
    if cls is None:
        return None
    names = re.findall(r"(?:'(?:[^'\\]|\\.)*'|[^.\[\]'])+", re.sub(r"\[[^\]]*\]", "", component))
    instance = sight.scope_of(cls).instance
    place: Span | None = None
    for name in names:
        try:
            element = lookup.member(instance, name)
            if element is None or element.is_class:
                break
            place = name_place(element.definition)
            instance = sight.opened(element)
        except PlanarcError:
            break
    return place
