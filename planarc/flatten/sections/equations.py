"""Equations of one class: typed, loops unrolled, structural choices made.

In:   syntax.Equation, Env
Out:  flat.Equation (connections are left to `joining`)

Example: with `parameter Integer n = 2;`

    for i in 1:n loop  x[i] = i;  end for;      becomes   x[1] = 1;  x[2] = 2;
    if fixed then phi = 0; else tau = 0; end if becomes one of both, when `fixed` is
    a parameter; with a condition that changes in time it stays an IfEquation.

Reference: Modelica Language Specification 3.6, chapter 8.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.prose import counted, listed
from planarc.flatten.connect.joining import all_branches, holds_connection, is_connection_operator
from planarc.flatten.functions.calls import (
    is_builtin,
    several_results,
    type_assert,
    type_call,
    type_impact,
    type_reinit,
    type_terminate,
)
from planarc.flatten.functions.statements import when_condition
from planarc.flatten.refusal import for_each, too_large
from planarc.flatten.sections.whens import check_branches
from planarc.flatten.terms.conform import (
    NUMERIC,
    base_conforms,
    expect,
    literals_hint,
    product_hint,
    scalar_count,
    shape_hint,
    type_text,
    unify,
)
from planarc.flatten.tree.nodes import Env, Instance
from planarc.flatten.typing.clocks import expect_alone, is_clock
from planarc.flatten.typing.comprehension import turns
from planarc.flatten.typing.references import resolve
from planarc.flatten.values import evaluate
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import variables_of_target

MAX_TURNS = 200_000  # of one for-equation, all its iterators together

Equations = tuple[flat.Equation, ...]


def type_equations(equations: tuple[syntax.Equation, ...], env: Env) -> list[flat.Equation]:
    """The equations of a section; a wrong one is reported and left out."""
    typed: list[flat.Equation] = []
    for equation in equations:
        try:
            typed += _TYPERS[type(equation)](equation, env)
        except PlanarcError as problem:
            env.session.keep(problem)
    return typed


def _equality(node: syntax.Equality, env: Env) -> Equations:
    if isinstance(node.left, syntax.Tuple) and isinstance(node.right, syntax.Call):
        return _several_results(node, node.left, node.right, env)
    try:
        left, right = for_each((node.left, node.right), env.typed)
    except PlanarcError:
        _refuse_connectors(node, env)
        raise
    if unify(left.type, right.type) is None:
        types = f"{type_text(left.type)} and {type_text(right.type)}"
        hint = _mend(node, left, right)
        message = f"the sides of the equation have different types: {types}"
        raise error("F300", message, node.span, hint=hint)
    whole = isinstance(left, flat.Reference) and left.type.base is flat.Base.INTEGER
    if whole and not isinstance(right, flat.Reference):  # `i = x` may say what x is
        expect(left.type, right, f"the value of `{node.left}`")
    return (flat.Equality(node.span, env.component, left, right),)


def _mend(node: syntax.Equality, left: flat.Expression, right: flat.Expression) -> str | None:
    """What to do about sides of different types."""
    if not left.type.dims and right.type.dims == (1,):
        return f"a vector of one entry is no number: write `scalar({node.right.span.text})`"
    for one, other in ((left, right), (right, left)):
        if one.type.literals and other.type.base in NUMERIC:
            return literals_hint(one.type)
    if (product := product_hint(right if left.type.dims else left)) is not None:
        return product
    if isinstance(node.left, syntax.Matrix) and isinstance(right, flat.Call):
        results = node.left.span.text.strip("[] ")
        return f"the results of a call stand in parentheses: write `({results})`"
    if not (base_conforms(left.type, right.type) or base_conforms(right.type, left.type)):
        return None
    for written, other in ((right, left), (left, right)):
        computed = written is right and not isinstance(right, flat.Reference)
        if isinstance(written, flat.Array | flat.Literal) or (computed and not right.type.dims):
            return shape_hint(other.type, written.type, written.span)
    return None


def _refuse_connectors(node: syntax.Equality, env: Env) -> None:
    """Explain `pin.frame_b = bar.frame_a`."""
    left, right = node.left, node.right
    if not (isinstance(left, syntax.Ref) and isinstance(right, syntax.Ref)):
        return
    views = [resolve(ref, env.picking()) for ref in (left, right)]
    if all(isinstance(v, Instance) and v.is_connector for v in views):
        message = f"`{left}` and `{right}` are connectors, which no equation joins"
        raise error("F216", message, node.span, hint=f"write `connect({left}, {right});`")


def _several_results(
    node: syntax.Equality, left: syntax.Tuple, right: syntax.Call, env: Env
) -> Equations:
    """`(a, , b) = f(x)`."""
    call, types = several_results(right, len(left.items), node.span, env)
    items: list[flat.Expression | None] = []
    for item, type_ in zip(left.items, types, strict=False):
        typed = None if item is None else env.typed(item)
        if typed is not None and unify(typed.type, type_) is None:
            what = f"a result of `{right.function}` is {type_text(type_)}"
            raise error("F300", f"{what}, but is equated to {type_text(typed.type)}", typed.span)
        items.append(typed)
    return (flat.Equality(node.span, env.component, flat.Targets(tuple(items)), call),)


def _if(node: syntax.IfEquation, env: Env) -> Equations:
    errors = len(env.session.errors)
    branches: list[tuple[flat.Expression, Equations]] = []
    for number, (expression, body) in enumerate(node.branches):
        condition = evaluate.condition_of(expression, env, "the condition of `if`")
        known = _structural_condition(condition, node, env)
        if known is False:
            continue
        typed = tuple(type_equations(body, env))
        if known is True:
            env.session.chosen.append((node, number, env))
            return _if_of(node, branches, typed, env)
        branches.append((condition, typed))
    otherwise = tuple(type_equations(node.otherwise, env))
    if not branches:
        env.session.chosen.append((node, len(node.branches), env))
    if len(env.session.errors) > errors:
        return ()  # counts would be wrong because of what is missing
    return _if_of(node, branches, otherwise, env)


def _gives_clock(equation: flat.Equation) -> bool:
    left = equation.left if isinstance(equation, flat.Equality) else None
    return left is not None and not isinstance(left, flat.Targets) and is_clock(left.type)


def _jump(
    branches: Sequence[tuple[flat.Expression, Equations]], otherwise: Equations
) -> str | None:
    """What to write where an `if` sets a variable by itself, as `v = -0.8*v`: that is a jump."""
    (condition, body), *others = branches
    if others or otherwise or len(body) != 1:
        return None
    equation = body[0]
    if not isinstance(equation, flat.Equality) or not isinstance(equation.left, flat.Reference):
        return None
    name, value = equation.left.span.text, equation.right.span.text
    if not name or not re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", value):
        return None
    return (
        f"`if` says what holds all the while: for a jump of `{name}` write "
        f"`when {condition.span.text} then reinit({name}, {value}); end when;`"
    )


def _given_parameter(branches: list[tuple[flat.Expression, Equations]], env: Env) -> str | None:
    """The first parameter that an equation of a branch is to give a value."""
    lefts = (e.left for _, body in branches for e in body if isinstance(e, flat.Equality))
    for left in (e for e in lefts if isinstance(e, flat.Reference)):
        if variability_of(left, env.session, env.hidden) is flat.Variability.PARAMETER:
            return left.name
    return None


def _if_of(
    node: syntax.IfEquation,
    branches: list[tuple[flat.Expression, Equations]],
    otherwise: Equations,
    env: Env,
) -> Equations:
    if not branches:
        return otherwise
    if any(_gives_clock(e) for _, body in branches for e in body):
        what = "the condition of an `if` between clocks"
        evaluate.structural_value(branches[0][0], env, what)
    if not env.in_when:
        counts = [count_equations(body) for body in (*(b for _, b in branches), otherwise)]
        if len({*counts}) > 1:
            numbers = listed(map(str, counts))
            message = f"the branches of `if` have different numbers of equations: {numbers}"
            hint = _jump(branches, otherwise) or "give all branches, `else` too, as many equations"
            if not node.otherwise:
                numbers = counted(max(counts), "equation")
                message = f"this `if` without `else` makes {numbers} while its condition holds, "
                message += "and none while it does not"
                hint = _jump(branches, otherwise) or "say in an `else` what holds otherwise"
            if (fixed := _given_parameter(branches, env)) is not None:
                hint = f"`{fixed}` is a parameter, which never changes: declare it without "
                hint += "`parameter`, and say what it is in all branches"
            if branches[0][0].span.text.replace(" ", "") == "initial()":
                hint = "write what holds at the start only in a section `initial equation`"
            raise error("F305", message, node.span, hint=hint)
    return (flat.IfEquation(node.span, env.component, tuple(branches), otherwise),)


def _structural_condition(
    condition: flat.Expression, node: syntax.IfEquation, env: Env
) -> bool | None:
    """The value of a condition of parameters; None when it changes while running."""
    if variability_of(condition, env.session, env.hidden) > flat.Variability.PARAMETER:
        return None
    if env.in_when and (node.otherwise or not _holds_equality(node)):
        known = evaluate.literal_value(condition)
        return None if known is None else bool(known)
    if holds_connection(all_branches(node)):
        return bool(evaluate.structural_value(condition, env, "the condition of `if`"))
    value = evaluate.try_value(condition, env, mark=True)
    return None if value is None else bool(value)


def _holds_equality(node: syntax.IfEquation) -> bool:
    return any(isinstance(e, syntax.Equality) for e in all_branches(node))


def count_equations(equations: Equations) -> int:
    """The number of scalar equations."""
    count = 0
    for equation in equations:
        if isinstance(equation, flat.Equality):
            count += _equality_count(equation)
        elif isinstance(equation, flat.IfEquation):
            count += count_equations(equation.otherwise)
        elif isinstance(equation, flat.WhenEquation):
            condition, body = equation.branches[0]
            clocked = is_clock(condition.type)
            count += count_equations(body) if clocked else _set_at_events(equation).total()
    return count


def _set_at_events(when: flat.WhenEquation) -> Counter[str]:
    """The scalars of each variable that some branch gives a value: a branch that leaves it out
    keeps it."""
    found = Counter[str]()
    for _, body in when.branches:
        found |= _given_in(body)
    return found


def _given_in(body: Equations) -> Counter[str]:
    """The scalars of each variable that one branch gives a value; others have no name."""
    found = Counter[str]()
    for equation in body:
        if isinstance(equation, flat.IfEquation):
            own = Counter[str]()
            for inner in (*(b for _, b in equation.branches), equation.otherwise):
                own |= _given_in(inner)
            found += own
        elif isinstance(equation, flat.Equality):
            left = equation.left
            targets = left.items if isinstance(left, flat.Targets) else (left,)
            own = Counter[str]()
            for target in targets:
                for variable in () if target is None else variables_of_target(target):
                    own[variable.name] += scalar_count(variable.type)
            own[""] = _equality_count(equation) - own.total()
            found += own
    return found


def _equality_count(equation: flat.Equality) -> int:
    if isinstance(equation.left, flat.Targets):
        return sum(scalar_count(i.type) for i in equation.left.items if i is not None)
    return scalar_count(equation.left.type)


def _for(node: syntax.ForEquation, env: Env) -> Equations:
    found: list[flat.Equation] = []
    errors = len(env.session.errors)
    for count, turn in enumerate(turns(node, env), start=1):
        if count > MAX_TURNS:
            raise too_large(f"a loop of more than {MAX_TURNS:,} turns is too long", node.span)
        found += type_equations(node.body, turn)
        if len(env.session.errors) > errors:
            break  # the same error would be found in each turn
    return tuple(found)


def _when(node: syntax.WhenEquation, env: Env) -> Equations:
    if env.in_when or env.at_tick:
        raise error("F307", "when-equations cannot be nested", node.span)
    (first, body), *others = node.branches
    condition = env.typed(first)
    if is_clock(condition.type):  # at its ticks, equations of any form hold (16.6)
        expect_alone(condition, len(node.branches))
        held = tuple(type_equations(body, replace(env, at_tick=True)))
        return (flat.WhenEquation(node.span, env.component, ((condition, held),)),)
    inner = replace(env, in_when=True)
    branches = (
        (when_condition(condition, first.span), tuple(type_equations(body, inner))),
        *(
            (when_condition(env.typed(c), c.span), tuple(type_equations(own, inner)))
            for c, own in others
        ),
    )
    check_branches(branches, env)
    return (flat.WhenEquation(node.span, env.component, branches),)


def _connect(node: syntax.Connect, env: Env) -> Equations:
    """Connections were collected before (`joining`)."""
    if env.in_when or env.at_tick:
        raise error("F306", "`connect` cannot stand in a when-equation", node.span)
    return ()


def _call(node: syntax.CallEquation, env: Env) -> Equations:
    call = node.call
    names = call.function.names
    if names == ("assert",):
        return type_assert(call, env)
    if names == ("terminate",):
        return type_terminate(call, env)
    if names == ("reinit",):
        if env.at_tick:
            message = "`reinit` acts at events, and this is a tick of a clock"
            hint = "write `when sample(0, ...) then`, or let the state itself tick"
            raise error("F304", message, node.span, hint=hint)
        if not env.in_when:
            hint = "write `when ... then` around it: it acts at the instant when that becomes true"
            before = node.span.source.text[: node.span.start]
            if found := re.search(r"\bif\s+([^;]*?)\s+then\s*$", before):
                hint = f"write `when {' '.join(found[1].split())} then` in the place of the `if`: "
                hint += "it acts at the instant when that becomes true"
            raise error("F304", "`reinit` may stand in a when-equation only", node.span, hint=hint)
        return type_reinit(call, env)
    if names in (("impact",), ("crowd",)) and is_builtin(call.function, env):
        if not env.in_when:
            raise error("F304", f"`{names[0]}` may stand in a when-equation only", node.span)
        return type_impact(call, env)
    if is_connection_operator(call):
        if env.in_when:
            raise error("F306", f"`{call.function}` cannot stand in a when-equation", node.span)
        return ()  # collected before (`joining`)
    typed = type_call(call, env, results=True)
    if isinstance(typed, flat.Call):
        return (flat.Equality(node.span, env.component, flat.Targets(()), typed),)
    raise error("F293", f"`{call.function}` is no equation: nothing uses its result", node.span)


_TYPERS: dict[type, Callable[[Any, Env], Equations]] = {
    syntax.Equality: _equality,
    syntax.IfEquation: _if,
    syntax.ForEquation: _for,
    syntax.WhenEquation: _when,
    syntax.Connect: _connect,
    syntax.CallEquation: _call,
}
