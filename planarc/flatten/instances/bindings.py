"""Bindings and attributes: what a declaration and its modifiers say of a variable.

In:   Leaf
Out:  its typed binding, its flat.Attributes

A record component may be bound as a whole; its fields then get their part of the
value, unless a modifier that stands further outside gives the field its own.

Example: `Revolute rev(phi(start=a))` in the component `arm` gives `arm.rev.phi`
the start value `arm.a`: the expression belongs to the scope that it is written in.

Reference: Modelica Language Specification 3.6, sections 4.4.4, 4.9 and 7.2.
"""

from __future__ import annotations

import re
from itertools import takewhile

from msgspec.structs import replace

from planarc.core.diagnostic import Once, PlanarcError, error, said
from planarc.core.nearest import did_you_mean, nearest
from planarc.core.prose import counted
from planarc.flatten.instances.starts import is_start_written
from planarc.flatten.terms.conform import conforms, expect, type_text
from planarc.flatten.terms.constant import Value, to_expression
from planarc.flatten.terms.quotes import meant_as_text, quoted
from planarc.flatten.terms.select import array, pick
from planarc.flatten.tree.modify import merge, type_mod
from planarc.flatten.tree.nodes import Binding, Env, Instance, Leaf, Mod, State, silent
from planarc.flatten.typing import references
from planarc.flatten.typing.modifiers import type_binding
from planarc.flatten.values import evaluate
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat, syntax
from planarc.ir.syntaxwalk import references_in

#: Attributes of all types, of those that are ordered, and of Reals (4.9).
_OF_ALL = ("start", "fixed", "quantity")
_ORDERED = (*_OF_ALL, "min", "max")
_OF_REALS = (*_ORDERED, "nominal", "stateSelect", "unit", "displayUnit", "unbounded")
ATTRIBUTES = {
    flat.Base.REAL: _OF_REALS,
    flat.Base.INTEGER: _ORDERED,
    flat.Base.ENUMERATION: _ORDERED,
    flat.Base.BOOLEAN: _OF_ALL,
    flat.Base.STRING: _OF_ALL,
    flat.Base.CLOCK: (),
}
#: Variables that have an attribute which not all have, and those of the ordered types.
_HOLDERS = ("only Reals", "only Reals, Integers and enumerations")


def make_binding(leaf: Leaf) -> flat.Expression | None:
    """Fill in the typed value of a variable's declaration."""
    if leaf.binding_state is State.BROKEN:
        raise silent()
    if leaf.binding_state is State.BUSY:
        raise error("F282", f"the value of `{leaf.name}` depends on itself", leaf.span)
    leaf.binding_state = State.BUSY
    try:
        leaf.binding = _find_binding(leaf)
        if leaf.binding is not None:
            fits, wanted = conforms(leaf.type, leaf.binding.type), leaf.type
            if not fits:
                wanted = _as_declared(leaf)
                if _is_sized_by_broken(leaf):
                    raise silent()
            part = leaf.parent.element
            shared = part is not None and part.definition.prefixes.inner
            _refuse_size_of_another(leaf, leaf.binding)
            expect(wanted, leaf.binding, f"the value of `{leaf.name}`", single=shared)
    except BaseException as problem:
        leaf.binding_state = State.BROKEN
        if isinstance(problem, PlanarcError):
            raise _with_type(leaf, problem) from None
        raise
    leaf.binding_state = State.DONE
    return leaf.binding


def _refuse_size_of_another(leaf: Leaf, value: flat.Expression) -> None:
    """Explain a vector that a class sizes by another one, as `q_end[size(q_begin, 1)]`: once for
    all that are sized so."""
    definition = leaf.element.definition
    if conforms(leaf.type, value.type) or not isinstance(definition, syntax.Component):
        return
    found = re.fullmatch(
        r"size\((\w+), *1\)", ", ".join(d.span.text for d in definition.dimensions)
    )
    if found is None or not len(leaf.type.dims) == len(value.type.dims) == 1:
        return
    part, size = leaf.parent.name, leaf.type.dims[0]
    other = f"{part}.{found[1]}" if part else found[1]
    message = (
        f"`{leaf.name}` has {counted(value.type.dims[0] or 0, 'value')}, but its size is that "
    )
    message += f"of `{other}`, which has {size}"
    hint = f"give `{found[1]}` and all that go with it as many values"
    raise PlanarcError(Once("F270", message, value.span, hint=hint, kind=f"size {other}"))


def _with_type(leaf: Leaf, problem: PlanarcError) -> PlanarcError:
    """The same, with the hint of who writes `PI` for `SimpleController.PI`."""
    first = next(iter(problem.diagnostics), None)
    if first is None or first.code != "F210" or first.span is None:
        return problem
    if leaf.type.base is flat.Base.STRING and leaf.mod.binding is not None:
        return meant_as_text(problem, leaf.mod.binding.span)
    name = first.span.text
    meant = [name] if name in leaf.type.literals else nearest(name, leaf.type.literals)
    if not meant:
        return problem
    hint = f"write `{type_text(leaf.type)}.{meant[0]}`"
    return PlanarcError(replace(first, hint=hint, mend=None))


def _as_declared(leaf: Leaf) -> flat.Type:
    """Its type with those sizes open that its value gives: `table[:, 2]`."""
    definition, dims = leaf.element.definition, leaf.type.dims
    if not isinstance(definition, syntax.Component):
        return leaf.type
    written = (*definition.dimensions, *definition.type_dimensions)
    if len(written) != len(dims):
        return leaf.type
    sizes = zip(dims, written, strict=True)
    return leaf.type.with_dims(tuple(None if isinstance(w, syntax.Colon) else d for d, w in sizes))


def _is_sized_by_broken(leaf: Leaf) -> bool:
    """Whether its sizes are those of a variable beside it whose value does not fit, as of `D` in
    `B[n, :], D[size(C, 1), size(B, 2)]`."""
    definition = leaf.element.definition
    if not isinstance(definition, syntax.Component):
        return False
    others = references_in((definition.dimensions, definition.type_dimensions))
    nodes = (e.node for o in others if (e := leaf.parent.elements.get(o.names[0])) is not None)
    return any(isinstance(n, Leaf) and n.binding_state is State.BROKEN for n in nodes)


def _find_binding(leaf: Leaf) -> flat.Expression | None:
    own = leaf.mod.binding or type_mod(leaf.layout).binding
    definition = leaf.element.definition
    constant = isinstance(definition, syntax.Component) and (
        definition.variability is syntax.Variability.CONSTANT
    )
    if own is not None and constant:
        return type_binding(own)  # no part of a record's value (12.6)
    record = record_binding(leaf.parent)
    if record is not None and (own is None or own.is_under(record)):
        value = record_value(leaf.parent)
        if value is not None:
            return references.field_of(value, leaf.element.name, value.span)
    return None if own is None else type_binding(own, leaf.type.dims)


def record_binding(instance: Instance) -> Binding | None:
    """The modifier that binds a record, or one that it is part of, as a whole."""
    if not instance.has_value:
        return None
    strongest: Binding | None = None
    for record in takewhile(lambda i: i.has_value, instance.outwards()):
        own = record.mod.binding
        if own is None:
            continue
        if strongest is None or strongest.default or not own.yields_to(strongest):
            strongest = own
    return strongest


def record_value(instance: Instance) -> flat.Expression | None:
    """The value of a record component that is bound as a whole."""
    if instance.value is None:
        own = instance.mod.binding
        outer = instance.parent
        above = record_binding(outer) if outer is not None and outer.has_value else None
        if above is not None and outer is not None and (own is None or own.is_under(above)):
            whole = record_value(outer)
            assert whole is not None and instance.element is not None
            value = references.field_of(whole, instance.element.name, whole.span)
            instance.value = pick(value, instance.indices)
        elif own is not None:
            value = type_binding(own)
            if value.type.base is not flat.Base.RECORD:
                raise _no_record(instance, value)
            instance.value = value
    return instance.value


def _no_record(instance: Instance, value: flat.Expression) -> PlanarcError:
    """The error of a number that is given to a record as a whole."""
    name, of = instance.name, instance.cls.name
    message = f"the value of `{name}` must be of type {of}, but is {type_text(value.type)}"
    operators = instance.layout.kind is syntax.ClassKind.OPERATOR_RECORD
    hint = f"write `{of}({value.span.text})`" if operators and not value.type.dims else None
    return error("F270", message, value.span, hint=hint)


# Attributes -----------------------------------------------------------------------------------


def make_attributes(leaf: Leaf) -> flat.Attributes:
    """Fill in the attributes of a variable: its modifiers over those of its type."""
    known = type_mod(leaf.layout)
    if leaf.mod.subs:
        merged = merge(Mod(subs=leaf.mod.subs), Mod(subs=known.subs), leaf.name)
        _check_attribute_names(merged, leaf)
        leaf.attributes = _attributes(merged, leaf, written=True)
    else:
        found = leaf.layout.type_attributes
        if leaf.type.dims not in found:
            _check_attribute_names(known, leaf)
            found[leaf.type.dims] = _attributes(known, leaf, written=False)
        leaf.attributes = found[leaf.type.dims]
    return leaf.attributes


def _check_attribute_names(mod: Mod, leaf: Leaf) -> None:
    """Refuse what is no attribute: once for all variables of a type that gives it."""
    known = ATTRIBUTES[leaf.type.base]
    for name, sub in mod.subs.items():
        if name not in known:
            message = f"the variable `{leaf.name}` has no attribute `{name}` to modify"
            near, hint = did_you_mean(name, known), None
            if name in _OF_REALS:
                near, type_ = None, type_text(leaf.type.with_dims(()))
                message += f": its type is {type_}"
                hint = f"remove it: {_HOLDERS[name in _ORDERED]} have such an attribute"
            kind = f"{sub.span.source.name}:{sub.span.start}" if sub.span else ""
            told = Once("F222", message, sub.span, hint=hint or said(near), mend=near, kind=kind)
            raise PlanarcError(told)


def _attributes(mod: Mod, leaf: Leaf, written: bool) -> flat.Attributes:
    start = _value(mod, "start", leaf, leaf.type)
    return flat.Attributes(
        start=start,
        fixed=_fixed(mod, leaf),
        min=_value(mod, "min", leaf, leaf.type),
        max=_value(mod, "max", leaf, leaf.type),
        nominal=_value(mod, "nominal", leaf, leaf.type),
        state_select=_state_select(mod, leaf),
        unit=_text(mod, "unit", leaf),
        display_unit=_text(mod, "displayUnit", leaf),
        quantity=_text(mod, "quantity", leaf),
        start_written=written
        and start is not None
        and is_start_written(leaf, mod.sub("start").binding),
        fixed_written=written and is_start_written(leaf, mod.sub("fixed").binding),
    )


def _value(mod: Mod, name: str, leaf: Leaf, wanted: flat.Type) -> flat.Expression | None:
    binding = mod.sub(name).binding
    if binding is None:
        return None
    of_class, dims = _is_of_class(name, binding, leaf), leaf.type.dims
    own = dims[len(dims) - len(leaf.layout.dimensions) :] if of_class else dims
    value = type_binding(binding, own)
    what = f"the attribute `{name}` of `{leaf.name}`"
    expected = wanted.with_dims(dims)
    if not value.type.dims and dims and (of_class or _stands_for_all(binding)):
        expected = wanted.with_dims(())
    elif of_class and len(value.type.dims) == len(own):  # `type V = Real[2](start={1, 2})`
        expected = wanted.with_dims(own)
    expect(expected, value, what, binding.span)
    if expected.dims:
        value = _repeated(value, dims[: len(dims) - len(expected.dims)])
    if variability_of(value, leaf.parent.session) > flat.Variability.PARAMETER:
        hint = "write a number or a parameter"
        if name == "start":
            hint += f", or give `{leaf.name}` its value by an `initial equation`"
        raise error("F285", f"{what} must not change with time", binding.span, hint=hint)
    return value


def _repeated(value: flat.Expression, sizes: flat.Dims) -> flat.Expression:
    """An array of these sizes whose entries all have one value, which is an array."""
    for size in reversed(sizes):
        value = array([value] * (size or 0), value.type, value.span)
    return value


def _fixed(mod: Mod, leaf: Leaf) -> flat.Expression | None:
    """Whether a start is fixed. Of a parameter that is known now, and shapes the model: one that is
    not fixed is an unknown at the start."""
    value = _value(mod, "fixed", leaf, flat.BOOLEAN)
    if value is None or leaf.variability is not flat.Variability.PARAMETER:
        return value
    known = evaluate.try_value(value, Env(leaf.parent.scope()), mark=True)
    return value if known is None else to_expression(known, value.type, value.span)


def _is_of_class(name: str, binding: Binding, leaf: Leaf) -> bool:
    """The type says so itself, as `type T = Real(min=0)`, or a modifier of it, as `H h(T(min=0))`:
    each variable has it then, whatever its sizes are."""
    said = (type_mod(leaf.layout), leaf.layout.parts[0].cls.mod)
    found = [own for mod in said if (own := mod.sub(name).binding) is not None]
    return any(own.expression is binding.expression for own in found)


def _stands_for_all(binding: Binding) -> bool:
    """`each` was written, or what is static."""
    return binding.each or binding.scope.instance.prefix is None


def _text(mod: Mod, name: str, leaf: Leaf) -> str:
    binding = mod.sub(name).binding
    if binding is None:
        return ""
    try:
        typed = _first_scalar(type_binding(binding))
    except PlanarcError as problem:
        raise meant_as_text(problem, binding.span) from None
    if typed.type.base is not flat.Base.STRING:
        written = quoted(binding.span)
        hint = f"write {written}" if written else None
        raise error("F270", f"the attribute `{name}` must be a String", binding.span, hint=hint)
    value = _known(typed, name, leaf)
    assert isinstance(value, str)
    return value


def _state_select(mod: Mod, leaf: Leaf) -> flat.StateSelect:
    binding = mod.sub("stateSelect").binding
    if binding is None:
        return flat.StateSelect.DEFAULT
    typed = _first_scalar(type_binding(binding))
    if typed.type.name != "StateSelect":
        message = f"must be a StateSelect, but is {type_text(typed.type)}"
        raise error("F270", f"the attribute `stateSelect` {message}", binding.span)
    return flat.StateSelect(_known(typed, "stateSelect", leaf))  # type: ignore[arg-type]


def _known(value: flat.Expression, name: str, leaf: Leaf) -> Value:
    return evaluate.structural_value(value, Env(leaf.parent.scope()), f"the attribute `{name}`")


def _first_scalar(value: flat.Expression) -> flat.Expression:
    while value.type.dims:
        if value.type.dims[0] == 0:
            raise error("F270", "an attribute cannot be an empty array", value.span)
        value = pick(value, (1,))
    return value
