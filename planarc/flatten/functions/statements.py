"""Algorithms: statements typed, loops kept, targets checked.

In:   syntax.Statement, Env
Out:  flat.Statement

A loop stays a loop, with its iterator as a local Integer, unless its body indexes an
array of components, whose members have names of their own: then it is unrolled.

Reference: Modelica Language Specification 3.6, chapter 11.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from msgspec.structs import replace

from planarc.core.diagnostic import Once, PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.functions import calls
from planarc.flatten.refusal import UnknownValue, joined, unsupported
from planarc.flatten.terms.conform import conforms, mismatch, type_text
from planarc.flatten.terms.select import element_at, opened
from planarc.flatten.tree.demand import attributes_of
from planarc.flatten.tree.nodes import Env, Leaf
from planarc.flatten.typing import comprehension, references
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import is_clocked_sample, names_in

Statements = tuple[flat.Statement, ...]


def type_statements(statements: tuple[syntax.Statement, ...], env: Env) -> Statements:
    """The statements of an algorithm section or of a branch; all wrong ones are reported."""
    typed: list[flat.Statement] = []
    wrong: list[PlanarcError] = []
    for statement in statements:
        try:
            typed += _TYPERS[type(statement)](statement, env)
        except UnknownValue:
            raise  # a loop around it may be written out instead
        except PlanarcError as problem:
            wrong.append(problem)
    if wrong and env.function is not None:
        raise joined(wrong)  # a function that lacks statements cannot be called
    for one in wrong:
        env.session.keep(one)
    return tuple(typed)


def _assignment(node: syntax.Assignment, env: Env) -> Statements:
    value = env.typed(node.value)
    target = type_target(node.target, env)
    if not conforms(target.type, value.type):
        raise mismatch(target.type, value.type, f"the value of `{node.target}`", node.value.span)
    if isinstance(target, flat.Reference):
        return (flat.Assignment(node.span, env.component, target, value),)
    entries = _entries(node.span, target, value)
    names = {left.name for left, _ in entries}
    if len(entries) > 1 and names & names_in((value,)):
        return (flat.Assignment(node.span, env.component, _whole(target), value),)
    return tuple(flat.Assignment(node.span, env.component, *entry) for entry in entries)


Entries = list[tuple[flat.Reference, flat.Expression]]


def _whole(target: flat.Expression) -> flat.Target:
    """Variables that get their values at once, from a value that may hold them."""
    assert isinstance(target, flat.Reference | flat.Record | flat.Array)
    return target


def _entries(span: Span, target: flat.Expression, value: flat.Expression) -> Entries:
    """A record, or a slice over components, is assigned entry by entry."""
    found: Entries = []
    pairs: list[tuple[flat.Expression, flat.Expression]] = [(target, value)]
    while pairs:
        left, right = pairs.pop(0)
        if isinstance(left, flat.Reference):
            found.append((left, right))
        elif isinstance(left, flat.Array):
            indices = range(1, len(left.items) + 1)
            inner = [(left.items[i - 1], element_at(right, i)) for i in indices]
            pairs = inner + pairs
        elif isinstance(left, flat.Record):
            names = [n for n, _ in left.type.fields]
            fields = [references.field_of(right, n, span) for n in names]
            pairs = list(zip(left.items, fields, strict=True)) + pairs
        else:
            raise error("F301", "this cannot be assigned", left.span)
    return found


def type_target(ref: syntax.Ref, env: Env) -> flat.Expression:
    """The left side of an assignment: a variable, an entry or a field of one."""
    name = ref.parts[0].name
    if name in env.iterators and not ref.absolute:
        raise error("F301", f"the iterator `{name}` of a loop cannot be assigned", ref.span)
    target = env.typed(ref)
    if env.function is not None:
        if name not in env.locals:
            raise error("F301", f"a function cannot assign `{ref}`", ref.span)
        if any(v.name == name for v in env.function.inputs):
            message = f"the input `{name}` of a function cannot be assigned"
            hint = "declare another variable below `protected`, and assign that one"
            kind = f"{env.function.name} {name}"
            raise PlanarcError(Once("F301", message, ref.span, hint=hint, kind=kind))
        return _field_target(target, ref)
    if isinstance(target, flat.Reference):
        leaf = env.session.leaves.get(target.name)
        if leaf is not None and _is_fixed(leaf):
            kind = leaf.variability.name.lower()
            raise error("F301", f"the {kind} `{target.name}` cannot be assigned", ref.span)
        if leaf is not None and _is_own_input(leaf, env):
            raise error("F301", f"the input `{target.name}` cannot be assigned", ref.span)
    return target


def _is_own_input(leaf: Leaf, env: Env) -> bool:
    """An input of the component that the algorithm belongs to, maybe inside a connector."""
    owner = next((i for i in leaf.parent.outwards() if not i.is_connector), None)
    return leaf.causality is syntax.Causality.INPUT and owner is env.scope.instance


def _is_fixed(leaf: Leaf) -> bool:
    """A parameter, but for one that an initial algorithm finds (`fixed=false`)."""
    if leaf.variability is flat.Variability.PARAMETER:
        leaf.parent.session.asked.append(None)
        fixed = attributes_of(leaf).fixed
        return not (isinstance(fixed, flat.Literal) and fixed.value is False)
    return leaf.variability is flat.Variability.CONSTANT


def _field_target(target: flat.Expression, ref: syntax.Ref) -> flat.Expression:
    """The Reference `r.x[i]` for `r.x[i] := v` inside a function, and for `r[i].x := v` too,
    since subscripts belong to the dimensions in their order."""
    if isinstance(target, flat.Reference):
        return target
    names: list[str] = []
    subscripts: flat.Expressions = ()
    base: flat.Expression = target
    while isinstance(base, flat.Index | flat.Field):
        if isinstance(base, flat.Index):
            subscripts = (*base.subscripts, *subscripts)
        else:
            names.append(base.name)
        base = base.base
    if not isinstance(base, flat.Reference):
        raise unsupported("this target of an assignment", "11.2.1", ref.span)
    subscripts = (*base.subscripts, *subscripts)
    name = ".".join([base.name, *reversed(names)])
    return flat.Reference(target.type, ref.span, name, subscripts)


def _tuple(node: syntax.TupleAssignment, env: Env) -> Statements:
    call, types = calls.several_results(node.value, len(node.targets), node.span, env)
    targets: list[flat.Target | None] = []
    first: list[flat.Statement] = []
    arguments = names_in(call.arguments)
    for k, (target, type_) in enumerate(zip(node.targets, types, strict=False)):
        if target is None:
            targets.append(None)
            continue
        typed = type_target(target, env)
        if not conforms(typed.type, type_):
            raise mismatch(typed.type, type_, f"the result for `{target}`", target.span)
        result = flat.Call(type_, call.span, call.function, call.arguments, k)
        entries = _entries(node.span, typed, result)
        if isinstance(typed, flat.Reference) or arguments & {left.name for left, _ in entries}:
            targets.append(_whole(typed))
        else:
            targets.append(None)
            first += [flat.Assignment(node.span, env.component, *entry) for entry in entries]
    if not any(targets):
        return tuple(first)
    return (*first, flat.TupleAssignment(node.span, env.component, tuple(targets), call))


def _call(node: syntax.CallStatement, env: Env) -> Statements:
    names = node.call.function.names
    if names == ("assert",):
        return calls.type_assert(node.call, env)
    if names == ("terminate",):
        return calls.type_terminate(node.call, env)
    if names == ("reinit",):
        return calls.type_reinit(node.call, env)
    call = calls.type_call(node.call, env, results=True)
    if not isinstance(call, flat.Call):
        raise error("F293", f"the result of `{node.call.function}` is not used", node.span)
    return (flat.TupleAssignment(node.span, env.component, (), call),)


def _if(node: syntax.IfStatement, env: Env) -> Statements:
    branches: list[tuple[flat.Expression, Statements]] = []
    for expression, body in node.branches:
        condition = evaluate.condition_of(expression, env, "the condition of `if`")
        known = evaluate.literal_value(condition)
        if known is False:
            continue
        typed = type_statements(body, env)
        if known is True:
            if not branches:
                return typed
            return (flat.IfStatement(node.span, env.component, tuple(branches), typed),)
        branches.append((condition, typed))
    otherwise = type_statements(node.otherwise, env)
    if not branches:
        return otherwise
    return (flat.IfStatement(node.span, env.component, tuple(branches), otherwise),)


def _for(node: syntax.ForStatement, env: Env) -> Statements:
    if env.function is not None:
        return _loop(node.iterators, node, env)
    errors = len(env.session.errors)
    try:
        return _loop(node.iterators, node, env)
    except UnknownValue:
        del env.session.errors[errors:]
        return _unrolled(node, env)


def _loop(
    iterators: tuple[syntax.Iterator, ...], node: syntax.ForStatement, env: Env
) -> Statements:
    if not iterators:
        return type_statements(node.body, replace(env, in_loop=True))
    first = iterators[0]
    range_ = comprehension.iteration_range(first, env, node.body)
    local = flat.Reference(range_.type.element(), first.span, first.name)
    body = _loop(iterators[1:], node, env.with_iterator(first, local))
    return (flat.ForStatement(node.span, env.component, first.name, range_, body),)


def _unrolled(node: syntax.ForStatement, env: Env) -> Statements:
    turns = comprehension.turns(node, replace(env, in_loop=False))
    return tuple(s for turn in turns for s in type_statements(node.body, turn))


def _while(node: syntax.WhileStatement, env: Env) -> Statements:
    condition = evaluate.condition_of(node.condition, env, "the condition of `while`")
    body = type_statements(node.body, replace(env, in_loop=True))
    return (flat.WhileStatement(node.span, env.component, condition, body),)


def _when(node: syntax.WhenStatement, env: Env) -> Statements:
    if env.function is not None:
        raise error("F303", "a function cannot have a when-statement", node.span)
    if env.in_when:
        raise error("F307", "when-statements cannot be nested", node.span)
    inner = replace(env, in_when=True)
    branches = tuple(
        (when_condition(env.typed(condition), condition.span), type_statements(body, inner))
        for condition, body in node.branches
    )
    return (flat.WhenStatement(node.span, env.component, branches),)


def when_condition(typed: flat.Expression, span: Span) -> flat.Expression:
    """A Boolean or a vector of Booleans."""
    if typed.type.base is not flat.Base.BOOLEAN or len(typed.type.dims) > 1:
        message = f"the condition of `when` must be of type Boolean, but is {type_text(typed.type)}"
        hint = None
        if isinstance(typed, flat.Builtin) and is_clocked_sample(typed):
            hint = f"write `sample(0, {typed.arguments[0].span.text})` for an interval"
        raise error("F270", message, span, hint=hint)
    if typed.type.dims and not isinstance(typed, flat.Array) and None not in typed.type.dims:
        return flat.Array(typed.type, typed.span, tuple(opened(typed)))
    return typed


def _break(node: syntax.Break, env: Env) -> Statements:
    if not env.in_loop:
        message = "`break` is allowed in loops only, and not in one over an array of components"
        raise error("F303", message, node.span)
    return (flat.Break(node.span, env.component),)


def _return(node: syntax.Return, env: Env) -> Statements:
    if env.function is None:
        raise error("F303", "`return` is allowed in functions only", node.span)
    return (flat.Return(node.span, env.component),)


_TYPERS: dict[type, Callable[[Any, Env], Statements]] = {
    syntax.Assignment: _assignment,
    syntax.TupleAssignment: _tuple,
    syntax.CallStatement: _call,
    syntax.IfStatement: _if,
    syntax.ForStatement: _for,
    syntax.WhileStatement: _while,
    syntax.WhenStatement: _when,
    syntax.Break: _break,
    syntax.Return: _return,
}
