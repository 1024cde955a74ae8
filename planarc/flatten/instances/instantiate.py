"""Instantiation: from a component's declaration to its node in the instance tree.

In:   Element (a component of an instance)
Out:  Leaf, Instance, Family or Absent, made once and kept in the element

Example: `Link link[2](m={1, 2})` becomes a Family of the instances `link[1]` with
m=1 and `link[2]` with m=2; `Real x[3]` becomes one Leaf with the dimension 3.

Promises:  conditions and dimensions are evaluated; what they depend on is marked
           structural. Nothing is made that is too large or contains itself.
Reference: Modelica Language Specification 3.6, sections 4.4, 5.6 and 10.1.
"""

from __future__ import annotations

import re
from itertools import product
from math import prod

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, error
from planarc.core.prose import shortened
from planarc.flatten.instances import outer, shape
from planarc.flatten.refusal import TooLarge, for_each, too_large, unsupported
from planarc.flatten.tree import annotation, lookup, redeclare
from planarc.flatten.tree.demand import layout_of, static_instance
from planarc.flatten.tree.modify import member_mod, merge, subscript
from planarc.flatten.tree.naming import member_names, not_modifiable
from planarc.flatten.tree.nodes import (
    Absent,
    Class,
    Element,
    Family,
    Instance,
    Layout,
    Leaf,
    Mod,
    Node,
    Scope,
    Session,
    State,
    silent,
)
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax

MAX_DEPTH = 100  # components inside components
MAX_ITEMS = 100_000  # components in one array
MAX_COMPONENTS = 300_000  # in the whole model
MAX_SCALARS = 10_000_000  # numbers in one variable
MAX_NESTING_OF_ONE_CLASS = 8

_VARIABILITY = {
    syntax.Variability.CONSTANT: flat.Variability.CONSTANT,
    syntax.Variability.PARAMETER: flat.Variability.PARAMETER,
    syntax.Variability.DISCRETE: flat.Variability.DISCRETE,
    syntax.Variability.CONTINUOUS: flat.Variability.CONTINUOUS,
}


def instantiate_model(session: Session, cls: Class) -> Instance:
    """The root of the tree: the model itself."""
    layout = layout_of(cls)
    instance = Instance(cls, layout, "", cls.mod, None, session)
    session.root = instance
    return instance


def make_node(element: Element) -> Node:
    """Fill in the node of a component."""
    if element.state is State.BROKEN:
        raise silent()
    if element.state is State.BUSY:
        message = f"the size or condition of `{element.name}` depends on itself"
        raise error("F250", message, element.definition.span)
    element.state = State.BUSY
    try:
        element.node = _make_node(element)
    except PlanarcError:
        element.state = State.BROKEN
        raise
    element.state = State.DONE
    return element.node


def _make_node(element: Element) -> Node:
    parent = element.scope.instance
    prefixes = element.definition.prefixes
    if prefixes.outer and parent.prefix is not None:
        return outer.inner_node(element)
    definition, scope, mod = redeclare.effective_component(element)
    name = parent.full_name(element.name)
    condition = redeclare.written_condition(element)
    what = f"the condition of `{name}`"
    if condition is not None and not evaluate.evaluate_condition(*condition, what):
        return Absent(name, element)
    cls = lookup.find_class(scope, definition.type)
    layout = layout_of(cls)
    if layout.builtin is not None:
        return _make_leaf(element, definition, scope, mod, cls, layout)
    return _make_composite(element, definition, scope, mod, cls, layout)


# Variables --------------------------------------------------------------------------------


def _make_leaf(
    element: Element,
    definition: syntax.Component,
    scope: Scope,
    mod: Mod,
    cls: Class,
    layout: Layout,
) -> Leaf:
    assert layout.builtin is not None
    parent = element.scope.instance
    name = parent.full_name(element.name)
    _refuse_special(layout.builtin, definition)
    if cls.mod:
        mod = merge(mod, cls.mod, element.name)
    variability = _leaf_variability(definition, layout.builtin, parent)
    leaf = Leaf(name, layout.builtin, variability, element, parent, mod, layout)
    leaf.causality, leaf.flow = _direction(definition, layout, parent)
    if leaf.flow is syntax.Flow.STREAM:
        raise unsupported("stream variables", "15", definition.span)
    in_bus = parent.layout.kind is syntax.ClassKind.EXPANDABLE_CONNECTOR
    leaf.is_connector = in_bus or layout.kind is syntax.ClassKind.CONNECTOR
    if written := redeclare.written_dims(element, layout):
        dims = shape.leaf_dims(leaf, written)
        if prod(d for d in dims if d) > MAX_SCALARS:  # also beside a size of zero
            message = f"`{name}` has {_times(dims)} elements, more than {MAX_SCALARS:,}"
            raise too_large(message, definition.span)
        leaf.type = layout.builtin.with_dims(dims)
    if parent.prefix is not None:
        parent.session.leaves[name] = leaf
    return leaf


def _direction(
    definition: syntax.Component, layout: Layout, parent: Instance
) -> tuple[syntax.Causality, syntax.Flow]:
    """The causality, and `flow` or `stream`: of the declaration, of its type, or of the record or
    connector around it, the first that there is (4.4.2.2)."""
    causality, flow = definition.causality, definition.flow
    if causality is _UNDIRECTED:
        causality = layout.causality
        if causality is _UNDIRECTED:
            causality = parent.causality
    if flow is _STILL:
        flow = layout.flow
        if flow is _STILL:
            flow = parent.flow
    return causality, flow


_UNDIRECTED, _STILL = syntax.Causality.NONE, syntax.Flow.NONE


def _leaf_variability(
    definition: syntax.Component, builtin: flat.Type, parent: Instance
) -> flat.Variability:
    own = _VARIABILITY[definition.variability]
    if own is flat.Variability.CONTINUOUS and builtin.base is not flat.Base.REAL:
        own = flat.Variability.DISCRETE
    return min(own, parent.variability)


def _refuse_special(builtin: flat.Type, definition: syntax.Component) -> None:
    if builtin.name == "ExternalObject":
        raise unsupported("external objects", "12.9.7", definition.span)


# Composites -----------------------------------------------------------------------------------


def _make_composite(
    element: Element,
    definition: syntax.Component,
    scope: Scope,
    mod: Mod,
    cls: Class,
    layout: Layout,
) -> Node:
    parent = element.scope.instance
    name = parent.full_name(element.name)
    _check_class(cls, layout, definition, name)
    _check_recursion(element, cls, parent)
    variability = min(_VARIABILITY[definition.variability], parent.variability)
    direction = _direction(definition, layout, parent)
    written = redeclare.written_dims(element, layout)
    session = parent.session

    annotation.find_visual(layout, session)

    def build(full: str, indices: tuple[int, ...] = (), sizes: tuple[int, ...] = ()) -> Instance:
        session.component_count += 1
        if session.component_count > MAX_COMPONENTS:
            raise too_large(f"the model has more than {MAX_COMPONENTS:,} components", None)
        prefix = full if parent.prefix is not None else None
        modifier = subscript(mod, indices, sizes) if sizes else mod
        modifier = merge(modifier, member_mod(cls.mod, cls, indices, sizes), element.name)
        made = Instance(cls, layout, prefix, modifier, parent, session, variability, element)
        made.indices, made.sizes = indices, sizes
        if made.is_record or made.is_connector:
            made.causality, made.flow = direction
        _refuse_value(made, modifier)
        check_modifier(made)
        return made

    if not written:
        return build(name)
    dims = shape.family_dims(written, element, mod, name)
    if prod(d for d in dims if d) > MAX_ITEMS:
        message = f"`{name}` has {_times(dims)} components, more than {MAX_ITEMS:,}"
        raise too_large(message, definition.span)
    items = []
    for indices in product(*(range(1, d + 1) for d in dims)):
        label = ",".join(map(str, indices))
        items.append(build(f"{name}[{label}]", indices, dims))
    return Family(name, dims, items, cls, element)


#: Kinds of components that hold elements with values, and have none themselves.
_PARTS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK)


def _refuse_value(made: Instance, modifier: Mod) -> None:
    """A model has no value: `part=Kind(a=1)` would be heeded by nobody."""
    binding = modifier.binding
    kind = made.cls.definition.kind
    if binding is None or made.element is None or kind not in _PARTS:
        return
    name, hint = made.element.name, f"set its elements, as in `{made.element.name}(...)`"
    value = binding.expression
    if isinstance(value, syntax.Call):
        inside = value.span.text[len(value.function.span.text) :]
        same = value.function.names[-1] == made.cls.definition.name
        hint = f"write `{name}{inside}`"
        if not same:
            hint = f"write `redeclare {value.function} {name}{inside}`"
        if binding.default:
            hint = f"write `{value.function} {name}{inside};`"
    message = f"`{name}` is a {kind.value} and takes no value"
    written = re.search(r"(\w+)\s*=\s*$", binding.span.source.text[: binding.span.start])
    if written is not None and written[1] != name and isinstance(value, syntax.Ref):
        message = f"`{written[1]}` is a class, the one of `{name}`, and takes no value"
        hint = f"write `redeclare {kind.value} {written[1]} = {value}`"
    raise error("F222", message, binding.span, hint=hint)


def _times(dims: flat.Dims) -> str:
    return " x ".join(f"{d:,}" for d in dims if d is not None)


def _check_class(cls: Class, layout: Layout, definition: syntax.Component, name: str) -> None:
    kind = layout.kind
    if kind in (syntax.ClassKind.PACKAGE, syntax.ClassKind.OPERATOR):
        message = f"`{name}` is declared of the {kind.value} `{cls.name}`"
        inside = [f"`{n}`" for n in member_names(static_instance(cls))]
        hint = f"take one of its classes: {shortened(inside, 8)}" if inside else None
        raise error("F253", message, definition.span, hint=hint)
    if kind in (syntax.ClassKind.FUNCTION, syntax.ClassKind.OPERATOR_FUNCTION):
        raise error("F253", f"`{name}` is declared of the function `{cls.name}`", definition.span)
    if _is_partial(layout):
        message = f"`{name}` is declared of the partial class `{cls.name}`"
        hint = "use a class that extends it"
        related = [Related("declared partial here", cls.span)]
        raise error("F254", message, definition.span, related=related, hint=hint)


def _is_partial(layout: Layout) -> bool:
    """A short class of a partial class is partial, too (4.5.1)."""
    index = 0
    while isinstance(layout.parts[index].definition.body, syntax.ShortClass):
        if layout.parts[index].definition.partial:
            return True
        index += 1
    return layout.parts[index].definition.partial


def _check_recursion(element: Element, cls: Class, parent: Instance) -> None:
    seen = sum(i.cls.definition is cls.definition for i in parent.outwards())
    if seen >= MAX_NESTING_OF_ONE_CLASS or parent.depth > MAX_DEPTH:
        message = f"`{cls.name}` contains itself through `{parent.full_name(element.name)}`"
        raise TooLarge(Diagnostic("F251", message, element.definition.span))


def check_modifier(instance: Instance) -> None:
    """Refuse modifiers of members that do not exist."""
    said = (instance.mod, *(part.cls.under for part in instance.layout.parts))
    subs = [sub for mod in said for sub in mod.subs.items()]
    for_each(subs, lambda sub: _check_modified(instance, *sub))


def _check_modified(instance: Instance, name: str, mod: Mod) -> None:
    members = instance.layout.members
    if name not in members:
        if lookup.member(instance, name) is None:
            holders = tuple(own for own, _ in lookup.holders(instance, (name,)))
            element = instance.element
            others = redeclare.replacements_with(element, name) if element else []
            if element and others and not holders:
                rest = f"({mod.span.text})" if mod.span else "(...)"
                raise error(
                    "F222",
                    f"`{element.name}` is a `{instance.cls.name}`, which has no element `{name}`",
                    mod.span,
                    hint=f"make it another one: write `redeclare {others[0]} {element.name}{rest}`",
                )
            raise not_modifiable(instance.cls.name, name, mod.span, members, holders)
        return
    index, definition = members[name]
    if mod.span is None or not (
        definition.prefixes.protected or instance.layout.parts[index].protected
    ):
        return
    scope = _origin(mod)
    if scope is not None and scope.instance is not instance:
        message = f"`{name}` is protected in `{instance.cls.name}` and cannot be modified"
        raise error("F214", message, mod.span)


def _origin(mod: Mod) -> Scope | None:
    """The scope that a modifier is written in, where it says anything."""
    said = mod.binding or mod.redeclaration
    if said is not None:
        return said.scope
    return next((s for s in map(_origin, mod.subs.values()) if s is not None), None)
