"""Subtyping: whether a class can stand where another one is expected.

In:   a class, the constraining class
Out:  what is missing, or None

The class need not be derived from the constraint; it must have every public element
of it, components of built-in types with the same type (structural subtyping).

Reference: Modelica Language Specification 3.6, sections 6.4 and 6.5.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.library.library import split_name
from planarc.flatten.terms.conform import base_conforms, type_text
from planarc.flatten.tree import lookup
from planarc.flatten.tree.demand import class_of, layout_of, static_instance
from planarc.flatten.tree.nodes import Class, Layout, Session
from planarc.ir import flat, syntax

_MODELS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK, syntax.ClassKind.CLASS)


def obstacle(cls: Class, constraint: Class) -> str | None:
    """The reason why `cls` cannot stand for `constraint`; None when it can."""
    if cls.definition is constraint.definition:
        return None
    own, wanted = layout_of(cls), layout_of(constraint)
    if not own.done or not wanted.done:
        return None
    if not _same_kind(own.kind, wanted.kind):
        return f"it is a {own.kind.value}, not a {wanted.kind.value}"
    if own.builtin is not None or wanted.builtin is not None:
        return _builtin_obstacle(own.builtin, wanted.builtin)
    for name, (index, definition) in wanted.members.items():
        if definition.prefixes.protected or wanted.parts[index].protected:
            continue
        if name in own.members:
            reason = (
                _member_obstacle(name, own, wanted)
                or _type_obstacle(name, cls, constraint)
                or _size_obstacle(name, own, wanted)
            )
            if reason is not None:
                return reason
        elif lookup.member(static_instance(cls), name) is None:
            kind = ""
            if own.kind is syntax.ClassKind.FUNCTION and isinstance(definition, syntax.Component):
                kind = f"{definition.causality.value} "
            return f"it has no {kind}`{name}`"
    return _input_obstacle(cls, own, wanted)


def complete_heirs(cls: Class, package: str, session: Session) -> dict[str, Class]:
    """The classes of a package that extend a class and are not partial, by their names."""
    found = {}
    for name in session.library.class_names(package):
        path = (*split_name(package), name)
        try:
            element = lookup.import_target(session.root_scope, path, cls.span)
            heir = class_of(element, cls.span)
            bases = [part.definition for part in layout_of(heir).parts]
        except PlanarcError:
            continue
        if cls.definition in bases[1:] and not heir.definition.partial:
            found[name] = heir
    return found


def _same_kind(own: syntax.ClassKind, wanted: syntax.ClassKind) -> bool:
    return own is wanted or (own in _MODELS and wanted in _MODELS)


def _builtin_obstacle(own: flat.Type | None, wanted: flat.Type | None) -> str | None:
    if own is None or wanted is None:
        return "one of both is a built-in type"
    if own.base is wanted.base is flat.Base.ENUMERATION and not wanted.literals:
        return None  # `enumeration(:)` stands for any (4.9.5)
    if base_conforms(wanted, own) and base_conforms(own, wanted):
        return None
    return f"it is {type_text(own)}, not {type_text(wanted)}"


def _member_obstacle(name: str, own: Layout, wanted: Layout) -> str | None:
    """A component cannot take the place of a class, nor the reverse."""
    first, second = own.members[name][1], wanted.members[name][1]
    if isinstance(first, syntax.ClassDef) != isinstance(second, syntax.ClassDef):
        kinds = "a class" if isinstance(first, syntax.ClassDef) else "a component"
        return f"its `{name}` is {kinds}"
    return None


def _type_obstacle(name: str, cls: Class, constraint: Class) -> str | None:
    """Variables of built-in types have the same type; an Integer may stand for a Real."""
    own, wanted = _builtin_of(name, cls), _builtin_of(name, constraint)
    if own is None or wanted is None or base_conforms(wanted, own):
        return None
    return f"its `{name}` is {type_text(own)}, not {type_text(wanted)}"


def _size_obstacle(name: str, own: Layout, wanted: Layout) -> str | None:
    """Arrays whose sizes are written as numbers have the same sizes."""
    first, second = own.members[name][1], wanted.members[name][1]
    if not isinstance(first, syntax.Component) or not isinstance(second, syntax.Component):
        return None
    sizes, asked = _sizes(first), _sizes(second)
    if None in sizes or None in asked or sizes == asked or len(sizes) != len(asked):
        return None
    return f"its `{name}` has the size {_shown(sizes)}, not {_shown(asked)}"


def _sizes(definition: syntax.Component) -> tuple[int | None, ...]:
    dims = (*definition.dimensions, *definition.type_dimensions)
    return tuple(d.value if isinstance(d, syntax.Integer) else None for d in dims)


def _shown(sizes: tuple[int | None, ...]) -> str:
    return f"[{', '.join(map(str, sizes))}]"


def _input_obstacle(cls: Class, own: Layout, wanted: Layout) -> str | None:
    """Calls of a function give values to no more inputs than it has there (6.5)."""
    if not _inputs(wanted):
        return None
    for name, definition in _inputs(own).items():
        default = definition.modification is not None and definition.modification.binding
        if name in wanted.members or default:
            continue
        element = lookup.member(static_instance(cls), name)
        if element is not None and element.mod.binding is None:
            return f"its input `{name}` has no value of its own, and calls give it none"
    return None


def _inputs(layout: Layout) -> dict[str, syntax.Component]:
    """The inputs of a function, of any other class none."""
    if layout.kind is not syntax.ClassKind.FUNCTION:
        return {}
    return {
        name: definition
        for name, (_, definition) in layout.members.items()
        if isinstance(definition, syntax.Component)
        and definition.causality is syntax.Causality.INPUT
    }


def _builtin_of(name: str, cls: Class) -> flat.Type | None:
    """The built-in type of a member; None when it has none, or that is not clear yet."""
    element = lookup.member(static_instance(cls), name)
    if element is None or not isinstance(element.definition, syntax.Component):
        return None
    if element.mod.redeclaration is not None:
        return None
    try:
        found = lookup.find_class(element.scope, element.definition.type)
    except PlanarcError:
        return None
    return layout_of(found).builtin
