"""Equations of the flat model as scalar equations, when-clauses as events.

In:   flat.Equation     array equations, if- and when-equations
Out:  dae.Equation ...  scalar ones, gathered in `Lowered`

Example:

    frame_a.f + frame_b.f = zeros(2)   ->   frame_a.f[1] + frame_b.f[1] = 0
                                            frame_a.f[2] + frame_b.f[2] = 0
    when h < 0 then reinit(v, -e*v)    ->   discrete  $when[1] = event[0]
                                            when $when[1]: reinit(v, -e*v)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Severity, error
from planarc.core.prose import sized
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr, Op, symbols
from planarc.lower.scalar import assertion, lower_expression, message, ways
from planarc.lower.scope import Model, Scope, outside_of_when
from planarc.lower.texts import number_held
from planarc.lower.values import RecordValue, Value, expr, exprs
from planarc.runtime.tensor import Tensor, elements, shape_of

Pair = tuple[Expr, Expr]


class Lowered(Struct):
    """The scalar equations, by what they are."""

    equations: list[dae.Equation] = field(default_factory=list)
    whens: list[dae.When] = field(default_factory=list)

    def parted(
        self, model: Model, clocked: frozenset[str] = frozenset()
    ) -> tuple[list[dae.Equation], list[dae.Equation]]:
        """The equations of continuous unknowns, and those of discrete ones. What is `clocked` has
        its value from equations with a clock."""
        held = dae.set_by_whens(self.whens) | clocked
        continuous: list[dae.Equation] = []
        discrete: list[dae.Equation] = []
        for e in self.equations:
            own = frozenset[str]() if e.assigned else held
            ticks = e.clock is not None
            (discrete if ticks or _is_discrete(model, own, e) else continuous).append(e)
        return continuous, discrete


def lower_equations(model: Model, equations: Sequence[flat.Equation], into: Lowered) -> None:
    """Append the scalar equations of a model to `into`."""
    scope = Scope(model)
    for e in equations:
        model.component = e.component
        match e:
            case flat.Equality() | flat.IfEquation():
                for left, right in scalar_pairs(scope, e):
                    add_equation(into, left, right, e)
            case flat.WhenEquation():
                into.whens.append(when(scope, e, partial(_actions, replace(scope, at_event=True))))
            case flat.Assert():
                model.assertions.append(assertion(scope.without_events(), e))
            case flat.Terminate() | flat.Reinit():
                raise outside_of_when(e.span)


def add_equation(into: Lowered, left: Expr, right: Expr, origin: flat.EquationNode) -> None:
    generated = isinstance(origin, flat.Equality) and origin.generated
    assigned = isinstance(origin, flat.Algorithm)
    into.equations.append(
        dae.Equation(left, right, origin.span, origin.component, generated, assigned)
    )


def _is_discrete(model: Model, held: frozenset[str], e: dae.Equation) -> bool:
    if not model.discretes:
        return False
    if model.is_steady(e.left) and model.is_steady(e.right):
        named = (s.name for s in symbols(e.left, e.right))
        if not model.discretes.isdisjoint(named):
            return True
    sides = ((e.left, e.right), (e.right, e.left))
    return any(_sets_discrete(model, held, target, value) for target, value in sides)


def _sets_discrete(model: Model, held: frozenset[str], target: Expr, value: Expr) -> bool:
    """True when `target = value` gives a discrete variable its value. Variables that are
    `held` have theirs from elsewhere: the equation may give another one its value."""
    if target.op is not Op.SYMBOL or target.name not in model.discretes:
        return False
    return value.op is not Op.SYMBOL and target.name not in held


def lower_initial(model: Model, equations: Sequence[flat.Equation]) -> list[dae.Equation]:
    """Initial equations: no relation in them makes an event."""
    scope = Scope(model, events=False, at_event=True)
    result = []
    count = len(model.assertions)
    for e in equations:
        model.component = e.component
        if isinstance(e, flat.Assert):
            model.assertions.append(assertion(scope.without_events(), e))
            continue
        if not isinstance(e, flat.Equality | flat.IfEquation):
            raise error("L341", "this stands in no initial equation", e.span)
        for left, right in scalar_pairs(scope, e):
            result.append(dae.Equation(left, right, e.span, e.component))
    model.forget_bounds(count)  # the values at the start are not those that rows hold
    return result


# Equalities -------------------------------------------------------------------------------


def scalar_pairs(scope: Scope, e: flat.Equation) -> list[Pair]:
    """The scalar equations of an equality or of an if-equation."""
    if isinstance(e, flat.Equality):
        return list(_equality(scope, e))
    if isinstance(e, flat.IfEquation):
        return _joined(scope, e)
    hint = "write it outside, with what the `if` asks in its own condition"
    message = "this equation cannot stand inside of an if-equation"
    raise error("L342", message, e.span, hint=hint if isinstance(e, flat.WhenEquation) else None)


def _equality(scope: Scope, e: flat.Equality) -> Iterator[Pair]:
    if isinstance(e.left, flat.Targets):
        assert isinstance(e.right, flat.Call)
        given = tuple(lower_expression(scope, a) for a in e.right.arguments)
        results = scope.model.inline(scope, e.right.function, given, e.span)
        for target, value in zip(e.left.items, results, strict=False):
            if target is not None:
                yield from _matched(scope, lower_expression(scope, target), value, e.span)
        return
    left, right = lower_expression(scope, e.left), lower_expression(scope, e.right)
    yield from _matched(scope, left, right, e.span)


def _matched(scope: Scope, left: Value, right: Value, span: Span) -> Iterator[Pair]:
    """left = right, entry by entry, field by field."""
    if isinstance(left, RecordValue) and isinstance(right, RecordValue):
        for name, value in left.fields:
            yield from _matched(scope, value, right.field(name), span)
        return
    if shape_of(left) != shape_of(right):
        sizes = sized([shape_of(left), shape_of(right)])
        raise error("L344", f"the sides of the equation have {sizes}", span)
    for a, b in zip(elements(left), elements(right), strict=True):
        if isinstance(a, RecordValue):
            yield from _matched(scope, a, b, span)
        else:
            yield number_held(scope, a, span), number_held(scope, b, span)


def _joined(scope: Scope, e: flat.IfEquation) -> list[Pair]:
    """Branch by branch: `if c then a = b; else a = d; end if` is `a = if c then b else d`."""
    for condition, body in e.branches:
        for action in body:
            if isinstance(action, flat.Terminate | flat.Reinit):
                when = f"when {condition.span.text or 'condition'} then"
                raise outside_of_when(action.span, when, " in the place of the `if`")
    truths = [expr(lower_expression(scope, condition)) for condition, _ in e.branches]
    reached = ways(scope, truths)
    result = _section(reached[-1], e.otherwise)
    for k in reversed(range(len(truths))):
        branch = _section(reached[k].where(truths[k]), e.branches[k][1])
        if len(branch) != len(result):
            message = f"the branches hold {len(branch)} and {len(result)} equations"
            hint = "give every branch as many equations, or make the condition a parameter"
            raise error("L345", message, e.span, hint=hint)
        pairs = zip(_in_order(branch, result), result, strict=True)
        result = [_join(scope, truths[k], a, b) for a, b in pairs]
    return result


def _in_order(branch: list[Pair], others: Sequence[Pair]) -> list[Pair]:
    """The equations of a branch as those of the others stand, where each gives one variable:
    `if c then a = 1; b = 2; else b = 0; a = 0; end if`."""
    own = {left: (left, right) for left, right in branch if left.is_symbol}
    if len(own) < len(branch) or own.keys() != {left for left, _ in others}:
        return branch
    return [own[left] for left, _ in others]


def _section(scope: Scope, body: Sequence[flat.Equation]) -> list[Pair]:
    pairs: list[Pair] = []
    for e in body:
        if isinstance(e, flat.Assert):
            scope.model.assertions.append(assertion(scope.without_events(), e))
        else:
            pairs.extend(scalar_pairs(scope, e))
    return pairs


def _join(scope: Scope, truth: Expr, then: Pair, otherwise: Pair) -> Pair:
    t = scope.table
    if then[0] is otherwise[0]:
        return then[0], t.if_(truth, then[1], otherwise[1])
    return t.if_(truth, t.sub(*then), t.sub(*otherwise)), t.zero


# When-clauses ------------------------------------------------------------------------------


def when(
    scope: Scope,
    clause: flat.WhenEquation | flat.WhenStatement,
    actions_of: Callable[[Any], Iterator[dae.Action]],
) -> dae.When:
    """The branches of a when-clause, with the actions of their bodies."""
    model, branches = scope.model, []
    for condition, body in clause.branches:
        name = trigger(scope, condition, clause)
        count = len(model.assertions)
        actions = tuple(actions_of(body))
        branches.append((name, (*actions, *model.take_assertions(count))))
    return dae.When(tuple(branches), clause.span, clause.component)


def trigger(scope: Scope, condition: flat.Expression, origin: flat.EquationNode) -> str:
    """The name of a new Boolean that becomes true when a when-branch is to act."""
    t = scope.table
    value = lower_expression(scope, condition)
    truths = [named_truth(scope.model, e, origin) for e in exprs(value)]
    if not isinstance(value, Tensor):
        return truths[0].name
    truth = t.false
    for one in truths:  # any one that just became true (8.3.5)
        truth = t.or_(truth, t.and_(one, t.not_(t.pre(one.name))))
    return named_truth(scope.model, truth, origin, dae.EDGE).name


def fires(model: Model, name: str) -> Expr:
    """The truth, at an event, that the when-branch of that trigger acts."""
    t = model.table
    just = t.symbol(name)
    if not name.startswith(dae.EDGE):
        just = t.and_(just, t.not_(t.pre(name)))
    if acts_at_start(model, name):
        return just
    return t.and_(just, t.not_(t.symbol(dae.INITIAL)))


def acts_at_start(model: Model, name: str) -> bool:
    """Whether the when-branch of that trigger acts at the start: where `initial()` stands as its
    condition or among several ones. No other one does, whatever its condition is (8.6)."""
    truths = {v.name: e.right for v, e in model.auxiliaries}
    several = name.startswith(dae.EDGE)
    asked = [s.name for s in symbols(truths[name])] if several else [name]
    return any(one.startswith(dae.WHEN) and dae.is_initial(truths[one]) for one in asked)


def set_at_start(model: Model, e: dae.Equation) -> dae.When:
    """A when-clause of `initial()` that sets the discrete variable on the left."""
    return at_start_only(model, e, set_discrete(e.left, e.right, e.span))


def at_start_only(model: Model, e: dae.Equation, action: dae.Action) -> dae.When:
    """A when-clause of `initial()` for an initial equation."""
    name = named_truth(model, model.table.symbol(dae.INITIAL), e).name
    return dae.When(((name, (action,)),), e.span, e.component)


def named_truth(
    model: Model, truth: Expr, origin: flat.EquationNode | dae.Equation, kind: str = dae.WHEN
) -> Expr:
    """A discrete variable with that value, `pre` of which is known."""
    if truth.op is Op.SYMBOL and truth.name in model.discretes:
        return truth
    name = f"{kind}[{len(model.auxiliaries) + 1}]"
    symbol = model.table.symbol(name)
    variable = dae.Variable(name, dae.Kind.BOOLEAN, protected=True, span=origin.span)
    equation = dae.Equation(symbol, truth, origin.span, origin.component)
    model.discretes.add(name)
    model.auxiliaries.append((variable, equation))
    return symbol


def _actions(scope: Scope, body: Sequence[flat.Equation]) -> Iterator[dae.Action]:
    for e in body:
        match e:
            case flat.Equality():
                for left, right in _equality(scope, e):
                    _doubt_itself(scope, left, right, e.span)
                    yield set_discrete(left, right, e.span)
            case flat.Reinit():
                yield from reinit(scope, e)
            case flat.Assert():
                yield assertion(scope.without_events(), e)
            case flat.Terminate():
                yield dae.Terminate(message(scope.without_events(), e.message), e.span)
            case flat.Impact():
                told = scope.without_events()
                arguments = tuple(expr(lower_expression(told, a)) for a in e.arguments)
                yield dae.Impact(arguments, e.component, e.span, e.crowd)
            case flat.IfEquation():
                yield from _conditional(scope, e)
            case _:
                raise error("L346", "a when-clause cannot stand inside of another one", e.span)


def _doubt_itself(scope: Scope, left: Expr, right: Expr, span: Span) -> None:
    """Refuse `n = n + 1`, which is meant as the next value and asks for one that there is not; warn
    of `n = n/2 + 1`, which may be meant so."""
    if left.is_symbol and left in symbols(right):
        message = f"`{left}` is given a value by itself: `{span.text}` is an equation"
        hint = f"write `pre({left})` on the right for the value before the event"
        if left not in symbols(scope.model.table.sub(right, left)):
            raise error("L317", message, span, hint=hint)
        found = Diagnostic("L317", message, span, Severity.WARNING, hint=hint)
        scope.model.warnings.append(found)


def set_discrete(left: Expr, right: Expr, span: Span) -> dae.SetDiscrete:
    if left.op is not Op.SYMBOL:
        raise error("L347", "a when-equation must have a variable on its left side", span)
    return dae.SetDiscrete(left.name, right, span)


def reinit(scope: Scope, e: flat.Reinit) -> Iterator[dae.Reinit]:
    targets = exprs(lower_expression(scope, e.variable))
    values = exprs(lower_expression(scope, e.value))
    for target, value in zip(targets, values, strict=True):
        if target.op is not Op.SYMBOL:
            raise error("L348", "`reinit` needs a variable", e.span)
        yield dae.Reinit(target, value, e.span)


def _conditional(scope: Scope, e: flat.IfEquation) -> Iterator[dae.Action]:
    """An if inside of a when: each action keeps the old value where its condition is false."""
    t = scope.table
    earlier = t.false
    branches = [*e.branches, (None, e.otherwise)]
    chosen: dict[tuple[type, Expr], dae.SetDiscrete | dae.Reinit] = {}
    for condition, body in branches:
        own = t.true if condition is None else expr(lower_expression(scope, condition))
        truth = t.and_(own, t.not_(earlier))
        for action in _actions(scope.where(truth), body):
            match action:
                case dae.SetDiscrete() | dae.Reinit():
                    old = (
                        t.pre(action.name) if isinstance(action, dae.SetDiscrete) else action.symbol
                    )
                    key = type(action), old
                    kept = chosen[key].value if key in chosen else old
                    chosen[key] = replace(action, value=t.if_(truth, action.value, kept))
                case dae.Assertion():
                    yield action
                case dae.Terminate() | dae.Impact():
                    message = (
                        "`terminate`, `impact` and `crowd` under an `if` inside of a when-clause"
                    )
                    hint = "put the condition into the `when`"
                    raise error("L349", message, action.span, hint=hint)
        earlier = t.or_(earlier, own)
    yield from chosen.values()
