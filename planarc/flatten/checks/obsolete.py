"""Obsolete classes of components and bases.

In:   the instances of a model
Out:  warnings F266, where the name of the class is first written

Reference: Modelica Language Specification 3.6, section 18.7.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.source import Span
from planarc.flatten.tree import annotation
from planarc.flatten.tree.nodes import Instance, Session
from planarc.ir import syntax


def check_obsolete(instances: Sequence[Instance], session: Session) -> None:
    """Warn of each obsolete class of components and bases, where its name is first written."""
    seen: set[int] = set()
    for instance in instances:
        if id(instance.layout) in seen:
            continue
        seen.add(id(instance.layout))
        for part in instance.layout.parts:
            annotation.warn_obsolete(part.cls, part.base_at or _type_span(instance), session)


def _type_span(instance: Instance) -> Span:
    """The place where the class of a component is named: its declaration, or what redeclares it."""
    element = instance.element
    if element is None:
        return instance.span
    new = element.mod.redeclaration
    written = element.definition if new is None else new.element
    return written.type.span if isinstance(written, syntax.Component) else instance.span
