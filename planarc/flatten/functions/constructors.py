"""Record constructors and conversions to enumerations.

Reference: Modelica Language Specification 3.6, sections 12.6 and 4.9.5.2.
"""

from __future__ import annotations

from typing import TypeGuard

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.nearest import did_you_mean
from planarc.core.prose import counted, ticked
from planarc.flatten.functions.variables import record_type
from planarc.flatten.terms.conform import expect, unify_dims
from planarc.flatten.terms.select import array
from planarc.flatten.tree import lookup, redeclare
from planarc.flatten.tree.demand import node_of, static_instance
from planarc.flatten.tree.modify import merge
from planarc.flatten.tree.nodes import Class, Env, Family, Instance
from planarc.flatten.typing import references
from planarc.flatten.typing.references import View
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax


def construct_record(node: syntax.Call, cls: Class, env: Env) -> flat.Expression:
    """`R(1, y=2)`: fields in order or by name, defaults for the rest; `R(part)`: those of it."""
    if (part := _part_given(node, env)) is not None:
        return _cast(part, node, cls, env)
    values: flat.Named = {}
    names = inputs_of(cls)
    if len(node.arguments) > len(names):
        message = f"`{cls.name}` has {counted(len(names), 'field')}, not {len(node.arguments)}"
        told = f"its fields are {ticked(names)}" if names else None
        raise error("F290", message, node.span, hint=told)
    for name, argument in zip(names, node.arguments, strict=False):
        values[name] = env.typed(argument)
    for named in node.named:
        if named.name not in names:
            message = f"the record `{cls.name}` has no field `{named.name}`"
            hint = did_you_mean(named.name, names) or f"its fields are {ticked(names)}"
            raise error("F290", message, named.span, hint=hint)
        if named.name in values:
            raise error("F290", f"the field `{named.name}` is given twice", named.span)
        values[named.name] = env.typed(named.value)
    return _complete(values, node, cls, env)


def _complete(values: flat.Named, node: syntax.Call, cls: Class, env: Env) -> flat.Expression:
    """The record with some of its fields, and the defaults of the others."""
    fields = []
    declared = dict(record_type(cls, env.session).fields)
    items: list[flat.Expression] = []
    for name, type_ in declared.items():
        if name not in values:
            values[name] = _default(cls, name, values, node, env)
        expect(type_, values[name], f"the field `{name}` of `{cls.name}`")
        dims = unify_dims(type_.dims, values[name].type.dims)
        fields.append((name, type_.with_dims(dims)))
        items.append(values[name])
    whole = flat.Type(flat.Base.RECORD, (), cls.name, (), tuple(fields))
    return flat.Record(whole, node.span, tuple(items))


# Casts -------------------------------------------------------------------------------------------


def _part_given(node: syntax.Call, env: Env) -> Instance | Family | list[View] | None:
    """The model, block or connector that is the one argument of a constructor (12.6.1), or an
    array of them."""
    if len(node.arguments) != 1 or node.named or not isinstance(node.arguments[0], syntax.Ref):
        return None
    ref = node.arguments[0]
    if not ref.absolute and ref.parts[0].name in env.locals:
        return None
    try:
        view = references.resolve(ref, env)
    except PlanarcError:
        return None  # told of as any other argument
    return view if _is_part(view) else None


def _is_part(view: View) -> TypeGuard[Instance | Family | list[View]]:
    one: View = view
    while isinstance(one, Family | list):
        inside = one.items if isinstance(one, Family) else one
        if not inside:
            return False
        one = inside[0]
    return isinstance(one, Instance) and one.prefix is not None and not one.has_value


def _cast(view: View, node: syntax.Call, cls: Class, env: Env) -> flat.Expression:
    """A record of what a part calls as the record does its fields, or an array of records."""
    if isinstance(view, Family):
        view = references.nested(view)
    if isinstance(view, list):
        items = [_cast(one, node, cls, env) for one in view]
        return array(items, items[0].type, node.span)
    assert isinstance(view, Instance)
    values = {}
    for name in inputs_of(cls):
        if name in view.layout.members:
            values[name] = _field_of_part(view, name, node, cls, env)
    return _complete(values, node, cls, env)


def _field_of_part(
    part: Instance, name: str, node: syntax.Call, cls: Class, env: Env
) -> flat.Expression:
    inner = node_of(lookup.public_member(part, name, node.span))
    if not _is_part(inner):
        return references.node_value(inner, node.span, env)
    definition, scope, _ = redeclare.effective_component(
        lookup.declared(static_instance(cls), name)
    )
    return _cast(inner, node, lookup.find_class(scope, definition.type), env)


# Fields ------------------------------------------------------------------------------------------


def inputs_of(cls: Class) -> list[str]:
    """The fields that the constructor of a record takes, in their order."""
    members = static_instance(cls).layout.members
    return [n for n, (_, d) in members.items() if isinstance(d, syntax.Component) and not _fixed(d)]


def _fixed(definition: syntax.Component) -> bool:
    """Constants and final fields are no inputs of the constructor."""
    has_value = definition.modification is not None and definition.modification.binding is not None
    constant = definition.variability is syntax.Variability.CONSTANT
    return has_value and (constant or definition.prefixes.final)


def _default(
    cls: Class, name: str, values: flat.Named, node: syntax.Call, env: Env
) -> flat.Expression:
    element = lookup.declared(static_instance(cls), name)
    _, _, mod = redeclare.effective_component(element)
    binding = merge(mod, cls.mod.sub(name), name).binding
    if binding is None:
        raise error("F290", f"`{cls.name}` needs a value for its field `{name}`", node.span)
    return Env(binding.scope, dict(values), env.function).typed(binding.expression)


def convert_to_enumeration(node: syntax.Call, type_: flat.Type, env: Env) -> flat.Expression:
    """`Kind(i)`: the i-th literal."""
    if len(node.arguments) != 1 or node.named:
        raise error("F290", f"`{type_.name}` takes one Integer", node.span)
    argument = env.typed(node.arguments[0])
    expect(flat.INTEGER, argument, f"the argument of `{type_.name}`")
    value = evaluate.try_value(argument, env)
    if isinstance(value, int):
        if not 1 <= value <= len(type_.literals):
            raise error("F219", f"`{type_.name}` has no value {value}", node.span)
        return flat.Literal(type_, node.span, value)
    return flat.Builtin(type_, node.span, "Enumeration", (argument,))
