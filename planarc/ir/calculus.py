"""Derivatives of expressions: by a symbol, and by time.

Both differentiators remember every node they have seen, so one of each serves a
whole model. A function of the model (APPLY) is differentiated by name: the rule
only notes which argument; `codegen` makes that derivative when it is printed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from planarc.ir.expr import Expr, Exprs, Op

Rule = Callable[[Exprs, tuple[Expr, ...]], tuple[Expr, ...]]


class Differentiator:
    """d(e) for every node e, given the derivatives of the leaves."""

    def __init__(self, table: Exprs, leaf: Callable[[Expr], Expr]) -> None:
        self._table = table
        self._leaf = leaf
        self._memo: dict[Expr, Expr] = {}

    def __call__(self, root: Expr) -> Expr:
        memo = self._memo
        stack = [root]
        while stack:
            e = stack[-1]
            if e in memo:
                stack.pop()
                continue
            waiting = [a for a in e.args if a not in memo]
            if waiting:
                stack.extend(waiting)
            else:
                memo[e] = self._derive(e)
                stack.pop()
        return memo[root]

    def _derive(self, e: Expr) -> Expr:
        t = self._table
        if e.op is Op.CONST:
            return t.zero
        if not e.args:
            return self._leaf(e)
        d = tuple(self._memo[a] for a in e.args)
        match e.op:
            case Op.ADD:
                return t.add(*d)
            case Op.NEG:
                return t.neg(d[0])
            case Op.MUL:
                return t.add(
                    *(
                        t.mul(*e.args[:i], d[i], *e.args[i + 1 :])
                        for i in range(len(d))
                        if d[i] is not t.zero
                    )
                )
            case Op.IF:
                return t.if_(e.args[0], d[1], d[2])
            case Op.LESS | Op.LESS_EQUAL | Op.EQUAL | Op.AND | Op.OR | Op.NOT:
                return t.zero  # a truth value: constant but for jumps
            case _ if all(x is t.zero for x in d):
                return t.zero
        slopes = self._slopes(e)
        return t.add(*(t.mul(s, x) for s, x in zip(slopes, d, strict=True) if x is not t.zero))

    def _slopes(self, e: Expr) -> tuple[Expr, ...]:
        """The partial derivatives of a node by its arguments."""
        t = self._table
        match e.op:
            case Op.DIV:
                a, b = e.args
                return t.div(t.one, b), t.neg(t.div(a, t.pow(b, t.const(2.0))))
            case Op.POW:
                return _power_slopes(t, e)
            case Op.APPLY:
                function, output, wrt = e.data
                return tuple(
                    t.apply(function, e.args, output, (*wrt, i)) for i in range(len(e.args))
                )
            case Op.PAST:
                delay, order = e.data
                return (t.past(delay, e.args[0], order + 1),)
            case Op.CALL:
                return _RULES[e.data](t, e.args)
        raise AssertionError(f"no derivative for {e.op!r}")


def partial(table: Exprs, symbol: Expr) -> Differentiator:
    """Differentiates by one symbol; all others, time and discrete values are constant."""
    return Differentiator(table, lambda leaf: table.one if leaf is symbol else table.zero)


def time_derivative(table: Exprs, is_constant: Callable[[str], bool]) -> Differentiator:
    """Differentiates by time; `is_constant` tells names that do not change between events."""

    def leaf(e: Expr) -> Expr:
        if e.op is Op.TIME:
            return table.one
        if e.op is Op.SYMBOL and not is_constant(e.name):
            return table.der(e)
        return table.zero

    return Differentiator(table, leaf)


def _power_slopes(t: Exprs, e: Expr) -> tuple[Expr, Expr]:
    base, exponent = e.args
    by_base = t.mul(exponent, t.pow(base, t.sub(exponent, t.one)))
    if exponent.is_const:
        return by_base, t.zero
    return by_base, t.mul(e, t.call("log", base))


def _sqrt_of(t: Exprs, *terms: Expr) -> Expr:
    return t.call("sqrt", t.add(*terms))


def _square(t: Exprs, a: Expr) -> Expr:
    return t.mul(a, a)


def _atan2_slopes(t: Exprs, a: tuple[Expr, ...]) -> tuple[Expr, ...]:
    y, x = a
    length = t.add(_square(t, x), _square(t, y))
    return t.div(x, length), t.neg(t.div(y, length))


def _flat(t: Exprs, a: tuple[Expr, ...]) -> tuple[Expr, ...]:
    return (t.zero,) * len(a)


def _modulo(rounding: str) -> Rule:
    """mod and rem: x - round(x/y)*y, where the rounded part is constant but for jumps."""
    if rounding == "floor":
        return lambda t, a: (t.one, t.neg(t.call("floor", t.div(a[0], a[1]))))
    return lambda t, a: (t.one, t.neg(t.call("div", a[0], a[1])))


_RULES: Mapping[str, Rule] = {
    "sin": lambda t, a: (t.call("cos", a[0]),),
    "cos": lambda t, a: (t.neg(t.call("sin", a[0])),),
    "tan": lambda t, a: (t.add(t.one, _square(t, t.call("tan", a[0]))),),
    "asin": lambda t, a: (t.div(t.one, _sqrt_of(t, t.one, t.neg(_square(t, a[0])))),),
    "acos": lambda t, a: (t.neg(t.div(t.one, _sqrt_of(t, t.one, t.neg(_square(t, a[0]))))),),
    "atan": lambda t, a: (t.div(t.one, t.add(t.one, _square(t, a[0]))),),
    "atan2": _atan2_slopes,
    "sinh": lambda t, a: (t.call("cosh", a[0]),),
    "cosh": lambda t, a: (t.call("sinh", a[0]),),
    "tanh": lambda t, a: (t.sub(t.one, _square(t, t.call("tanh", a[0]))),),
    "exp": lambda t, a: (t.call("exp", a[0]),),
    "log": lambda t, a: (t.div(t.one, a[0]),),
    "log10": lambda t, a: (t.div(t.const(0.4342944819032518), a[0]),),
    "sqrt": lambda t, a: (t.div(t.const(0.5), t.call("sqrt", a[0])),),
    "abs": lambda t, a: (t.if_(t.less(a[0], t.zero), t.const(-1.0), t.one),),
    "min": lambda t, a: (
        t.if_(t.less_equal(a[0], a[1]), t.one, t.zero),
        t.if_(t.less_equal(a[0], a[1]), t.zero, t.one),
    ),
    "max": lambda t, a: (
        t.if_(t.less_equal(a[1], a[0]), t.one, t.zero),
        t.if_(t.less_equal(a[1], a[0]), t.zero, t.one),
    ),
    "sign": _flat,
    "floor": _flat,
    "ceil": _flat,
    "div": _flat,
    "mod": _modulo("floor"),
    "rem": _modulo("trunc"),
}
