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

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.source import Span
from planarc.flatten.functions import foreign, statements
from planarc.flatten.functions.derivatives import check_inverses, derivatives_of
from planarc.flatten.functions.fields import first_values, without_overwritten
from planarc.flatten.functions.order import assigned_first
from planarc.flatten.functions.values import input_of
from planarc.flatten.functions.variables import declare_variables, interface
from planarc.flatten.refusal import unsupported
from planarc.flatten.tree import annotation, lookup
from planarc.flatten.tree.demand import function_of, layout_of, session_of, static_instance
from planarc.flatten.tree.modify import part_mod
from planarc.flatten.tree.naming import not_modifiable
from planarc.flatten.tree.nodes import (
    Binding,
    Class,
    Env,
    FunctionInfo,
    Instance,
    Leaf,
    Mod,
    Session,
    Signature,
)
from planarc.flatten.values import compute
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import expressions_of_model, functions_called

# Finding the function ----------------------------------------------------------------------------


def find_function(cls: Class, span: Span) -> FunctionInfo:
    """The information for calls of a function class; the function is made when first called."""
    session = session_of(cls)
    if cls.function is None:
        base, bound = _unwrap(cls)
        if base is not cls:
            inner = find_function(base, span)
            cls.function = FunctionInfo(cls.name, inner.signature, {**inner.bound, **bound})
        else:
            cls.function = _make(cls, session, span)
        annotation.warn_obsolete(cls, span, session)
    elif not cls.function.signature.done:
        cls.function.signature.called_early = True
    return cls.function


def _unwrap(cls: Class) -> tuple[Class, dict[str, Binding]]:
    """The function that a short class stands for, and the inputs it binds."""
    layout = layout_of(cls)
    index = 0
    while isinstance(layout.parts[index].definition.body, syntax.ShortClass):
        index += 1
    if index == 0:
        return cls, {}
    mod = part_mod(static_instance(cls), index)
    base = layout.parts[index].cls
    if not _binds_inputs_only(mod, layout_of(base).members, cls):
        return cls, {}
    bound = {name: sub.binding for name, sub in mod.subs.items() if sub.binding is not None}
    return base, bound


def _binds_inputs_only(
    mod: Mod, members: dict[str, tuple[int, syntax.Declaration]], cls: Class
) -> bool:
    for name, sub in mod.subs.items():
        if name not in members:
            raise not_modifiable(cls.name, name, sub.span, members)
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
    layout = layout_of(cls)
    if layout.derivative is not None:
        return _make_derivative(cls, session, span)
    signature = Signature(_unique_name(cls.name, session))
    session.signatures[signature.name] = signature
    cls.function = info = FunctionInfo(signature.name, signature, {})
    try:
        if cls.definition.partial:
            raise error("F295", f"the function `{cls.name}` is partial and cannot be called", span)
        _fill(cls, static_instance(cls), signature, session)
    except PlanarcError as problem:
        cls.function = None
        raise _at_call(problem, cls, session, span) from None
    if signature.called_early and signature.captures:
        raise unsupported("recursive functions that use variables of the model", "12.4", span)
    signature.done = True
    return info


def _at_call(problem: PlanarcError, cls: Class, session: Session, span: Span) -> PlanarcError:
    """What is wrong in a library's function, told where the user calls it."""
    own, first = session.own_files(), problem.diagnostics[0]
    places = [d.span for d in problem.diagnostics]
    if type(problem) is not PlanarcError or span.source.name not in own:
        return problem
    if any(place is None or place.source.name in own for place in places):
        return problem
    there = Related(f"this stands in `{cls.name}`", first.span, detail=True)
    return PlanarcError(replace(first, span=span, related=(*first.related, there)))


def _unique_name(name: str, session: Session) -> str:
    unique, count = name, 1
    while unique in session.signatures:
        count += 1
        unique = f"{name}#{count}"
    return unique


def _fill(cls: Class, instance: Instance, signature: Signature, session: Session) -> None:
    variables = declare_variables(instance, signature)
    signature.inputs = interface(instance, variables, syntax.Causality.INPUT)
    names: flat.Named = {v.name: flat.Reference(v.type, v.span, v.name) for v, _ in variables}
    written = [v for v, c in variables if c is not syntax.Causality.INPUT]
    outputs, locals_, first = assigned_first(
        interface(instance, variables, syntax.Causality.OUTPUT),
        [v for v, c in variables if c is syntax.Causality.NONE],
        [v.name for v, _ in variables],
        {v.name: first_values(instance, v, names, signature) for v in written},
    )
    signature.outputs = tuple(outputs)
    external = foreign.external_clause(instance)
    called = foreign.NOTHING
    body: tuple[flat.Statement, ...] = ()
    if external is None:
        body = without_overwritten(first, function_body(instance, names, signature), names)
        signature.builtin = _plain_builtin(body, signature)
    else:
        called = foreign.external_call(external, names, signature)
    check_inverses(instance, signature, session)
    hidden = tuple(_hidden_input(leaf) for leaf in signature.captures.values())
    session.functions[signature.name] = flat.Function(
        signature.name,
        signature.inputs + hidden,
        signature.outputs,
        tuple(locals_),
        body,
        called.name,
        given=called.given,
        results=called.results,
        derivatives=derivatives_of(instance, signature, session),
        span=cls.span,
    )


def _plain_builtin(body: tuple[flat.Statement, ...], signature: Signature) -> str | None:
    """A body that is nothing but `y := sin(u)`: the function stands for the built-in."""
    if len(body) != 1 or not isinstance(body[0], flat.Assignment):
        return None
    value = body[0].value
    if not isinstance(value, flat.Builtin) or not compute.scalar(value.function):
        return None
    names = [a.name for a in value.arguments if isinstance(a, flat.Reference) and not a.subscripts]
    same = names == [v.name for v in signature.inputs]
    return value.function if same and len(names) == len(value.arguments) else None


def _hidden_input(leaf: Leaf) -> flat.Variable:
    kind = flat.Variability.CONTINUOUS
    return flat.Variable(leaf.name, leaf.type, kind, leaf.span, causality="input")


# Special functions -----------------------------------------------------------------------------


def _make_derivative(cls: Class, session: Session, span: Span) -> FunctionInfo:
    """`function f_s = der(f, s)`: the same inputs and outputs as `f` (12.7.2)."""
    derivative = layout_of(cls).derivative
    assert derivative is not None
    body, scope = derivative
    inner = function_of(lookup.find_class(scope, body.function), span)
    inputs = {v.name: v for v in inner.signature.inputs}
    for name in body.variables:
        input_of(inputs, name, body.function, body.span)
    name = _unique_name(cls.name, session)
    signature = replace(inner.signature, name=name, builtin=None, called_early=False, done=True)
    session.signatures[name] = signature
    session.functions[name] = flat.Function(
        name,
        signature.inputs + tuple(_hidden_input(leaf) for leaf in signature.captures.values()),
        signature.outputs,
        derivative_of=(inner.signature.name, body.variables),
        span=cls.span,
    )
    return FunctionInfo(name, signature, dict(inner.bound))


def function_body(
    instance: Instance, names: flat.Named, signature: Signature
) -> tuple[flat.Statement, ...]:
    """The statements of a function's one algorithm section (12.2)."""
    found: list[tuple[int, syntax.AlgorithmSection]] = []
    for index, part in enumerate(instance.layout.parts):
        for section in part.definition.sections:
            if isinstance(section, syntax.EquationSection):
                hint = "write `algorithm` for `equation`, and `:=` for the `=` of its statements"
                message = "a function cannot have equations"
                raise error("F298", message, section.span, hint=hint)
            if section.initial:
                message = "a function cannot have an initial algorithm"
                raise error("F298", message, section.span)
            found.append((index, section))
    if len(found) > 1:
        message = f"the function `{instance.cls.name}` has more than one algorithm section"
        hint = "extend a partial function, which has none"
        related = [Related("the other one", found[1][1].span)]
        raise error("F298", message, found[0][1].span, related=related, hint=hint)
    if not found:
        return ()
    index, section = found[0]
    env = Env(instance.scope(index), names, signature, in_algorithm=True)
    return statements.type_statements(section.statements, env)


# What a model calls -------------------------------------------------------------------


def with_functions(
    model: flat.FlatModel, session: Session, distinct: flat.FlatModel
) -> flat.FlatModel:
    """The model with the functions that it calls, directly or through others, in the order in
    which they were made: not those that were only run while compiling. A `distinct` part of the
    model calls all of them."""
    wanted = functions_called(expressions_of_model(distinct), session.functions)
    called = [f for name, f in session.functions.items() if name in wanted]
    return replace(model, functions=(*_interfaces(called, session), *called))


def _interfaces(functions: list[flat.Function], session: Session) -> list[flat.Function]:
    """The partial functions that are the types of inputs."""
    types = (v.type for f in functions for v in f.inputs)
    names = dict.fromkeys(t.name for t in types if t.base is flat.Base.FUNCTION)
    return [
        flat.Function(name, formal.inputs, formal.outputs, partial=True)
        for name, formal in session.formals.items()
        if name in names
    ]
