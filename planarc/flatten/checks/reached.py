"""Classes inside of a component that a modifier reaches, whether anything is made of them or not.

In:   the instances of a model
Out:  errors F210, F222, F241, F242, ..., at the modifier

Everything else is opened when it is first asked for. A class of which there is no component would
never be, and a typo in `Pump pump(redeclare model Curve = Linaer)` would do nothing.

Reference: Modelica Language Specification 3.6, sections 5.3, 7.2 and 7.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.instances.instantiate import check_modifier
from planarc.flatten.refusal import for_each
from planarc.flatten.tree.demand import class_of, layout_of, static_instance
from planarc.flatten.tree.lookup import declared, find_class, member
from planarc.flatten.tree.modify import merge, part_mod
from planarc.flatten.tree.nodes import Class, Element, Instance, Layout, Mod, Session
from planarc.flatten.tree.redeclare import effective_component
from planarc.ir import syntax


def check_reached(instances: Sequence[Instance], session: Session) -> None:
    """Report what modifiers of classes inside say wrongly; each modifier is looked at once."""
    inside: dict[int, list[str]] = {}
    seen: set[tuple[object, ...]] = set()
    for instance in instances:
        layout = instance.layout
        if id(layout) not in inside:
            inside[id(layout)] = list(_classes(layout))
        for name in inside[id(layout)]:
            try:
                element = declared(instance, name)
                new = element.mod.redeclaration
                key = id(layout), name, id(element.mod.span), id(new and new.element)
                if key not in seen and (element.mod or _says_something(element.definition)):
                    seen.add(key)
                    _check_class(element)
            except PlanarcError as problem:
                session.keep(problem)


def _classes(layout: Layout) -> Iterator[str]:
    """The names of the classes inside."""
    for name, (_, definition) in layout.members.items():
        if isinstance(definition, syntax.ClassDef):
            yield name


def _says_something(definition: syntax.Declaration) -> bool:
    """Whether a short class modifies the one that it is made of."""
    body = definition.body if isinstance(definition, syntax.ClassDef) else None
    return isinstance(body, syntax.ShortClass) and body.modification is not None


def _check_class(element: Element) -> None:
    """The class is there, may stand here, and has what the modifier names."""
    cls = class_of(element)
    if layout_of(cls).builtin is None:
        _check_inside(static_instance(cls))


def _check_inside(opened: Instance) -> None:
    check_modifier(opened)
    for_each(_modified(opened), _check)


def _modified(opened: Instance) -> Iterator[Element]:
    """The elements that a modifier from outside of their class reaches."""
    members = opened.layout.members
    reached = [name for name, (index, _) in members.items() if part_mod(opened, index).sub(name)]
    reached += [name for name in opened.mod.subs if name not in members]
    for name in reached:
        element = member(opened, name)
        if element is not None and not element.definition.prefixes.outer:
            yield element


def _check(element: Element) -> None:
    if element.is_class:
        _check_class(element)
        return
    definition, scope, mod = effective_component(element)
    cls = find_class(scope, definition.type)
    if layout_of(cls).builtin is None:
        _check_inside(_example(cls, mod, element))


def _example(cls: Class, mod: Mod, element: Element) -> Instance:
    """A component as it would be, which belongs to no model."""
    around = element.scope.instance
    whole = merge(mod, cls.mod, element.name)
    return Instance(cls, layout_of(cls), None, whole, around, around.session, element=element)
