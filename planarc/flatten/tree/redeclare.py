"""Redeclaration: which class or component an element is, after all that replaced it.

In:   Element, with the modifier that reached it
Out:  Class (of a class element), or the component declaration that counts

Example:
    model B  replaceable Circle c constrainedby Curve(r=r0); end B;
    B b(redeclare Ellipse c(a=2))     `b.c` is an `Ellipse(a=2, r=r0)`

The modifiers of a redeclaration override those further inside, which stay where it says
nothing. The modifier of the constraining class stays under both, and under that of the
declaration where nothing is redeclared;
without `constrainedby` the declaration itself is the constraint (7.3.2).

Promises:  only replaceable elements are redeclared, or open sizes; the new class has every public
           component of the constraining one.
Reference: Modelica Language Specification 3.6, sections 6.5 and 7.3.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.prose import shortened
from planarc.core.source import Span
from planarc.flatten.tree import lookup, subtype
from planarc.flatten.tree.demand import class_of, layout_of
from planarc.flatten.tree.modify import compile_modification, final_error, merge, subscript
from planarc.flatten.tree.naming import name_span
from planarc.flatten.tree.nodes import (
    NO_MOD,
    Class,
    Element,
    Instance,
    Layout,
    Mod,
    Redeclaration,
    Scope,
    State,
)
from planarc.ir import syntax


def make_class(element: Element, span: Span | None) -> Class:
    """Fill in the class that a class element stands for."""
    definition = element.definition
    assert isinstance(definition, syntax.ClassDef)
    if element.state is State.BUSY:
        raise error("F232", f"`{element.name}` is defined by itself", span)
    element.state = State.BUSY
    try:
        element.cls = _make_class(element, definition)
    finally:
        element.state = State.NEW
    return element.cls


def _make_class(element: Element, definition: syntax.ClassDef) -> Class:
    if definition.prefixes.outer:
        for found in lookup.inner_elements(element):
            if found.is_class:
                return class_of(inner_half(found))
    mod = element.mod
    redeclaration = mod.redeclaration
    instance = element.scope.instance
    name = _class_name(instance, definition.name)
    if redeclaration is None:
        cls = _modified(element, mod, name)
        if definition.constraint is not None:
            _check_fit(element, cls)
        return cls
    new = redeclaration.element
    if not isinstance(new, syntax.ClassDef):
        message = f"`{element.name}` is a class and is redeclared as a component"
        related = [Related("declared here", definition.name_span)]
        raise error("F240", message, new.span, related=related)
    _check_replaceable(element, definition.name_span, new.name_span)
    cls = _modified(element, mod, name)
    if not _widens(new):
        _check_fit(element, cls)
    return cls


def _modified(element: Element, mod: Mod, name: str) -> Class:
    """The class that a modifier makes of a class element. Where it widens the inherited one, that
    is the work of what stands further inside (7.3.1)."""
    redeclaration, said = mod.redeclaration, replace(mod, redeclaration=None)
    definition = element.definition if redeclaration is None else redeclaration.element
    assert isinstance(definition, syntax.ClassDef)
    if redeclaration is None:
        cls = Class(definition, element.scope, name, said, element.entry)
        return _bounded(cls, _constraint_mod(element))
    if _widens(definition):
        original = _modified(element, redeclaration.inside, name)
        return Class(definition, redeclaration.scope, name, said, None, original)
    under = merge(_said_inside(redeclaration), _kept_mod(element), name)
    return _bounded(Class(definition, redeclaration.scope, name, said), under)


def _said_inside(redeclaration: Redeclaration) -> Mod:
    """What modifiers further inside say of the element, whatever was redeclared there."""
    mod = redeclaration.inside
    said = replace(mod, redeclaration=None)
    if mod.redeclaration is None:
        return said
    return merge(said, _said_inside(mod.redeclaration), mod.redeclaration.element.name)


def _bounded(cls: Class, under: Mod) -> Class:
    """A class with the modifier of its constraining class, which a short class stands above."""
    if isinstance(cls.definition.body, syntax.ShortClass):
        cls.under = under
    else:
        cls.mod = merge(cls.mod, under)
    return cls


def _constraints(element: Element) -> list[tuple[syntax.Constraint, Scope]]:
    """The constraints of an element: of its redeclarations, the last one first, and its own."""
    declared = _declarations(element)
    return [(d.constraint, scope) for d, scope in declared if d.constraint is not None]


def _declarations(element: Element) -> Iterator[tuple[syntax.Declaration, Scope]]:
    """The redeclarations of an element, the last one first, and its declaration."""
    current = element.mod.redeclaration
    while current is not None:
        yield current.element, current.scope
        current = current.inside.redeclaration
    yield element.definition, element.scope


def _check_fit(element: Element, cls: Class) -> None:
    """The class of an element fits its constraints, and each of these the ones before (7.3.2);
    without any, it fits the class that it replaces."""
    chain = [lookup.find_class(scope, c.base) for c, scope in _constraints(element)]
    if element.definition.constraint is None:
        chain.append(_declared_class(element))
    redeclaration = element.mod.redeclaration
    for own, wanted in pairwise([cls, *chain]):
        reason = subtype.obstacle(own, wanted)
        if reason is None:
            continue
        old = name_span(element.definition)
        if redeclaration is not None:
            new = name_span(redeclaration.element)
            name = _named(redeclaration.element if own is cls else None, own)
            raise _does_not_fit(element, old, new, name, wanted, reason)
        message = f"`{element.name}` does not fit its constraint `{wanted.name}`: {reason}"
        raise error("F242", message, old)


def _declared_class(element: Element) -> Class:
    definition = element.definition
    if isinstance(definition, syntax.Component):
        return lookup.find_class(element.scope, definition.type)
    return Class(definition, element.scope, element.name, NO_MOD, element.entry)


def _named(new: syntax.Declaration | None, cls: Class) -> str:
    """A class as it is written where it is to replace another one."""
    body = cls.definition.body
    if isinstance(new, syntax.Component):
        return str(new.type)
    return str(body.base) if isinstance(body, syntax.ShortClass) else cls.definition.name


def _does_not_fit(
    element: Element, old: Span, new: Span, name: str, wanted: Class, reason: str
) -> PlanarcError:
    message = f"`{name}` cannot replace `{element.name}`: {reason}"
    is_component = isinstance(element.definition, syntax.Component)
    hint = _what_fits(element, wanted) if is_component else None
    return error("F242", message, new, related=[Related("declared here", old)], hint=hint)


def _what_fits(element: Element, wanted: Class) -> str:
    """The hint that tells which classes a component takes."""
    hint = f"take a class that extends `{wanted.name}`"
    near = (_declared_class(element).name, wanted.name, element.scope.instance.cls.name)
    for package in dict.fromkeys(name.rpartition(".")[0] for name in near):
        names = subtype.complete_heirs(wanted, package, element.scope.session) if package else []
        if names:
            of = f" of `{package}`"
            return f"{hint}, such as {shortened([f'`{n}`' for n in names], _MOST_OFFERED)}{of}"
    return hint


def replacements_with(element: Element, name: str) -> list[str]:
    """The classes that may replace that of a component and have an element of a name: those beside
    it, by their full names."""
    definition = element.definition
    if not isinstance(definition, syntax.Component) or not definition.prefixes.replaceable:
        return []
    if element.mod.redeclaration is not None:
        return []
    declared = _declared_class(element)
    chain = [lookup.find_class(scope, c.base) for c, scope in _constraints(element)]
    package = declared.name.rpartition(".")[0]
    wanted = chain[0] if chain else declared
    heirs = subtype.complete_heirs(wanted, package, element.scope.session) if package else {}
    return [f"{package}.{own}" for own, cls in heirs.items() if name in layout_of(cls).members]


_MOST_OFFERED = 6


def _widens(definition: syntax.ClassDef) -> bool:
    """It is made of the class that it replaces: `extends M`, or `M = M(...)`."""
    body = definition.body
    if isinstance(body, syntax.ShortClass):
        return body.base.names == (definition.name,)
    return isinstance(body, syntax.ExtendsClass)


def _class_name(instance: Instance, name: str) -> str:
    if instance.prefix:
        return f"{instance.prefix}.{name}"
    owner = instance.cls.name
    return f"{owner}.{name}" if owner else name


def inner_half(element: Element) -> Element:
    """An `inner outer` element as what stands inside of its model sees it."""
    prefixes = element.definition.prefixes
    if not (prefixes.inner and prefixes.outer):
        return element
    if element.inner is None:
        alone = replace(element.definition, prefixes=replace(prefixes, outer=False))
        element.inner = Element(
            element.name, alone, element.scope, element.mod, element.protected, element.entry
        )
    return element.inner


def _only_sizes(element: Element, new: syntax.Component, scope: Scope) -> bool:
    """Sizes that are left open may be redeclared where the class stays (7.3.3)."""
    old = element.definition
    assert isinstance(old, syntax.Component)
    sizes = (*old.dimensions, *old.type_dimensions)
    others = (*new.dimensions, *new.type_dimensions)
    if old.prefixes.final or not any(isinstance(d, syntax.Colon) for d in sizes):
        return False
    if len(sizes) != len(others) or not all(map(_is_or_leaves_open, sizes, others)):
        return False
    own, other = lookup.find_class(element.scope, old.type), lookup.find_class(scope, new.type)
    return own.definition is other.definition and old.variability is new.variability


def _is_or_leaves_open(size: syntax.Expression, other: syntax.Expression) -> bool:
    if isinstance(size, syntax.Integer) and isinstance(other, syntax.Integer):
        return size.value == other.value
    return isinstance(size, syntax.Colon)


def _check_replaceable(element: Element, old: Span, new: Span) -> None:
    """Replaceable by its declaration, or by an earlier redeclaration that said so again."""
    prefixes, definition = element.definition.prefixes, element.definition
    if prefixes.final:
        raise final_error(element.name, new, old)
    constant = syntax.Variability.CONSTANT
    if isinstance(definition, syntax.Component) and definition.variability is constant:
        message = f"the constant `{element.name}` cannot be redeclared"
        raise error("F241", message, new, related=[Related("declared here", old)])
    if prefixes.replaceable:
        return
    message = f"`{element.name}` is not replaceable and cannot be redeclared"
    hint = "write `replaceable` in front of its declaration"
    raise error("F241", message, new, related=[Related("declared here", old)], hint=hint)


def effective_component(element: Element) -> tuple[syntax.Component, Scope, Mod]:
    """The declaration that counts, the scope of its text, and the whole modifier."""
    definition = element.definition
    assert isinstance(definition, syntax.Component)
    mod = element.mod
    redeclaration = mod.redeclaration
    if redeclaration is None:
        own = compile_modification(definition.modification, element.scope, default=True)
        if definition.prefixes.final:
            own = replace(own, final=True)
        if definition.constraint is not None:
            own = merge(own, _constraint_mod(element), element.name)
            _check_fit(element, lookup.find_class(element.scope, definition.type))
        return definition, element.scope, merge(mod, own, element.name)
    new = redeclaration.element
    if not isinstance(new, syntax.Component):
        message = f"`{element.name}` is a component and is redeclared as a class"
        related = [Related("declared here", definition.span)]
        raise error("F240", message, new.name_span, related=related)
    if not _only_sizes(element, new, redeclaration.scope):
        _check_replaceable(element, definition.span, new.span)
    _check_fit(element, lookup.find_class(redeclaration.scope, new.type))
    outer = replace(mod, redeclaration=None, final=False)
    own = compile_modification(new.modification, redeclaration.scope)
    if redeclaration.subscripts:
        own = subscript(own, redeclaration.subscripts, redeclaration.sizes)
    whole = merge(outer, own, element.name)
    whole = merge(whole, _said_inside(redeclaration), element.name)
    whole = merge(whole, _kept_mod(element), element.name)
    if mod.final or redeclaration.final or new.prefixes.final:
        whole = replace(whole, final=True)
    return _inherit_prefixes(definition, new), redeclaration.scope, whole


def written_dims(element: Element, layout: Layout) -> list[tuple[syntax.Expression, Scope]]:
    """The sizes of a component and of its type, each with the scope of its text: those of the
    declaration, where a redeclaration gives none (7.3)."""
    definition, scope, redeclaration = element.definition, element.scope, element.mod.redeclaration
    if redeclaration is not None and _has_sizes(redeclaration.element):
        definition, scope = redeclaration.element, redeclaration.scope
    assert isinstance(definition, syntax.Component)
    own = (*definition.dimensions, *definition.type_dimensions)
    return [*((d, scope) for d in own), *layout.dimensions]


def written_condition(element: Element) -> tuple[syntax.Expression, Scope] | None:
    """The condition of a component, with the scope of its text: that of the declaration, where
    redeclarations give none."""
    for definition, scope in _declarations(element):
        if isinstance(definition, syntax.Component) and definition.condition is not None:
            return definition.condition, scope
    return None


def _has_sizes(definition: syntax.Declaration) -> bool:
    """Some stand behind the name, or before it: `Real[3] x` is `Real x[3]` (10.1)."""
    return isinstance(definition, syntax.Component) and bool(
        definition.dimensions or definition.type_dimensions
    )


def _kept_mod(element: Element) -> Mod:
    """The modifier that a redeclaration keeps: the constraints', else the declaration's own."""
    definition, under = element.definition, _constraint_mod(element)
    if definition.constraint is not None:
        return under
    own = definition.body if isinstance(definition, syntax.ClassDef) else definition
    if not isinstance(own, syntax.Component | syntax.ShortClass):
        return under
    return merge(under, compile_modification(own.modification, element.scope, default=True))


def _constraint_mod(element: Element) -> Mod:
    """The modifiers of the constraining classes, under every other one."""
    under = NO_MOD
    for constraint, scope in _constraints(element):
        under = merge(under, compile_modification(constraint.modification, scope), element.name)
    return under


def _inherit_prefixes(old: syntax.Component, new: syntax.Component) -> syntax.Component:
    """Prefixes and dimensions that a redeclaration does not give again (7.3)."""
    prefixes = replace(
        new.prefixes,
        inner=new.prefixes.inner or old.prefixes.inner,
        outer=new.prefixes.outer or old.prefixes.outer,
        protected=old.prefixes.protected,
    )
    empty = syntax.Variability.CONTINUOUS
    sized = new if _has_sizes(new) else old
    return replace(
        new,
        prefixes=prefixes,
        variability=old.variability if new.variability is empty else new.variability,
        causality=old.causality if new.causality is syntax.Causality.NONE else new.causality,
        flow=old.flow if new.flow is syntax.Flow.NONE else new.flow,
        dimensions=sized.dimensions,
        type_dimensions=sized.type_dimensions,
        condition=new.condition or old.condition,
        comment=new.comment or old.comment,
    )
