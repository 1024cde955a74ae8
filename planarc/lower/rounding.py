"""Functions that jump: floor, ceil, integer, div, mod and rem make events (3.7.2).

In:   a value that changes while running
Out:  its whole part, constant between events, and the relation that switches it

Which of the even or odd intervals between whole numbers `y` lies in is a stored truth:

    y in [0, 1): even      y in [1, 2): odd      y in [2, 3): even ...

switched where a triangle wave crosses zero, once at every whole number. Given that truth,
the whole part is computed by formulas that jump half an interval away from there, so that
errors of rounding at the event do not matter:

    even: 2*floor((y + 1/2)/2)          odd: 2*floor((y - 1/2)/2) + 1

At a whole number the wave is not zero but next to nothing, with the sign of the interval
that begins there: a value that comes to lie on a whole number is rounded to it.

Example: `mod(time, 1)` is a sawtooth with events at 1, 2, 3, ...

So that a run may start at any whole number, `y = x + s`, where `s` (0 or 1) is chosen at
the start to make the first interval an even one.
"""

from __future__ import annotations

from planarc.core.source import Span
from planarc.ir import dae
from planarc.ir.expr import Expr
from planarc.lower.operators import divide
from planarc.lower.scope import Scope

#: Far below all rounding errors.
EDGE = 1e-250


def floor(scope: Scope, x: Expr, span: Span) -> Expr:
    """The largest whole number that is not above `x`."""
    t = scope.table
    if _is_plain(scope, x):
        return t.call("floor", x)
    half, one, two = t.const(0.5), t.one, t.const(2)
    phase = _phase(scope, x, span)
    y = t.add(x, phase)
    wave = t.sub(half, t.call("abs", t.sub(t.call("mod", t.add(y, half), two), one)))
    begins = t.sub(t.const(EDGE), t.mul(t.const(2 * EDGE), t.call("mod", y, two)))
    wave = t.if_(t.equal(wave, t.zero), begins, wave)
    odd = scope.model.relation(wave, True, span.text or "floor", span)
    upper = t.mul(two, t.call("floor", t.mul(half, t.add(y, half))))
    lower = t.add(t.mul(two, t.call("floor", t.mul(half, t.sub(y, half)))), one)
    return t.sub(t.if_(odd, lower, upper), phase)


def _phase(scope: Scope, x: Expr, span: Span) -> Expr:
    """A discrete variable: 1 when the run starts in an odd interval, else 0."""
    model, t = scope.model, scope.table
    known = model.phases.get(x)
    if known is not None:
        return known
    symbol = t.symbol(f"{dae.PHASE}[{len(model.phases) + 1}]")
    odd = t.call("mod", t.call("floor", x), t.const(2))
    value = t.if_(t.symbol(dae.INITIAL), odd, t.pre(symbol.name))
    variable = dae.Variable(symbol.name, dae.Kind.REAL, protected=True, span=span)
    model.phases[x] = symbol
    model.discretes.add(symbol.name)
    model.auxiliaries.append((variable, dae.Equation(symbol, value, span)))
    return symbol


def _is_plain(scope: Scope, x: Expr) -> bool:
    """True where a value makes no events when it passes whole numbers."""
    return not scope.events or scope.at_event or scope.model.is_steady(x)


def _stepping(scope: Scope, x: Expr, y: Expr, span: Span) -> Expr | None:
    """The quotient, None where it makes no events."""
    quotient = divide(scope.table, x, y, span)
    return None if _is_plain(scope, quotient) else quotient


def ceil(scope: Scope, x: Expr, span: Span) -> Expr:
    t = scope.table
    return t.neg(floor(scope, t.neg(x), span))


def div(scope: Scope, x: Expr, y: Expr, span: Span) -> Expr:
    """The quotient without its fraction, rounded towards zero."""
    t = scope.table
    quotient = _stepping(scope, x, y, span)
    if quotient is None:
        return t.call("div", x, y)
    whole = floor(scope, t.call("abs", quotient), span)
    return t.if_(t.less(quotient, t.zero), t.neg(whole), whole)


def mod(scope: Scope, x: Expr, y: Expr, span: Span) -> Expr:
    """`x - floor(x/y)*y`."""
    t = scope.table
    quotient = _stepping(scope, x, y, span)
    if quotient is None:
        return t.call("mod", x, y)
    return t.sub(x, t.mul(floor(scope, quotient, span), y))


def rem(scope: Scope, x: Expr, y: Expr, span: Span) -> Expr:
    """`x - div(x, y)*y`."""
    t = scope.table
    if _stepping(scope, x, y, span) is None:
        return t.call("rem", x, y)
    return t.sub(x, t.mul(div(scope, x, y, span), y))
