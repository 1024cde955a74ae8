"""Calls of external functions that planarc has of its own.

In:   flat.Function with an external call; a Runner whose values are the inputs
Out:  the values of its outputs

A function of numbers stays a call, one APPLY node for each scalar that it gives, but for one that
solves linear equations (`solutions`). A function of texts is evaluated now, with the present values
of parameters. What acts on the world outside is not done, and gives zeros.

Example:  (r, state) = random(before)   with two entries in a state becomes
    state = {random[1](before[1], before[2]), random[2](...)},  r = random[3](...)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.expr import Expr
from planarc.lower import texts
from planarc.lower.assignment import zero_of
from planarc.lower.scope import Scope, unsupported
from planarc.lower.solutions import SOLVER, as_unknowns
from planarc.lower.statements import Runner
from planarc.lower.values import Text, Value, exprs
from planarc.runtime import external
from planarc.runtime.tensor import Tensor, stack


def call_external(runner: Runner, function: flat.Function, span: Span) -> tuple[Value, ...]:
    """The outputs of a call, in order. Raises PlanarcError where there are none."""
    name = function.external
    assert name is not None
    types = [v.type.with_dims(runner.dims(v)) for v in function.outputs]
    if any(None in t.dims for t in types):
        raise unsupported(f"an output of `{function.name}` with an unknown size", span)
    given = [runner.value(e) for e in function.given]
    empty = {
        v.name: zero_of(t, runner.scope.table) for v, t in zip(function.outputs, types, strict=True)
    }
    if external.is_of_numbers(name):
        solved = as_unknowns(runner.scope, given, span) if name == SOLVER else None
        row = solved or _results(runner.scope, name, given)
        found = {n: _next(empty[n], row) for n in function.results}
    elif external.is_of_texts(name):
        found = _text_results(runner.scope, function, given, span)
    elif name in external.SILENT:
        found = {}
    else:
        raise unsupported(f"a call of `{function.name}` while running", span)
    return tuple(found.get(v.name, empty[v.name]) for v in function.outputs)


def _results(scope: Scope, name: str, given: list[Value]) -> Iterator[Expr]:
    """All scalars that a function of numbers gives, one after the other."""
    arguments = tuple(e for value in given for e in exprs(value))
    if not external.is_pure(name):
        scope.model.impure_calls += 1
        place = scope.table.const(scope.model.impure_calls)
        arguments = (*arguments, place, scope.table.time)
    output = 0
    while True:
        yield scope.table.apply(name, arguments, output)
        output += 1


def _next(shape: Value, row: Iterator[Expr]) -> Value:
    if isinstance(shape, Tensor):
        return Tensor(shape.shape, tuple(next(row) for _ in range(math.prod(shape.shape))))
    return next(row)


# Texts --------------------------------------------------------------------------------------


def _text_results(
    scope: Scope, function: flat.Function, given: list[Value], span: Span
) -> dict[str, Value]:
    assert function.external is not None
    arguments = [
        _constant(scope, value, e.type.base, span)
        for value, e in zip(given, function.given, strict=True)
    ]
    try:
        found = external.call_texts(function.external, arguments)
    except ValueError as problem:
        raise error("L324", f"`{function.name}` has no value: {problem}", span) from None
    values = (_value(scope, x) for x in found)
    return dict(zip(function.results, values, strict=False))


def _constant(scope: Scope, value: Value, base: flat.Base, span: Span) -> Any:
    """A value known before the run; parameters that it depends on become structural."""
    if isinstance(value, Tensor):
        return [_constant(scope, v, base, span) for v in value.rows()]
    known = texts.decided(scope.model, value).constant if isinstance(value, Text) else None
    if known is not None:
        return known
    number = scope.model.number(value) if isinstance(value, Expr) else None
    if number is None or not number.is_const:
        raise unsupported("a function of a text that changes while running", span)
    return int(number.data) if base is not flat.Base.REAL else number.data


def _value(scope: Scope, result: Any) -> Value:
    if isinstance(result, list):
        return stack([_value(scope, r) for r in result])
    return Text((result,)) if isinstance(result, str) else scope.table.const(result)
