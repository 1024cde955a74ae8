"""Functions: from a function class to a `flat.Function`, made once and named once.

In:   Class of kind function
Out:  FunctionInfo   what a call needs: the signature, and inputs that are bound already

A short class that only binds inputs, `function g = f(a=p)`, is no new function: a
call of `g` is a call of `f` with `p` filled in. What a function reads from the model
around it through such bindings becomes an additional input, and every call hands
it in, so that a flat function depends on its arguments only.

Example: inside the component `curve`, `function position = circle(R=R)`:
    position(s)   becomes   Call("...circle", (s, curve.R))

Reference: Modelica Language Specification 3.6, sections 12.1 to 12.4, 12.7 and 12.9.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.source import Span
from planarc.flatten import (
    annotation,
    compute,
    constructors,
    evaluate,
    expressions,
    inherit,
    lookup,
    redeclare,
    statements,
)
from planarc.flatten.conform import expect
from planarc.flatten.constant import NotConstant
from planarc.flatten.environment import Env
from planarc.flatten.modify import merge
from planarc.flatten.refusal import unsupported
from planarc.flatten.tree import Binding, Class, Instance, Layout, Leaf, Mod, Scope, Session
from planarc.ir import flat, syntax


@dataclass(slots=True)
class Signature:
    """Inputs and outputs of a function, and what it reads from the model."""

    name: str
    inputs: tuple[flat.Variable, ...] = ()
    outputs: tuple[flat.Variable, ...] = ()
    defaults: dict[str, tuple[syntax.Expression, Scope]] = field(default_factory=dict)
    constants: dict[str, flat.Expression] = field(default_factory=dict)
    captures: list[Leaf] = field(default_factory=list)
    builtin: str | None = None  # the function only stands for this built-in
    done: bool = False
    called_early: bool = False  # by itself, while it was being made

    def result_type(self, output: int, arguments: list[flat.Expression], span: Span) -> flat.Type:
        """The type of a result; sizes that depend on the arguments are computed."""
        variable = self.outputs[output]
        if None not in variable.type.dims:
            return variable.type
        frame = {v.name: a for v, a in zip(self.inputs, arguments, strict=False)}
        dims = tuple(
            size if size is not None else _known_size(variable, k, frame)
            for k, size in enumerate(variable.type.dims)
        )
        return variable.type.with_dims(dims)


@dataclass(slots=True)
class FunctionInfo:
    """A function class as seen by a call."""

    name: str
    signature: Signature
    bound: dict[str, Binding]


@dataclass(slots=True)
class FunctionBuilder:
    """Collects what the body of a function reads from the model."""

    signature: Signature
    names: dict[str, Leaf] = field(default_factory=dict)

    def capture(self, leaf: Leaf, span: Span) -> flat.Expression:
        if leaf.name not in self.names:
            self.names[leaf.name] = leaf
            self.signature.captures.append(leaf)
        return flat.Reference(leaf.type, span, leaf.name)


def _known_size(
    variable: flat.Variable, k: int, arguments: dict[str, flat.Expression]
) -> int | None:
    """The size of an output as far as the types and values of the arguments tell it."""
    if k >= len(variable.sizes) or variable.sizes[k] is None:
        return None
    size = variable.sizes[k]
    assert size is not None
    try:
        value = evaluate.Evaluator(None).value(_insert(size, arguments))
    except NotConstant:
        return None
    return value if isinstance(value, int) else None


def _insert(e: flat.Expression, arguments: dict[str, flat.Expression]) -> flat.Expression:
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
        case flat.If():
            branches = tuple((_insert(c, arguments), _insert(v, arguments)) for c, v in e.branches)
            return flat.If(e.type, e.span, branches, _insert(e.otherwise, arguments))
    return e


# Finding the function ----------------------------------------------------------------------------


def function_of(cls: Class, session: Session, span: Span) -> FunctionInfo:
    """What a call of a function class needs; the function is made when first called."""
    if cls.function is None:
        base, bound = _unwrap(cls)
        if base is not cls:
            inner = function_of(base, session, span)
            cls.function = FunctionInfo(cls.name, inner.signature, {**inner.bound, **bound})
        else:
            cls.function = _make(cls, session, span)
    elif not cls.function.signature.done:
        cls.function.signature.called_early = True
    return cls.function


def _unwrap(cls: Class) -> tuple[Class, dict[str, Binding]]:
    """The function that a short class stands for, and the inputs it binds."""
    layout = inherit.layout_of(cls)
    index = 0
    while isinstance(layout.parts[index].definition.body, syntax.ShortClass):
        index += 1
    if index == 0:
        return cls, {}
    mod = lookup.part_mod(lookup.static_instance(cls), index)
    base = layout.parts[index].cls
    if not _binds_inputs_only(mod, inherit.layout_of(base).members, cls):
        return cls, {}
    bound = {name: sub.binding for name, sub in mod.subs.items() if sub.binding is not None}
    return base, bound


def _binds_inputs_only(
    mod: Mod, members: dict[str, tuple[int, syntax.Component | syntax.ClassDef]], cls: Class
) -> bool:
    for name, sub in mod.subs.items():
        if name not in members:
            raise error(
                "F222",
                f"`{cls.name}` has no element `{name}` to modify",
                sub.span,
                hint=lookup.suggestion(name, members),
            )
        definition = members[name][1]
        if (
            sub.redeclaration is not None
            or sub.subs
            or not isinstance(definition, syntax.Component)
        ):
            return False
        if definition.causality is not syntax.Causality.INPUT:
            return False
    return True


# Making it ---------------------------------------------------------------------------------------


def _make(cls: Class, session: Session, span: Span) -> FunctionInfo:
    layout = inherit.layout_of(cls)
    if layout.derivative is not None:
        return _make_derivative(cls, session, span)
    signature = Signature(_unique_name(cls.name, session))
    session.signatures[signature.name] = signature
    cls.function = info = FunctionInfo(signature.name, signature, {})
    try:
        if _partial(cls):
            raise error("F295", f"the function `{cls.name}` is partial and cannot be called", span)
        _fill(cls, lookup.static_instance(cls), signature, session)
    except PlanarcError:
        cls.function = None
        raise
    if signature.called_early and signature.captures:
        raise unsupported("recursive functions that use variables of the model", "12.4", span)
    signature.done = True
    return info


def _partial(cls: Class) -> bool:
    return cls.definition.partial


def _unique_name(name: str, session: Session) -> str:
    unique, count = name, 1
    while unique in session.signatures:
        count += 1
        unique = f"{name}#{count}"
    return unique


def _fill(cls: Class, instance: Instance, signature: Signature, session: Session) -> None:
    builder = FunctionBuilder(signature)
    variables = declare_variables(instance, builder, signature)
    signature.inputs = tuple(v for v, c in variables if c is syntax.Causality.INPUT)
    signature.outputs = tuple(v for v, c in variables if c is syntax.Causality.OUTPUT)
    locals_ = tuple(v for v, c in variables if c is syntax.Causality.NONE)
    names: dict[str, flat.Expression] = {
        v.name: flat.Reference(v.type, v.span, v.name) for v, _ in variables
    }
    external = _external(instance, signature)
    body = () if external else function_body(instance, names, builder)
    if not external:
        signature.builtin = _plain_builtin(body, signature)
    hidden = tuple(_hidden_input(leaf) for leaf in signature.captures)
    session.functions[signature.name] = flat.Function(
        signature.name,
        signature.inputs + hidden,
        signature.outputs,
        locals_,
        body,
        external,
        None,
        annotation.derivatives_of(instance, session),
        cls.span,
    )


def _plain_builtin(body: tuple[flat.Statement, ...], signature: Signature) -> str | None:
    """A body that is nothing but `y := sin(u)`: the function stands for the built-in."""
    if len(body) != 1 or not isinstance(body[0], flat.Assignment):
        return None
    value = body[0].value
    if not isinstance(value, flat.Builtin) or value.function not in compute.SCALAR:
        return None
    names = [a.name for a in value.arguments if isinstance(a, flat.Reference) and not a.subscripts]
    same = names == [v.name for v in signature.inputs]
    return value.function if same and len(names) == len(value.arguments) else None


def _hidden_input(leaf: Leaf) -> flat.Variable:
    return flat.Variable(leaf.name, leaf.type, leaf.variability, leaf.span, causality="input")


def declare_variables(
    instance: Instance, builder: FunctionBuilder, signature: Signature
) -> list[tuple[flat.Variable, syntax.Causality]]:
    """The variables of a function, in order of declaration."""
    found: list[tuple[flat.Variable, syntax.Causality]] = []
    names: dict[str, flat.Expression] = {}
    for name, (_, definition) in instance.layout.members.items():
        if isinstance(definition, syntax.ClassDef):
            continue
        variable, causality = _declare(instance, name, names, builder, signature)
        names[name] = flat.Reference(variable.type, variable.span, name)
        found.append((variable, causality))
    return found


def _declare(
    instance: Instance,
    name: str,
    names: dict[str, flat.Expression],
    builder: FunctionBuilder,
    signature: Signature,
) -> tuple[flat.Variable, syntax.Causality]:
    element = lookup.member(instance, name)
    assert element is not None
    definition, scope, mod = redeclare.effective_component(element)
    env = Env(scope, dict(names), builder)
    cls = lookup.find_class(scope, definition.type)
    type_, layout = variable_type(cls, env.session, definition.span)
    written = [(d, scope) for d in (*definition.dimensions, *definition.type_dimensions)]
    written += layout.dimensions
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
        own = env if binding.scope is scope else Env(binding.scope, dict(names), builder)
        value = expressions.type_expression(binding.expression, own)
    own_type = type_.with_dims((None,) * len(written))
    itself = flat.Reference(own_type, definition.span, name)
    dims, sizes = _dims(written, {**names, name: itself}, builder, value)
    type_ = type_.with_dims(dims + type_.dims)
    if value is not None:
        expect(type_, value, f"the value of `{name}`")
    if value is not None and definition.variability is syntax.Variability.CONSTANT:
        signature.constants[name] = value
    if (
        not is_input
        and causality is syntax.Causality.NONE
        and instance.layout.parts[0].definition.kind is syntax.ClassKind.FUNCTION
        and not (definition.prefixes.protected or element.protected)
        and definition.variability is not syntax.Variability.CONSTANT
    ):
        env.session.warn(
            "F296",
            f"the local variable `{name}` of the function `{instance.cls.name}` is public",
            definition.span,
            "declare it under `protected`",
        )
    return (
        flat.Variable(
            name,
            type_,
            flat.Variability.CONTINUOUS,
            definition.span,
            value,
            causality=causality.value,
            description=definition.comment,
            sizes=sizes,
        ),
        causality,
    )


def _dims(
    written: list[tuple[syntax.Expression, Scope]],
    names: dict[str, flat.Expression],
    builder: FunctionBuilder,
    value: flat.Expression | None,
) -> tuple[tuple[int | None, ...], tuple[flat.Expression | None, ...]]:
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
        typed = expressions.type_expression(expression, Env(scope, dict(names), builder))
        size = evaluate.try_value(typed, Env(scope, dict(names), builder), mark=True)
        dims.append(size if isinstance(size, int) else None)
        sizes.append(None if isinstance(size, int) else typed)
    if all(s is None for s in sizes):
        return tuple(dims), ()
    return tuple(dims), tuple(sizes)


def variable_type(cls: Class, session: Session, span: Span) -> tuple[flat.Type, Layout]:
    """The type of a variable of a function: built-in, record, or a function itself."""
    layout = inherit.layout_of(cls)
    if layout.builtin is not None:
        return layout.builtin, layout
    if layout.kind is syntax.ClassKind.RECORD:
        return constructors.record_type(cls, session), layout
    if layout.kind is syntax.ClassKind.FUNCTION:
        return _formal_type(cls, session), layout
    raise error(
        "F297", f"a variable of a function cannot be of the {layout.kind.value} `{cls.name}`", span
    )


def _formal_type(cls: Class, session: Session) -> flat.Type:
    """The type of an input that is a function: the interface that it declares."""
    if cls.name not in session.formals:
        signature = Signature(cls.name)
        variables = declare_variables(
            lookup.static_instance(cls), FunctionBuilder(signature), signature
        )
        signature.inputs = tuple(v for v, c in variables if c is syntax.Causality.INPUT)
        signature.outputs = tuple(v for v, c in variables if c is syntax.Causality.OUTPUT)
        session.formals[cls.name] = signature
    return flat.Type(flat.Base.FUNCTION, name=cls.name)


# Special functions -----------------------------------------------------------------------------


def _make_derivative(cls: Class, session: Session, span: Span) -> FunctionInfo:
    """`function f_s = der(f, s)`: the same inputs and outputs as `f` (12.7.2)."""
    derivative = inherit.layout_of(cls).derivative
    assert derivative is not None
    body, scope = derivative
    inner = function_of(lookup.find_class(scope, body.function), session, span)
    names = [v.name for v in inner.signature.inputs]
    for variable in body.variables:
        if variable not in names:
            raise error(
                "F290",
                f"`{body.function}` has no input `{variable}`",
                body.span,
                hint=lookup.suggestion(variable, names),
            )
    name = _unique_name(cls.name, session)
    signature = Signature(
        name,
        inner.signature.inputs,
        inner.signature.outputs,
        inner.signature.defaults,
        inner.signature.constants,
        inner.signature.captures,
        done=True,
    )
    session.signatures[name] = signature
    session.functions[name] = flat.Function(
        name,
        signature.inputs + tuple(_hidden_input(leaf) for leaf in signature.captures),
        signature.outputs,
        derivative_of=(inner.signature.name, body.variables),
        span=cls.span,
    )
    return FunctionInfo(name, signature, dict(inner.bound))


def _external(instance: Instance, signature: Signature) -> str | None:
    """The name of the built-in that an external function stands for."""
    for part in instance.layout.parts:
        body = part.definition.body
        if isinstance(body, syntax.ExtendsClass):
            body = body.composition
        external = body.external if isinstance(body, syntax.Composition) else None
        if external is None:
            continue
        name = external.function or part.definition.name
        known = name in compute.SCALAR
        if not known:
            language = external.language or "C"
            raise unsupported(f'the external "{language}" function `{name}`', "12.9", external.span)
        wanted = [v.name for v in signature.inputs]
        given = [a.parts[0].name for a in external.arguments if isinstance(a, syntax.Ref)]
        if given == wanted or not external.arguments:
            signature.builtin = name
        return name
    return None


def function_body(
    instance: Instance, names: dict[str, flat.Expression], builder: FunctionBuilder
) -> tuple[flat.Statement, ...]:
    """The statements of a function's one algorithm section (12.2)."""
    found: list[tuple[int, syntax.AlgorithmSection]] = []
    for index, part in enumerate(instance.layout.parts):
        body = part.definition.body
        if isinstance(body, syntax.ExtendsClass):
            body = body.composition
        if not isinstance(body, syntax.Composition):
            continue
        for section in body.sections:
            if isinstance(section, syntax.EquationSection):
                raise error("F298", "a function cannot have equations", section.span)
            found.append((index, section))
    if len(found) > 1:
        raise error(
            "F298",
            f"the function `{instance.cls.name}` has more than one algorithm section",
            found[0][1].span,
            related=[Related("the other one", found[1][1].span)],
            hint="extend a partial function, which has none",
        )
    if not found:
        return ()
    index, section = found[0]
    env = Env(instance.scope(index), dict(names), builder, in_algorithm=True)
    return statements.type_statements(section.statements, env, "")
