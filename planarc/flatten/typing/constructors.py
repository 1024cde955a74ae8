"""Record constructors and conversions to enumerations.

Reference: Modelica Language Specification 3.6, sections 12.6 and 4.9.5.2.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.nearest import did_you_mean
from planarc.flatten.functions import variables as function_variables
from planarc.flatten.tree import lookup, redeclare
from planarc.flatten.tree.modify import merge
from planarc.flatten.tree.nodes import Class, Element, Session
from planarc.flatten.typing import expressions
from planarc.flatten.typing.conform import expect
from planarc.flatten.typing.environment import Env
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax


def record_type(cls: Class, session: Session) -> flat.Type:
    """The type of a record class; sizes that are not constant are left open."""
    if cls.record is None:
        fields = []
        instance = lookup.static_instance(cls)
        for name, (_, definition) in instance.layout.members.items():
            if isinstance(definition, syntax.ClassDef):
                continue
            element = lookup.member(instance, name)
            assert element is not None
            fields.append((name, _field_type(element, session)))
        cls.record = flat.Type(flat.Base.RECORD, (), cls.name, (), tuple(fields))
    return cls.record


def _field_type(element: Element, session: Session) -> flat.Type:
    definition, scope, _ = redeclare.effective_component(element)
    cls = lookup.find_class(scope, definition.type)
    type_, layout = function_variables.variable_type(cls, session, definition.span)
    written = [(d, scope) for d in (*definition.dimensions, *definition.type_dimensions)]
    written += layout.dimensions
    dims: list[int | None] = []
    for expression, own in written:
        if isinstance(expression, syntax.Colon):
            dims.append(None)
            continue
        try:
            value = evaluate.try_value(expressions.type_expression(expression, Env(own)), Env(own))
        except PlanarcError:
            value = None  # depends on a parameter of the record
        dims.append(value if isinstance(value, int) else None)
    return type_.with_dims((*dims, *type_.dims))


def construct_record(node: syntax.Call, cls: Class, env: Env) -> flat.Expression:
    """`R(1, y=2)`: fields in order or by name, defaults for the rest."""
    instance = lookup.static_instance(cls)
    values: dict[str, flat.Expression] = {}
    names = [
        n
        for n, (_, d) in instance.layout.members.items()
        if isinstance(d, syntax.Component) and not _fixed(d)
    ]
    if len(node.arguments) > len(names):
        raise error(
            "F290", f"`{cls.name}` has {len(names)} fields, not {len(node.arguments)}", node.span
        )
    for name, argument in zip(names, node.arguments, strict=False):
        values[name] = expressions.type_expression(argument, env)
    for named in node.named:
        if named.name not in names:
            raise error(
                "F290",
                f"the record `{cls.name}` has no field `{named.name}`",
                named.span,
                hint=did_you_mean(named.name, names),
            )
        if named.name in values:
            raise error("F290", f"the field `{named.name}` is given twice", named.span)
        values[named.name] = expressions.type_expression(named.value, env)
    fields = []
    declared = dict(record_type(cls, env.session).fields)
    items: list[flat.Expression] = []
    for name, type_ in declared.items():
        if name not in values:
            values[name] = _default(cls, name, values, node, env)
        expect(type_, values[name], f"the field `{name}` of `{cls.name}`")
        fields.append((name, type_.with_dims(values[name].type.dims)))
        items.append(values[name])
    whole = flat.Type(flat.Base.RECORD, (), cls.name, (), tuple(fields))
    return flat.Record(whole, node.span, tuple(items))


def _fixed(definition: syntax.Component) -> bool:
    """Constants and final fields are no inputs of the constructor."""
    has_value = definition.modification is not None and definition.modification.binding is not None
    constant = definition.variability is syntax.Variability.CONSTANT
    return has_value and (constant or definition.prefixes.final)


def _default(
    cls: Class, name: str, values: dict[str, flat.Expression], node: syntax.Call, env: Env
) -> flat.Expression:
    element = lookup.member(lookup.static_instance(cls), name)
    assert element is not None
    _, _, mod = redeclare.effective_component(element)
    binding = merge(mod, cls.mod.sub(name), name).binding
    if binding is None:
        raise error("F290", f"`{cls.name}` needs a value for its field `{name}`", node.span)
    return expressions.type_expression(
        binding.expression, Env(binding.scope, dict(values), env.function)
    )


def convert_to_enumeration(node: syntax.Call, type_: flat.Type, env: Env) -> flat.Expression:
    """`Kind(i)`: the i-th literal."""
    if len(node.arguments) != 1 or node.named:
        raise error("F290", f"`{type_.name}` takes one Integer", node.span)
    argument = expressions.type_expression(node.arguments[0], env)
    expect(flat.INTEGER, argument, f"the argument of `{type_.name}`")
    value = evaluate.try_value(argument, env)
    if isinstance(value, int):
        if not 1 <= value <= len(type_.literals):
            raise error("F219", f"`{type_.name}` has no value {value}", node.span)
        return flat.Literal(type_, node.span, value)
    return flat.Builtin(type_, node.span, "Enumeration", (argument,))
