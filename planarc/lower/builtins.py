"""Built-in functions and operators of the language (specification 3.7 and 10.3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial, reduce

from planarc.core.diagnostic import Diagnostic, error
from planarc.core.source import Span
from planarc.ir import dae
from planarc.ir.expr import Expr, Exprs, Op
from planarc.lower import delays, rounding, texts
from planarc.lower.lefts import left_limit, left_limits
from planarc.lower.operators import relation
from planarc.lower.scope import Scope, Ticking, UnknownCourse, unsupported
from planarc.lower.values import RecordValue, Text, Value, expect_alike, expr, exprs, misfit_of
from planarc.runtime import elementary, tensor
from planarc.runtime.tensor import TooLarge, each, product, shape_of, stack

Builtin = Callable[[Scope, tuple[Value, ...], Span], Value]


def call(scope: Scope, function: str, arguments: tuple[Value, ...], span: Span) -> Value:
    """The value of a built-in function of already lowered arguments."""
    table = scope.table
    try:
        if function in tensor.FUNCTIONS:
            count = partial(_integer, span)
            return tensor.apply(table, function, count, arguments)
        if function in _BUILTINS:
            return _BUILTINS[function](scope, arguments, span)
    except (IndexError, ValueError, TooLarge):  # sizes that are known only now
        raise misfit_of(function, arguments, span) from None
    if function in elementary.TABLE:
        expect_alike(function, arguments, span)
        return each(lambda *a: table.call(function, *a), *arguments)
    raise unsupported(f"`{function}` (Modelica specification, section 3.7)", span)


# Time and events -----------------------------------------------------------------------


def _der(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    ticking = scope.model.ticking
    if ticking is not None:
        return each(lambda e: ticking.derivative(expr(e), span), a[0])
    return each(scope.model.time_derivative, a[0])


def _pre(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    def one(e: Value) -> Value:
        if isinstance(e, Text):
            return texts.held(expr(one(texts.number(scope.table, e))))
        symbol = expr(e)
        if symbol.op is Op.CONST:
            return symbol
        if symbol.op is not Op.SYMBOL:
            raise error("L306", "`pre` needs a variable", span)
        if symbol.name in scope.model.discretes:
            return scope.table.pre(symbol.name)
        if symbol.name.startswith("$"):
            return scope.table.false
        if symbol.name in scope.model.parameters:
            return symbol
        if scope.at_event:
            return left_limit(scope.model, symbol, span)
        message = f"`pre({symbol})` of a continuous variable stands outside of a when-clause"
        hint = "use `pre` on what changes at events only, such as a value that a `when` keeps"
        if span.text.startswith(("change(", "edge(")):
            word = span.text.partition("(")[0]
            message = (
                f"`{word}` looks at what changes at events only: `{symbol}` moves all the while"
            )
            hint = f"compare it, as in `when {symbol} > 0 then`"
        raise error("L306", message, span, hint=hint)

    return each(one, a[0])


def _edge(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    """The present value and the variable itself are given."""
    t = scope.table
    return each(lambda e, v: t.and_(e, t.not_(expr(_pre(scope, (v,), span)))), *a)


def _change(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    t = scope.table

    def changed(e: Value, variable: Value) -> Value:
        before = texts.number(t, _pre(scope, (variable,), span))
        return t.not_(t.equal(texts.number(t, e), before))

    return each(changed, *a)


def _sample(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    start, interval = expr(a[0]), expr(a[1])
    if not (scope.model.is_steady(start) and scope.model.is_steady(interval)):
        raise error("L307", "`sample` needs a start and an interval that are parameters", span)
    scope.model.samplers.append(dae.Sampler(start, interval, span))
    return scope.table.symbol(f"$sample[{len(scope.model.samplers) - 1}]")


def _sampled(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    """Left limits of what moves, as a clock finds them."""

    def before(e: Value) -> Value:
        if isinstance(e, RecordValue):
            return RecordValue(tuple((name, each(before, v)) for name, v in e.fields))
        return left_limits(scope.model, expr(e), span)

    return each(before, a[0])


def _interval(scope: Scope, _a: tuple[Value, ...], span: Span) -> Value:
    return _part(scope, span).interval()


def _first_tick(scope: Scope, _a: tuple[Value, ...], span: Span) -> Value:
    return _part(scope, span).first()


def _part(scope: Scope, span: Span) -> Ticking:
    if scope.model.ticking is None:
        raise error("L377", f"`{span.text}` stands where no clock ticks", span)
    return scope.model.ticking


def _first(_scope: Scope, a: tuple[Value, ...], _span: Span) -> Value:
    return a[0]


def _homotopy(scope: Scope, a: tuple[Value, ...], _span: Span) -> Value:
    """What leads from the simplified form to the actual one, which need have no value yet where
    that begins."""
    t = scope.table
    way = t.symbol(dae.HOMOTOPY)

    def blend(actual: Expr, simplified: Expr) -> Expr:
        mixed = t.add(t.mul(way, actual), t.mul(t.sub(t.one, way), simplified))
        return t.if_(t.less_equal(way, t.zero), simplified, mixed)

    return each(blend, *a)


def _semi_linear(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    t = scope.table
    x, positive, negative = (expr(v) for v in a)
    forward = relation(scope, ">=", x, t.zero, span)
    return t.mul(t.if_(forward, positive, negative), x)


# Arrays ------------------------------------------------------------------------------------


def _integer(span: Span, value: Value) -> int:
    e = expr(value)
    if not e.is_const:
        message = "an array size must be known when the model is compiled"
        raise UnknownCourse(Diagnostic("L308", message, span))
    return int(e.data)


def _size(scope: Scope, a: tuple[Value, ...], span: Span) -> Value:
    shape = shape_of(a[0])
    if len(a) == 1:
        return stack([scope.table.const(n) for n in shape])
    return scope.table.const(shape[_integer(span, a[1]) - 1])


def _reduction(name: str, step: Callable[[Exprs, Expr, Expr], Expr]) -> Builtin:
    def reduction(scope: Scope, a: tuple[Value, ...], _span: Span) -> Value:
        values = exprs(a[0]) if len(a) == 1 else tuple(expr(v) for v in a)
        if not values:
            return scope.table.const(elementary.OF_NOTHING[name])
        return reduce(lambda x, y: step(scope.table, x, y), values)

    return reduction


# Numbers --------------------------------------------------------------------------------------


def _rounded(step: Callable[..., Expr]) -> Builtin:
    return lambda scope, a, span: each(lambda *e: step(scope, *e, span), *a)


_BUILTINS: Mapping[str, Builtin] = {
    "time": lambda scope, _a, _span: scope.table.time,
    "der": _der,
    "pre": _pre,
    "edge": _edge,
    "change": _change,
    "sample": _sample,
    "sampled": _sampled,
    "interval": _interval,
    "firstTick": _first_tick,
    "initial": lambda scope, _a, _span: scope.table.symbol(dae.INITIAL),
    "terminal": lambda scope, _a, _span: scope.table.symbol(dae.TERMINAL),
    "delay": delays.delay,
    "homotopy": _homotopy,
    "semiLinear": _semi_linear,
    "size": _size,
    "ndims": lambda scope, a, _span: scope.table.const(len(shape_of(a[0]))),
    "sum": lambda scope, a, _span: scope.table.add(*exprs(a[0])),
    "product": lambda scope, a, _span: scope.table.mul(*exprs(a[0])),
    "min": _reduction("min", lambda t, x, y: t.call("min", x, y)),
    "max": _reduction("max", lambda t, x, y: t.call("max", x, y)),
    "dot": lambda scope, a, _span: product(scope.table, a[0], a[1]),
    "floor": _rounded(rounding.floor),
    "integer": _rounded(rounding.floor),
    "ceil": _rounded(rounding.ceil),
    "div": _rounded(rounding.div),
    "mod": _rounded(rounding.mod),
    "rem": _rounded(rounding.rem),
    "Integer": _first,
    "Real": _first,
}
