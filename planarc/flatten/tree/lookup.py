"""Name lookup: from an identifier and a scope to the element it means.

In:   a name, the Scope it stands in
Out:  Element (a component or a class), or Class for a composite class name

A name is searched in the class's own and inherited elements, its imports, then
the enclosing classes outwards up to the first encapsulated one, the top-level
classes, and last the predefined types.

Example: `SI.Angle` in `PlanarMultiBody.Joints.Revolute`: `SI` is the import of
the package `PlanarMultiBody`, `Angle` a class of what it stands for.

Promises:  a component found in an enclosing class is a constant; a name that is
           not found is reported with the nearest names in sight.
Reference: Modelica Language Specification 3.6, sections 5.3 and 13.2.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress

from planarc.core.diagnostic import Diagnostic, Once, PlanarcError, Related, error
from planarc.core.mend import Meant
from planarc.core.nearest import did_you_mean, nearest
from planarc.core.prose import both, either
from planarc.core.source import Span
from planarc.flatten.tree import naming, predefined
from planarc.flatten.tree.demand import class_of, layout_of, node_of, static_instance
from planarc.flatten.tree.modify import part_mod
from planarc.flatten.tree.nodes import (
    CONNECTOR_KINDS,
    Class,
    Element,
    Instance,
    Leaf,
    Part,
    Scope,
    Session,
)
from planarc.ir import syntax

_LISTED = 6  # names of a package in one message


def member(instance: Instance, name: str, part: Part | None = None) -> Element | None:
    """The element `name` of an instance, as seen by one of its parts."""
    element = instance.elements.get(name)
    if element is not None:
        if part is None or part.index == 0 or name in part.visible or element.entry is not None:
            return element
        return None
    layout = instance.layout
    slot = layout.members.get(name)
    if slot is None and not layout.done and layout.parts and name in layout.parts[0].own:
        slot = (0, layout.parts[0].own[name])
    if slot is not None:
        if part is not None and part.index and name not in part.visible:
            return None
        return _declare(instance, name, *slot)
    return _member_on_disk(instance, name, part)


def declared(instance: Instance, name: str) -> Element:
    """The element of a name that is one of the members."""
    element = member(instance, name)
    assert element is not None
    return element


def public_member(instance: Instance, name: str, span: Span) -> Element:
    """The element that a name behind a dot means."""
    element = member(instance, name)
    if element is None:
        raise naming.missing_member(
            instance.cls, name, span, lambda names: holders(instance, names)
        )
    if element.protected:
        raise error("F214", f"`{name}` is protected in `{instance.cls.name}`", span)
    return element


def holders(instance: Instance, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """The components of an instance, but for its connectors, that have an element of one of the
    names, and the first such name."""
    for own, (index, d) in instance.layout.members.items():
        if isinstance(d, syntax.Component) and not (d.prefixes.protected or d.prefixes.outer):
            with suppress(PlanarcError):
                cls = find_class(instance.scope(index), d.type)
                if cls.definition.kind not in CONNECTOR_KINDS:
                    members = layout_of(cls).members
                    yield from ((own, name) for name in names if name in members)


def components(instance: Instance) -> Iterator[tuple[str, Element]]:
    """The declared components by name, in their order."""
    for name, (_, definition) in instance.layout.members.items():
        if isinstance(definition, syntax.Component):
            yield name, instance.elements.get(name) or declared(instance, name)


def leaf_named(session: Session, name: str) -> Leaf | None:
    """A variable of the model by its full name; it is opened where it is still closed."""
    if name not in session.leaves and name in session.closed:
        instance, own = session.closed[name]
        node_of(declared(instance, own))
    return session.leaves.get(name)


def inner_elements(element: Element) -> Iterator[Element]:
    """The `inner` elements of that name in the instances around, the nearest first (5.4)."""
    _, *around = element.scope.instance.outwards()
    for instance in around:
        slot = instance.layout.members.get(element.name)
        found = member(instance, element.name) if slot and slot[1].prefixes.inner else None
        if found is not None:
            yield found


def _declare(instance: Instance, name: str, index: int, definition: syntax.Declaration) -> Element:
    part = instance.layout.parts[index]
    entry = None
    if part.cls.entry is not None and isinstance(definition, syntax.ClassDef):
        entry = part.cls.entry.child(name)
    element = Element(
        name,
        definition,
        instance.scope(index),
        part_mod(instance, index).sub(name),
        definition.prefixes.protected or part.protected,
        entry,
    )
    instance.elements[name] = element
    return element


def _member_on_disk(instance: Instance, name: str, part: Part | None) -> Element | None:
    """A class of a package that has its own file."""
    layout = instance.layout
    for candidate in layout.parts if part is None else layout.parts[part.index :]:
        entry = candidate.cls.entry
        if entry is None or (part is not None and entry not in part.entries):
            continue
        child = entry.child(name)
        if child is not None:
            definition = child.definition
            mod = part_mod(instance, candidate.index).sub(name)
            element = Element(name, definition, instance.scope(candidate.index), mod, False, child)
            instance.elements[name] = element
            return element
    return None


# Simple names ------------------------------------------------------------------------------


def find(scope: Scope, name: str, at: Span | None = None) -> tuple[Element, bool] | None:
    """The element that an identifier `at` a place means, and whether it is the scope's own."""
    element = find_in_scope(scope, name, at)
    if element is not None:
        return element, True
    if scope.part.definition.encapsulated or scope.parent is None:
        element = predefined.element(scope.session, name)
        return None if element is None else (element, False)
    return _find_outside(scope.parent, name, at)


def _find_outside(scope: Scope, name: str, at: Span | None) -> tuple[Element, bool] | None:
    """Search enclosing classes; what packages answer is remembered."""
    static = scope.instance.prefix is None and scope.part.index == 0
    if static and name in scope.cls.lookups:
        return scope.cls.lookups[name]
    found = find(scope, name, at)
    if found is not None:
        found = (found[0], False)
    if static and scope.instance.layout.done:
        scope.cls.lookups[name] = found
    return found


def find_in_scope(scope: Scope, name: str, at: Span | None = None) -> Element | None:
    """An element of the class itself, of its bases, or one that it imports."""
    part = scope.part
    if name in part.visible or part.entries:
        element = member(scope.instance, name, part)
        if element is not None:
            return element
    return _imported(scope, name, at) if part.imports else None


def _imported(scope: Scope, name: str, at: Span | None) -> Element | None:
    for clause in scope.part.imports:
        if clause.wildcard:
            continue
        if clause.names:
            if name in clause.names:
                return import_target(scope, (*clause.path, name), clause.span)
        elif name == (clause.alias or clause.path[-1]):
            return import_target(scope, clause.path, clause.span)
    found: list[tuple[Element, syntax.Import]] = []
    for clause in scope.part.imports:
        if clause.wildcard:
            element = _wildcard(scope, clause, name)
            if element is not None:
                found.append((element, clause))
    if len({id(element) for element, _ in found}) > 1:
        raise _ambiguous(name, [clause for _, clause in found], at)
    return found[0][0] if found else None


def _ambiguous(name: str, clauses: list[syntax.Import], at: Span | None) -> PlanarcError:
    """The error of a name that several `.*` imports bring."""
    imports = [f"import {'.'.join(clause.path)}.{name};" for clause in clauses]
    found = [Related("found by this import", clause.span) for clause in clauses]
    told = Once(
        "F212",
        f"`{name}` is found by {'two' if len(found) == 2 else len(found)} `.*` imports",
        at or clauses[-1].span,
        hint=f"import the one that you mean by its own name: {either(imports)}",
        related=tuple(found if at else found[:-1]),
        kind=f"{clauses[0].span.source.name}:{clauses[0].span.start} {name}",
    )
    return PlanarcError(told)


def import_target(
    scope: Scope, path: tuple[str, ...], span: Span, all_of_it: bool = False
) -> Element:
    """Import paths are full names: they start at the top level. What is imported is an element of
    a package, or all of one (13.2.1)."""
    element = member(scope.session.root_scope.instance, path[0])
    done = path[0]
    for count, name in enumerate(path[1:], 2):
        if element is None:
            break
        last = count == len(path) and not all_of_it
        owner = _package(element, done, span) if last else class_of(element, span)
        element, done = member(static_instance(owner), name), f"{done}.{name}"
        if element is not None and element.protected:
            raise error("F214", f"`{name}` is protected in `{owner.name}`", span)
    if element is None:
        package, _, name = done.rpartition(".")
        inside = scope.session.library.class_names(package)
        near: Meant | str | None = did_you_mean(name, inside)
        if near is None and package and 0 < len(inside) <= _LISTED:
            near = f"`{package}` holds {both(inside)}"
        message = f"`{'.'.join(path)}` cannot be imported: `{done}` does not exist"
        folder: str | None = None
        if package:
            folder = naming.left_out(owner)
        else:
            folder = f"give the folder that holds `{name}` with `--library`, or in MODELICAPATH"
        if done == "Modelica.Mechanics.MultiBody":
            raise naming.spatial(message, span)
        raise error("F210", message, span, hint=near or folder)
    return element


def unknown(
    scope: Scope, name: str, span: Span, counters: Collection[str] = (), value: bool = False
) -> PlanarcError:
    """The error of a name that is not found. `counters` are those of the loops around; `value`: it
    is no part of a path, and no class."""
    if scope is scope.session.doubted:  # a search for what is meant takes long
        return error("F210", f"unknown name `{name}`", span)
    wrong = _misspelt_import(scope, name)
    return PlanarcError(wrong) if wrong else naming.unknown(scope, name, span, counters, value)


def _misspelt_import(scope: Scope, name: str) -> Diagnostic | None:
    """An import of nothing that was to give this name: told once, not wherever the name stands."""
    current: Scope | None = scope
    while current is not None:
        for clause in current.part.imports:
            path = ".".join(clause.path)
            package, _, last = path.rpartition(".")
            meant = not (clause.alias or clause.names or clause.wildcard) and nearest(
                last, [name], cutoff=0.5
            )
            inside = _names_in(scope, package) if meant else ()
            if name in inside and last not in inside:
                message = f"`{path}` cannot be imported: it does not exist"
                near = Meant(path, (f"{package}.{name}",))
                return Once("F210", message, clause.span, hint=str(near), mend=near, kind=path)
        current = current.parent
    return None


def _names_in(scope: Scope, package: str) -> list[str]:
    """The classes and constants of a package that is named in full."""
    try:
        element = import_target(scope, tuple(package.split(".")), scope.instance.cls.span)
    except PlanarcError:
        return []
    return naming.member_names(static_instance(class_of(element, scope.instance.cls.span)))


def _package(element: Element, name: str, span: Span) -> Class:
    cls = class_of(element, span)
    if layout_of(cls).kind is not syntax.ClassKind.PACKAGE:
        message = f"nothing can be imported from `{name}`, which is no package"
        raise error("F210", message, span, related=[Related("declared here", cls.span)])
    return cls


def _wildcard(scope: Scope, clause: syntax.Import, name: str) -> Element | None:
    target = import_target(scope, clause.path, clause.span, all_of_it=True)
    package = _package(target, ".".join(clause.path), clause.span)
    element = member(static_instance(package), name)
    return None if element is None or element.protected else element


# Composite names --------------------------------------------------------------------------------


def find_class(scope: Scope, name: syntax.Ref) -> Class:
    """The class that a type name means; what no instance of the class decides is remembered."""
    known = scope.part.types.get(id(name))
    if known is not None:
        return known[1]
    names = name.names
    if any(part.subscripts for part in name.parts):
        raise error("F211", f"`{name}` is no class name: it has subscripts", name.span)
    element = _first(scope, names[0], name)
    cls = _as_class(element, names[0], name.span)
    for step in names[1:]:
        cls = _as_class(class_member(cls, step, name.span), step, name.span)
    if element.scope.instance is not scope.instance and scope.instance.layout.done:
        scope.part.types[id(name)] = name, cls
    return cls


def classes_of_path(scope: Scope, name: syntax.Ref) -> Iterator[Class]:
    """The classes that the names of a path mean, one inside of the other."""
    cls = _as_class(_first(scope, name.names[0], name), name.names[0], name.span)
    yield cls
    for step in name.names[1:]:
        cls = _as_class(class_member(cls, step, name.span), step, name.span)
        yield cls


def class_member(cls: Class, name: str, span: Span) -> Element:
    """The element behind the name of a class: of packages, and of classes that are like them, any
    public one, of others only an encapsulated class (5.3.2)."""
    element = public_member(static_instance(cls), name, span)
    definition = element.definition
    closed = isinstance(definition, syntax.ClassDef) and not definition.encapsulated
    if closed and cls.definition.kind in _CLOSED_KINDS and not _is_like_package(cls):
        message = f"`{cls.name}` is no package: its class `{name}` belongs to it alone"
        hint = "move it into a package, or write `encapsulated` before it"
        raise error("F214", message, span, hint=hint)
    return element


_CLOSED_KINDS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK, syntax.ClassKind.CLASS)


def _is_like_package(cls: Class) -> bool:
    """It holds classes and constants only."""
    layout = layout_of(cls)
    constant = syntax.Variability.CONSTANT
    declared = (d for _, d in layout.members.values() if isinstance(d, syntax.Component))
    return all(d.variability is constant for d in declared)


def _first(scope: Scope, name: str, ref: syntax.Ref) -> Element:
    if ref.absolute:
        session = scope.session
        element = member(session.root_scope.instance, name) or predefined.element(session, name)
        if element is None:
            raise error("F210", f"there is no top-level class `{name}`", ref.span)
        return element
    found = find(scope, name, ref.span)
    if found is None:
        raise unknown(scope, name, ref.span)
    return found[0]


def _as_class(element: Element, name: str, span: Span) -> Class:
    if not element.is_class:
        message = f"`{name}` is a component, not a class"
        definition = element.definition
        related = [Related("declared here", definition.span)]
        of_itself = isinstance(definition, syntax.Component) and str(definition.type) == name
        hint = "give the component another name than its class" if of_itself else None
        raise error("F211", message, span, related=related, hint=hint)
    return class_of(element, span)
