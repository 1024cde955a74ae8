"""The variables of a function: inputs, outputs and locals, with types and sizes.

A size that depends on an argument is kept as an expression; a type may be built-in, a
record, or the interface of a function that is handed in. Of the results, the types are known
before the body is looked at: with `output Real w[size(v, 1)]` a call with a vector of three
entries has a result of three.

Reference: Modelica Language Specification 3.6, sections 12.1, 12.2 and 12.4.2.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.functions.order import names_in_order
from planarc.flatten.terms.conform import expect
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree import lookup, redeclare
from planarc.flatten.tree.demand import layout_of, static_instance
from planarc.flatten.tree.modify import merge, type_mod
from planarc.flatten.tree.nodes import (
    RECORD_KINDS,
    Class,
    Element,
    Env,
    Instance,
    Layout,
    Mod,
    Scope,
    Session,
    Signature,
)
from planarc.flatten.typing import references
from planarc.flatten.values import evaluate, evaluator
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import nodes_of


def declare_variables(
    instance: Instance, signature: Signature
) -> list[tuple[flat.Variable, syntax.Causality]]:
    """The variables of a function, in the order in which they get their first values."""
    found: list[tuple[flat.Variable, syntax.Causality]] = []
    names: flat.Named = {}
    for name in names_in_order(instance):
        variable, causality = _declare(instance, name, names, signature)
        names[name] = flat.Reference(variable.type, variable.span, name)
        found.append((variable, causality))
    return found


def interface(
    instance: Instance,
    variables: list[tuple[flat.Variable, syntax.Causality]],
    causality: syntax.Causality,
) -> tuple[flat.Variable, ...]:
    """The inputs or the outputs, in the order of the text, which is that of arguments."""
    found = {v.name: v for v, c in variables if c is causality}
    return tuple(found[name] for name in instance.layout.members if name in found)


def _declare(
    instance: Instance, name: str, names: flat.Named, signature: Signature
) -> tuple[flat.Variable, syntax.Causality]:
    element = lookup.declared(instance, name)
    definition, scope, mod = redeclare.effective_component(element)
    env = Env(scope, dict(names), signature)
    cls = lookup.find_class(scope, definition.type)
    type_, layout = variable_type(cls, env.session, definition.span)
    written = redeclare.written_dims(element, layout)
    merged = merge(mod, cls.mod, name) if cls.mod else mod
    binding = merged.binding
    causality = (
        layout.causality if definition.causality is syntax.Causality.NONE else definition.causality
    )
    value = None
    is_input = causality is syntax.Causality.INPUT
    if binding is not None and is_input:
        signature.defaults[name] = (binding.expression, binding.scope)
    elif binding is not None:
        own = env if binding.scope is scope else Env(binding.scope, dict(names), signature)
        value = own.typed(binding.expression)
    own_type = type_.with_dims((None,) * len(written))
    itself = flat.Reference(own_type, definition.span, name)
    dims, sizes = _dims(written, {**names, name: itself}, signature, value)
    type_ = type_.with_dims(dims + type_.dims)
    if value is not None:
        expect(type_, value, f"the value of `{name}`")
    if value is not None and definition.variability is syntax.Variability.CONSTANT:
        _refuse_variables(name, value, names.keys() - signature.constants.keys())
        signature.constants[name] = value
    if (
        not is_input
        and causality is syntax.Causality.NONE
        and instance.layout.parts[0].definition.kind is syntax.ClassKind.FUNCTION
        and not (definition.prefixes.protected or element.protected)
        and definition.variability is not syntax.Variability.CONSTANT
    ):
        message = f"the local variable `{name}` of the function `{instance.cls.name}` is public"
        hint = "declare it under `protected`"
        env.session.warn("F296", message, definition.span, hint)
    return (
        flat.Variable(
            name,
            type_,
            flat.Variability.CONTINUOUS,
            definition.span,
            value,
            flat.Attributes(unit=_unit(merged, layout)),
            causality=causality.value,
            description=definition.comment,
            sizes=sizes,
        ),
        causality,
    )


def _refuse_variables(name: str, value: flat.Expression, variables: set[str]) -> None:
    """The value of a constant must not depend on what a call gives."""
    for e in nodes_of((value,)):
        if isinstance(e, flat.Reference) and e.name in variables:
            message = f"the constant `{name}` must not depend on the variable `{e.name}`"
            raise error("F285", message, e.span)


def _unit(mod: Mod, layout: Layout) -> str:
    """The unit of a variable, where it is written as a plain text."""
    binding = mod.sub("unit").binding or type_mod(layout).sub("unit").binding
    written = None if binding is None else binding.expression
    return written.value if isinstance(written, syntax.String) else ""


def _dims(
    written: list[tuple[syntax.Expression, Scope]],
    names: flat.Named,
    signature: Signature,
    value: flat.Expression | None,
) -> tuple[flat.Dims, tuple[flat.Expression | None, ...]]:
    """Sizes that are known, and expressions for those that are known only when run."""
    dims: list[int | None] = []
    sizes: list[flat.Expression | None] = []
    for k, (expression, scope) in enumerate(written):
        if isinstance(expression, syntax.Colon):
            known = None
            if value is not None and k < len(value.type.dims):
                known = value.type.dims[k]
            dims.append(known)
            sizes.append(None)
            continue
        env = Env(scope, names, signature)
        size: object = references.size_of_type(expression, scope)
        typed = None if isinstance(size, int) else env.typed(expression)
        if typed is not None and typed.type.base is flat.Base.REAL:
            raise error("F255", "a size must be an Integer, but is Real", expression.span)
        size = size if typed is None else evaluate.try_value(typed, env, mark=True)
        dims.append(size if isinstance(size, int) else None)
        sizes.append(None if isinstance(size, int) else typed)
    if all(s is None for s in sizes):
        return tuple(dims), ()
    return tuple(dims), tuple(sizes)


def variable_type(cls: Class, session: Session, span: Span) -> tuple[flat.Type, Layout]:
    """The type of a variable of a function: built-in, record, or a function itself."""
    layout = layout_of(cls)
    if layout.builtin is not None:
        return layout.builtin, layout
    if layout.kind in RECORD_KINDS:
        return record_type(cls, session), layout
    if layout.kind is syntax.ClassKind.FUNCTION:
        return _formal_type(cls, session), layout
    message = f"a variable of a function cannot be of the {layout.kind.value} `{cls.name}`"
    raise error("F297", message, span)


def record_type(cls: Class, session: Session) -> flat.Type:
    """The type of a record class; sizes that are not constant are left open."""
    if cls.record is None:
        parts = lookup.components(static_instance(cls))
        fields = tuple((name, _field_type(element, session)) for name, element in parts)
        cls.record = flat.Type(flat.Base.RECORD, (), cls.name, (), fields)
        if layout_of(cls).kind is syntax.ClassKind.OPERATOR_RECORD:
            session.operator_records[cls.name] = cls
    return cls.record


def _field_type(element: Element, session: Session) -> flat.Type:
    definition, scope, _ = redeclare.effective_component(element)
    cls = lookup.find_class(scope, definition.type)
    type_, layout = variable_type(cls, session, definition.span)
    dims: list[int | None] = []
    for expression, own in redeclare.written_dims(element, layout):
        if isinstance(expression, syntax.Colon):
            dims.append(None)
            continue
        try:
            value: object = references.size_of_type(expression, own)
            if value is None:
                value = evaluate.try_value(Env(own).typed(expression), Env(own))
        except PlanarcError:
            value = None  # depends on a parameter of the record
        dims.append(value if isinstance(value, int) else None)
    return type_.with_dims((*dims, *type_.dims))


def _formal_type(cls: Class, session: Session) -> flat.Type:
    """The type of an input that is a function: the interface that it declares."""
    if cls.name not in session.formals:
        signature = Signature(cls.name)
        instance = static_instance(cls)
        variables = declare_variables(instance, signature)
        signature.inputs = interface(instance, variables, syntax.Causality.INPUT)
        signature.outputs = interface(instance, variables, syntax.Causality.OUTPUT)
        session.formals[cls.name] = signature
    return flat.Type(flat.Base.FUNCTION, name=cls.name)


# Types of results ---------------------------------------------------------------------


def result_type(
    signature: Signature,
    output: int,
    arguments: list[flat.Expression],
    span: Span,
    session: Session,
) -> flat.Type:
    """The type of a result; sizes that depend on the arguments are computed."""
    if output >= len(signature.outputs):
        raise error("F290", f"`{signature.name}` has no result", span)
    return type_at_call(signature.outputs[output], signature, arguments, session)


def type_at_call(
    variable: flat.Variable,
    signature: Signature,
    arguments: Sequence[flat.Expression],
    session: Session,
) -> flat.Type:
    """The type of an input or output, with the sizes that follow from the arguments."""
    if None not in variable.type.dims:
        return variable.type
    frame = {v.name: a for v, a in zip(signature.inputs, arguments, strict=False)}
    dims = tuple(
        size if size is not None else _known_size(variable, k, frame, session)
        for k, size in enumerate(variable.type.dims)
    )
    return variable.type.with_dims(dims)


def _known_size(
    variable: flat.Variable, k: int, arguments: flat.Named, session: Session
) -> int | None:
    """The size of a variable as far as the types and values of the arguments tell it."""
    if k >= len(variable.sizes) or variable.sizes[k] is None:
        return None
    size = variable.sizes[k]
    assert size is not None
    known = evaluator.Evaluator(session)
    known.closed = True  # what a parameter makes is not known yet
    try:
        value = known.value(_insert(size, arguments))
    except NotConstant:
        return None
    return value if isinstance(value, int) else None


def _insert(e: flat.Expression, arguments: flat.Named) -> flat.Expression:
    """Inputs replaced by arguments, in an expression of a size."""
    match e:
        case flat.Reference(name=name) if name in arguments and not e.subscripts:
            return arguments[name]
        case flat.Unary():
            return flat.Unary(e.type, e.span, e.op, _insert(e.operand, arguments))
        case flat.Binary():
            left, right = _insert(e.left, arguments), _insert(e.right, arguments)
            return flat.Binary(e.type, e.span, e.op, left, right)
        case flat.Builtin():
            inner = tuple(_insert(a, arguments) for a in e.arguments)
            return flat.Builtin(e.type, e.span, e.function, inner)
        case flat.Call():
            given = tuple(_insert(a, arguments) for a in e.arguments)
            return flat.Call(e.type, e.span, e.function, given, e.output)
        case flat.If():
            branches = tuple((_insert(c, arguments), _insert(v, arguments)) for c, v in e.branches)
            return flat.If(e.type, e.span, branches, _insert(e.otherwise, arguments))
    return e
