"""Expressions of the flat model as scalar expressions, arrays entry by entry.

In:   flat.Expression   typed, with arrays, records and function calls
Out:  Value             scalars of the shared table; arrays as `Tensor`s of them

Example: with `r` of two entries,

    frame_a.r + R*{L, 0}     ->  {frame_a.r[1] + R[1,1]*L, frame_a.r[2] + R[2,1]*L}

Calls are replaced by what their functions give (`functions`); relations that can switch
while running become stored truth values (`operators.relation`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate
from typing import Any

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Severity, error
from planarc.core.prose import listed
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.ir.flatwalk import CONVERSIONS, OUTWARDS, is_clocked_sample
from planarc.lower import builtins, texts
from planarc.lower.operators import binary
from planarc.lower.scope import OutsideArray, Scope, UnknownCourse, outside_array
from planarc.lower.values import FunctionValue, RecordValue, Text, Value, expect_size, expr, stacked
from planarc.runtime.tensor import Tensor, each, elements, shape_of, stack

#: Entries of one range.
MAX_ENTRIES = 1_000_000


def lower_expression(scope: Scope, e: flat.Expression) -> Value:
    """The value of an expression in a scope. Raises PlanarcError."""
    return _RULES[type(e)](scope, e)


def _literal(scope: Scope, e: flat.Literal) -> Value:
    if isinstance(e.value, str):
        return Text((e.value,))
    if type(e.value) is int and abs(e.value) > dae.LARGEST_INTEGER:
        message = f"the Integer {e.value} is too large: beyond 2^53 not all are told apart"
        raise error("L318", message, e.span, hint="write a Real, with a decimal point")
    return scope.table.const(e.value)


def _reference(scope: Scope, e: flat.Reference) -> Value:
    value = scope.value(e.name, e.span)
    return index(scope, value, e.subscripts, e.span) if e.subscripts else value


def _unary(scope: Scope, e: flat.Unary) -> Value:
    t = scope.table
    return each(t.not_ if e.op == "not" else t.neg, lower_expression(scope, e.operand))


def _binary(scope: Scope, e: flat.Binary) -> Value:
    left = lower_expression(scope, e.left)
    if left is {"and": scope.table.false, "or": scope.table.true}.get(e.op):
        return left  # `i <= n and x > t[i]`: what is decided already is not looked at
    right = lower_expression(scope, e.right)
    if e.op in ("==", "<>") and flat.Base.REAL in (e.left.type.base, e.right.type.base):
        _doubt_equality(scope, e, expr(left), expr(right))
    return binary(scope, e.op, left, right, e.span)


def _doubt_equality(scope: Scope, e: flat.Binary, left: Expr, right: Expr) -> None:
    """Warn of numbers that are asked to be equal while they move."""
    if not scope.events or scope.at_event or scope.model.is_steady(scope.table.equal(left, right)):
        return
    a, b = e.left.span.text, e.right.span.text
    truth = "false" if e.op == "==" else "true"
    message = f"`{e.span.text}` is as good as always {truth}: a number that moves steps over values"
    hint = f"ask on which side it is: a `when` fires for `{a} > {b}` where it rises through, and "
    hint += f"for `{a} < {b}` where it falls through"
    found = Diagnostic("L316", message, e.span, Severity.WARNING, hint=hint)
    if found not in scope.model.warnings:
        scope.model.warnings.append(found)


def _if(scope: Scope, e: flat.If) -> Value:
    conditions = [expr(lower_expression(scope, c)) for c, _ in e.branches]
    for condition, (_, branch) in zip(conditions, e.branches, strict=True):
        if not condition.is_const:
            break
        if condition.data:
            return lower_expression(scope, branch)
    else:
        return lower_expression(scope, e.otherwise)
    reached = ways(scope, conditions)
    result = lower_expression(reached[-1], e.otherwise)
    for k in reversed(range(len(conditions))):
        condition, (_, branch) = conditions[k], e.branches[k]
        if condition.is_const and not condition.data:
            continue
        value = lower_expression(reached[k].where(condition), branch)
        result = choose(scope, condition, value, result, e.span)
    return result


def ways(scope: Scope, conditions: Sequence[Expr]) -> list[Scope]:
    """The scopes in which each condition is looked at, and the one in which none holds."""
    t = scope.table
    nots = (t.not_(condition) for condition in conditions)
    return [scope.where(holds) for holds in accumulate(nots, t.and_, initial=t.true)]


def choose(scope: Scope, condition: Any, then: Value, otherwise: Value, span: Span) -> Value:
    """`if condition then ... else ...` on values of one type."""
    if isinstance(then, RecordValue) and isinstance(otherwise, RecordValue):
        return RecordValue(
            tuple(
                (n, choose(scope, condition, v, otherwise.field(n), span)) for n, v in then.fields
            )
        )
    if shape_of(then) != shape_of(otherwise):
        raise error("L309", "the branches differ in their dimensions", span)
    t = scope.table
    if any(isinstance(v, Text) for v in elements(then)[:1]):
        return each(lambda a, b: texts.choice(t, condition, a, b), then, otherwise)
    return each(lambda a, b: t.if_(condition, a, b), then, otherwise)


def _array(scope: Scope, e: flat.Array) -> Value:
    inner = tuple(n or 0 for n in e.type.dims[1:])
    return stacked([lower_expression(scope, item) for item in e.items], inner, e.span)


def range_bounds(scope: Scope, e: flat.Range) -> tuple[Expr, Expr, Expr]:
    """Start, step and stop; parameters that they depend on become structural."""
    written = (e.start, e.step, e.stop)
    found = [scope.table.one if b is None else expr(lower_expression(scope, b)) for b in written]
    start, step, stop = (b if b.is_const else scope.model.number(b) for b in found)
    if step.is_const and step.data == 0:
        raise error("L310", "the step of a range is zero", e.span)
    return start, step, stop


def _range(scope: Scope, e: flat.Range) -> Value:
    bounds = range_bounds(scope, e)
    if not all(b.is_const for b in bounds):
        message = "the ends of a range must be known when the model is compiled"
        raise UnknownCourse(Diagnostic("L310", message, e.span))
    start, step, stop = (b.data for b in bounds)
    steps = (stop - start) / step * (1 + 1e-15)
    if not steps < MAX_ENTRIES:
        raise error("L310", f"a range of {steps:g} values is too long", e.span)
    count = math.floor(steps) + 1 if steps >= 0 else 0
    return stack([scope.table.const(start + i * step) for i in range(count)])


def _index(scope: Scope, e: flat.Index) -> Value:
    return index(scope, _whole(scope, e.base), e.subscripts, e.span)


def _whole(scope: Scope, base: flat.Expression) -> Value:
    """An array of which an entry is taken; a call is made once for all of its entries."""
    opened = scope.model.opened
    if opened is None or scope.locals or not isinstance(base, flat.Call):
        return lower_expression(scope, base)
    if id(base) not in opened:
        opened[id(base)] = lower_expression(scope, base)
    return opened[id(base)]


def index(scope: Scope, value: Value, subscripts: flat.Expressions, span: Span) -> Value:
    """`value[subscripts]`; a vector or `:` as a subscript keeps its dimension."""
    positions = [None if isinstance(s, flat.Slice) else subscript(scope, s) for s in subscripts]
    return _taken(scope, value, positions, span)


def subscript(scope: Scope, s: flat.Expression) -> Value:
    """The position or the positions, from 1, that a subscript means; `false` is the first."""
    value, t = lower_expression(scope, s), scope.table
    if s.type.base is not flat.Base.BOOLEAN:
        return value
    return each(lambda e: t.if_(e, t.const(2), t.one), value)


def _taken(scope: Scope, value: Value, positions: list[Value | None], span: Span) -> Value:
    if not positions:
        return value
    if not isinstance(value, Tensor):
        raise error("L311", "a scalar has no subscripts", span)
    position, *rest = positions
    if position is None:
        return stack([_taken(scope, r, rest, span) for r in value.rows()], value.shape[1:])
    if isinstance(position, Tensor):
        picked = [_row(scope, value, expr(p), span) for p in position.items]
        return stack([_taken(scope, r, rest, span) for r in picked], value.shape[1:])
    return _taken(scope, _row(scope, value, expr(position), span), rest, span)


def _row(scope: Scope, value: Tensor, position: Any, span: Span) -> Value:
    t = scope.table
    if position.is_const:
        number, count = int(position.data), value.shape[0]
        if not 1 <= number <= count:
            raise outside_array(number, count, span)
        row: Value = value.row(number - 1)
        return row
    rows = value.rows()
    if not rows:
        raise OutsideArray(Diagnostic("L312", "an empty array has no entries", span))
    # A subscript that changes while running: a choice between all entries.
    scope.keep_within(position, range(1, len(rows) + 1), span)
    result: Value = rows[-1]
    for number in range(len(rows) - 1, 0, -1):
        condition = t.equal(position, t.const(number))
        result = choose(scope, condition, rows[number - 1], result, span)
    return result


def assertion(scope: Scope, e: flat.Assert) -> dae.Assertion:
    condition = holds(scope, e.condition)
    text = message(scope.where(scope.table.not_(condition)), e.message)
    component = e.component or scope.model.component  # of a function: of who calls it
    return dae.Assertion(condition, text, e.warning, component, e.span, scope.model.given(e))


def holds(scope: Scope, e: flat.Expression) -> Expr:
    """A condition, or that it is not evaluated."""
    condition = expr(lower_expression(scope, e))
    if scope.path is None:
        return condition
    return scope.table.or_(scope.table.not_(scope.path), condition)


def message(scope: Scope, e: flat.Expression) -> dae.Message:
    """A text for the user, which is made where the scope's path comes to it."""
    if scope.path is scope.table.false:
        return dae.Message(())
    text = lower_expression(scope, e)
    return dae.Message(text.parts if isinstance(text, Text) else ())


def _field(scope: Scope, e: flat.Field) -> Value:
    base = lower_expression(scope, e.base)
    if isinstance(base, Tensor):
        return Tensor(
            base.shape, tuple(v.field(e.name) for v in base.items if isinstance(v, RecordValue))
        )
    assert isinstance(base, RecordValue)
    return base.field(e.name)


def _record(scope: Scope, e: flat.Record) -> Value:
    fields: list[tuple[str, Value]] = []
    for (name, type_), item in zip(e.type.fields, e.items, strict=True):
        value = lower_expression(scope, item)
        expect_size(f"`{name}`", type_.dims, value, item.span)
        fields.append((name, value))
    return RecordValue(tuple(fields))


#: Operators between clocks and parts that pass values on as they are.
_PASSED_ON = CONVERSIONS | OUTWARDS


def _builtin(scope: Scope, e: flat.Builtin) -> Value:
    match e.function:
        case "noEvent":
            return lower_expression(scope.without_events(), e.arguments[0])
        case "smooth":
            return lower_expression(scope.without_events(), e.arguments[1])
        case "pre" | "previous":
            before = _unassigned(scope, e.arguments[0])
            return builtins.call(scope, "pre", (before,), e.span)
        case "homotopy" if not scope.model.blended:
            scope.model.simplified = True
            return lower_expression(scope, e.arguments[0])
        case "edge" | "change":
            pair = lower_expression(scope, e.arguments[0]), _unassigned(scope, e.arguments[0])
            return builtins.call(scope, e.function, pair, e.span)
        case "Enumeration":
            return _literal_at(scope, e)
        case "sample" if is_clocked_sample(e):
            with scope.model.between_ticks():
                value = lower_expression(scope.without_events(), e.arguments[0])
            return builtins.call(scope, "sampled", (value,), e.span)
        case function if function in _PASSED_ON:
            return lower_expression(scope, e.arguments[0])
    arguments = tuple(lower_expression(scope, a) for a in e.arguments)
    if e.function == "String":
        value, *options = arguments
        return texts.written(scope.model, value, options, e.arguments[0].type, e.span)
    return builtins.call(scope, e.function, arguments, e.span)


def _literal_at(scope: Scope, e: flat.Builtin) -> Value:
    """`Kind(i)`: a literal is its number, which must be that of one (4.9.5.2)."""
    number, last = expr(lower_expression(scope, e.arguments[0])), len(e.type.literals)
    if not number.is_const or not 1 <= number.data <= last:
        scope.keep_within(number, range(1, last + 1), e.span, f"as a `{e.type.name}`, the number")
    return number


def _unassigned(scope: Scope, e: flat.Expression) -> Value:
    """A variable of the model itself, not what an algorithm assigned to it so far."""
    match e:
        case flat.Reference() if e.name in scope.model.values:
            value = scope.model.values[e.name]
            return index(scope, value, e.subscripts, e.span) if e.subscripts else value
        case flat.Array():
            inner = tuple(n or 0 for n in e.type.dims[1:])
            return stack([_unassigned(scope, item) for item in e.items], inner)
        case flat.Index():
            return index(scope, _unassigned(scope, e.base), e.subscripts, e.span)
    return lower_expression(scope, e)


def _call(scope: Scope, e: flat.Call) -> Value:
    arguments = tuple(lower_expression(scope, a) for a in e.arguments)
    results = scope.model.inline(scope, e.function, arguments, e.span)
    if len(results) <= (e.output or 0):  # of a function that is handed in
        raise error("L321", f"the function given as `{e.function}` has no result", e.span)
    return results[e.output or 0]


def _partial_call(scope: Scope, e: flat.PartialCall) -> Value:
    bound = tuple((n, lower_expression(scope, b)) for n, b in e.bound)
    passed = scope.locals.get(e.function) if scope.locals and e.inputs else None
    if not isinstance(passed, FunctionValue):
        return FunctionValue(e.function, bound)
    # Inputs that are open so far stand in the order of the interface, by names of their own.
    known = dict(passed.bound)
    inputs = (v.name for v in scope.model.functions[passed.function].inputs if v.name not in known)
    own = dict(zip(e.inputs, inputs, strict=False))
    return FunctionValue(passed.function, (*passed.bound, *((own[n], v) for n, v in bound)))


def _expect_alike(scope: Scope, e: flat.Comprehension) -> None:
    """Refuse a call for each entry of arrays of different sizes (12.4.6)."""
    sizes = dict.fromkeys(shape_of(lower_expression(scope, a))[0] for a in e.alike)
    if len(sizes) > 1:
        message = f"the arrays of this call differ in size: {listed(map(str, sizes))}"
        raise error("L314", message, e.span)


def _comprehension(scope: Scope, e: flat.Comprehension) -> Value:
    _expect_alike(scope, e)

    def rows(at: Scope, rest: tuple[tuple[str, flat.Expression], ...]) -> Value:
        if not rest:
            return lower_expression(at, e.body)
        (name, domain), *others = rest
        entries = elements(lower_expression(at, domain))
        inner = [
            rows(replace(at, locals={**(at.locals or {}), name: x}), tuple(others)) for x in entries
        ]
        return stacked(inner, (), e.span)

    value = rows(scope, e.iterators)
    return value if e.reduce == "array" else builtins.call(scope, e.reduce, (value,), e.span)


_RULES: Mapping[type, Callable[[Scope, Any], Value]] = {
    flat.Literal: _literal,
    flat.Reference: _reference,
    flat.Unary: _unary,
    flat.Binary: _binary,
    flat.If: _if,
    flat.Array: _array,
    flat.Range: _range,
    flat.Index: _index,
    flat.Field: _field,
    flat.Record: _record,
    flat.Builtin: _builtin,
    flat.Call: _call,
    flat.PartialCall: _partial_call,
    flat.Comprehension: _comprehension,
}
