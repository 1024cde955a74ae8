"""`delay(expr, delayTime)` and `delay(expr, delayTime, delayMax)` (specification 3.7.4.1).

The value is `past1(time - delayTime)`, a function of one instant whose values the run
gathers. It gets a variable of its own, so that it may stand wherever a variable may; what
is delayed, and a delay time that changes, get one where they are no variables yet.

Example:

    y = delay(sin(x), T)       ->     $delay[1] = past1(time - T)
                                      $delay[1].of = sin(x)
                                      y = $delay[1]

A delay of the time 0 is its signal; parameters that say so shape the equations.

Differentiating by time is differentiating `past1`, so that index reduction works.
"""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir import dae
from planarc.ir.expr import Expr, Op, postorder
from planarc.lower.scope import DELAY, Model, Scope
from planarc.lower.values import Value, expr


def delay(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    """A delayed signal. Raises L362, L363 for delay times that cannot be."""
    model, t = scope.model, scope.table
    signal, interval = expr(a[0]), expr(a[1])
    maximum = expr(a[2]) if len(a) == 3 else None
    _check(model, interval, maximum, span)
    if _is_zero(model, interval) or _is_fixed(model, signal):
        return signal
    known = model.delay_values.get((signal, interval))
    if known is not None:
        return known
    name = f"{DELAY}{len(model.delays) + 1}]"
    if _is_fixed(model, interval):
        maximum = None
    else:
        interval = _named(model, interval, f"{name}.by", span)
    of = _named(model, signal, f"{name}.of", span)
    past = t.past(len(model.delays), t.sub(t.time, interval))
    model.delays.append(dae.Delay(of.name, interval, maximum, span.text or "delay", span))
    value = _variable(model, name, past, span)
    model.delay_values[signal, interval] = value
    return value


def _check(model: Model, interval: Expr, maximum: Expr | None, span: Span) -> None:
    if interval.is_const and interval.data < 0:
        raise error("L362", "a delay time must not be negative", span)
    limits = (interval, maximum) if maximum is not None else ()
    if limits and all(e.is_const for e in limits) and limits[0].data > limits[1].data:
        raise error("L362", "a delay time must not exceed the largest one, given third", span)
    if _is_fixed(model, interval):
        return
    if maximum is None:
        message = "the delay time of `delay` with two arguments must be a parameter expression"
        hint = "give the largest delay time as a third argument"
        raise error("L363", message, span, hint=hint)
    if not _is_fixed(model, maximum):
        raise error("L363", "the third argument of `delay` must be a parameter expression", span)


def _is_zero(model: Model, interval: Expr) -> bool:
    """True for a time of zero, which is no delay; parameters that make it so are frozen."""
    before = set(model.frozen)
    value = model.number(interval)
    if value.is_const and value.data == 0:
        return True
    model.frozen.intersection_update(before)
    return False


def _is_fixed(model: Model, e: Expr) -> bool:
    """True for an expression of parameters alone."""
    return all(
        n.op not in (Op.TIME, Op.PRE, Op.EVENT)
        and not (n.op is Op.SYMBOL and n.name not in model.parameters)
        for n in postorder((e,))
    )


def _named(model: Model, e: Expr, name: str, span: Span) -> Expr:
    """A continuous variable of this value."""
    is_variable = e.is_symbol and not e.order and e.name not in model.discretes
    if is_variable and not e.name.startswith("$"):
        return e
    return _variable(model, name, e, span)


def _variable(model: Model, name: str, value: Expr, span: Span) -> Expr:
    symbol = model.table.symbol(name)
    variable = dae.Variable(name, protected=True, span=span)
    model.added.append((variable, dae.Equation(symbol, value, span)))
    return symbol
