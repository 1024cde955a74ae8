"""Derivatives that a function's annotations give: its value is not what is differentiated.

In:   a call of a function whose derivative names inputs with `noDerivative`, and its results
Out:  unknowns of these values, each with an equation that knows its derivatives

Example: `Move` takes an angle, its speed and its acceleration as three signals.

    phi = position(u, time)             phi = $given[1]
                                  ->
    position = u[1]                     $given[1] = u[1]
    position_der = u[2]                 its derivatives: u[2], u[3]
    position_der2 = u[3]

Promises:  a derivative that cannot be run on expressions is none: the value is differentiated.
Reference: Modelica Language Specification 3.6, section 12.7.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.lower.scope import GIVEN, Model, Scope
from planarc.lower.values import Value
from planarc.runtime.tensor import Tensor, each


def with_rates(
    scope: Scope,
    function: flat.Function,
    arguments: Sequence[Value],
    results: tuple[Value, ...],
    span: Span,
) -> tuple[Value, ...]:
    """The results of a call in an equation, with the derivatives that are given for them."""
    first = next((d for d in function.derivatives if d.order == 1 and d.still), None)
    continuous = scope.locals is None and scope.events and not scope.at_event
    if first is None or not continuous or not all(map(_is_real, (*arguments, *results))):
        return results
    model = scope.model
    if all(model.is_steady(e) for a in arguments for e in _entries(a)):
        return results
    rates = _rates(scope, function, arguments, first, span)
    if not rates:
        return results
    named = partial(_named, model, span)
    return tuple(each(named, *values) for values in zip(results, *rates, strict=True))


def _rates(
    scope: Scope,
    function: flat.Function,
    arguments: Sequence[Value],
    first: flat.Derivative,
    span: Span,
) -> list[tuple[Value, ...]]:
    """The first derivatives of the results, as far as they are given."""
    model = scope.model

    def derive(value: Value) -> Value:
        return each(model.time_derivative, value)

    given, moving = list(arguments), _moving(function, first)
    found: list[tuple[Value, ...]] = []
    following: flat.Derivative | None = first
    while following is not None and following.function in model.functions:
        given += [derive(given[i]) for i in moving]
        following_function = model.functions[following.function]
        if len(given) != len(following_function.inputs):
            break
        try:
            with model.undone_on_error():
                found.append(model.inline(scope, following.function, given, span))
        except PlanarcError:
            break
        function, order = following_function, len(found) + 1
        following = next((d for d in function.derivatives if d.order in (1, order)), None)
        if following is not None and following.order == 1:
            moving = _moving(function, following)
        else:  # of an order: what is added are derivatives of what was added before
            moving = list(range(len(given) - len(moving), len(given)))
    return found


def _moving(function: flat.Function, derivative: flat.Derivative) -> list[int]:
    return [
        i
        for i, v in enumerate(function.inputs)
        if v.type.base is flat.Base.REAL and v.name not in derivative.still
    ]


def _named(model: Model, span: Span, value: Expr, *rates: Expr) -> Expr:
    name = f"{GIVEN}{len(model.added) + 1}]"
    symbol = model.table.symbol(name)
    equation = dae.Equation(symbol, value, span, model.component, rates=rates)
    model.added.append((dae.Variable(name, protected=True, span=span), equation))
    return symbol


def _is_real(value: Value) -> bool:
    return isinstance(value, Expr) or (
        isinstance(value, Tensor) and all(isinstance(e, Expr) for e in value.items)
    )


def _entries(value: Value) -> Sequence[Expr]:
    return value.items if isinstance(value, Tensor) else (value,)
