"""The predefined types: what every model can name without declaring it.

Reference: Modelica Language Specification 3.6, sections 4.9 and 8.3.7.
"""

from __future__ import annotations

from planarc.core.source import NOWHERE
from planarc.flatten.tree.nodes import NO_MOD, Class, Element, Layout, Part, Session
from planarc.ir import flat, syntax

STATE_SELECT = flat.Type(
    flat.Base.ENUMERATION, (), "StateSelect", ("never", "avoid", "default", "prefer", "always")
)
ASSERTION_LEVEL = flat.Type(flat.Base.ENUMERATION, (), "AssertionLevel", ("warning", "error"))
#: an object that lives outside of Modelica (12.9.7); refused when a component is made of it
EXTERNAL_OBJECT = flat.Type(flat.Base.RECORD, (), "ExternalObject")

_TYPES = {
    "Real": flat.REAL,
    "Integer": flat.INTEGER,
    "Boolean": flat.BOOLEAN,
    "String": flat.STRING,
    "StateSelect": STATE_SELECT,
    "AssertionLevel": ASSERTION_LEVEL,
    "ExternalObject": EXTERNAL_OBJECT,
    "Clock": flat.CLOCK,
}
NAMES = tuple(_TYPES)


def _definition(name: str) -> syntax.ClassDef:
    return syntax.ClassDef(
        NOWHERE, name, syntax.ClassKind.TYPE, syntax.Composition(NOWHERE), NOWHERE
    )


_DEFINITIONS = {name: _definition(name) for name in _TYPES}


def element(session: Session, name: str) -> Element | None:
    """The predefined type `name` as an element of the outermost scope."""
    if name not in _TYPES:
        return None
    root = session.root_scope.instance
    found = root.elements.get(f"<{name}>")
    if found is None:
        found = Element(name, _DEFINITIONS[name], session.root_scope, NO_MOD)
        found.cls = Class(_DEFINITIONS[name], session.root_scope, name)
        found.cls.layout = _layout(found.cls, _TYPES[name])
        root.elements[f"<{name}>"] = found
    return found


def _layout(cls: Class, builtin: flat.Type) -> Layout:
    part = Part(cls, 0, {})
    return Layout([part], {}, builtin, kind=syntax.ClassKind.TYPE, done=True)
