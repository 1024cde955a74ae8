"""Derivatives of expressions: by a symbol, and by time.

Both differentiators remember every node they have seen, so one of each serves a
whole model. A function of the model (APPLY) is differentiated by name: the rule
only notes which argument; `codegen` makes that derivative when it is printed.
A loop is differentiated turn by turn: its derivative is a loop of as many turns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from planarc.ir.closing import close, opened, symbols_of
from planarc.ir.expr import Expr, Exprs, Op, Substitution, below, fold
from planarc.runtime import elementary

# Where it counts: an enumeration looks up its members by a function.
_CONST, _ADD, _MUL, _NEG, _LOOP = Op.CONST, Op.ADD, Op.MUL, Op.NEG, Op.LOOP
_TRUTHS = (Op.LESS, Op.LESS_EQUAL, Op.EQUAL, Op.AND, Op.OR, Op.NOT)


class Differentiator:
    """d(e) for every node e, given the derivatives of the leaves."""

    def __init__(self, table: Exprs, leaf: Callable[[Expr], Expr]) -> None:
        self._table = table
        self._leaf = leaf
        self._memo: dict[Expr, Expr] = {}

    def __call__(self, root: Expr) -> Expr:
        return fold(root, self._memo, self._derive)

    def _derive(self, e: Expr) -> Expr:
        if e.op is _CONST:
            return self._table.zero
        if not e.args:
            return self._leaf(e)
        return self._by_arguments(e, list(map(self._memo.__getitem__, e.args)))

    def _by_arguments(self, e: Expr, d: list[Expr]) -> Expr:
        """d(e), given those of its arguments."""
        t, op, args = self._table, e.op, e.args
        if d.count(t.zero) == len(d):
            return t.zero
        if op is _ADD:
            return t.add(*d)
        if op is _NEG:
            return t.neg(d[0])
        if op is _MUL:
            slopes = ((i, x) for i, x in enumerate(d) if x is not t.zero)
            return t.add(*[t.mul(*args[:i], x, *args[i + 1 :]) for i, x in slopes])
        if op is Op.IF:
            return t.if_(args[0], d[1], d[2])
        if op in _TRUTHS:
            return t.zero  # a truth value is constant but for jumps
        if op is _LOOP:
            return _of_loop(t, e, d)
        pairs = zip(self._slopes(e), d, strict=True)
        return t.add(*(t.mul(s, x) for s, x in pairs if x is not t.zero))

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
                return _call_slopes(t, e)
        raise AssertionError(f"no derivative for {e.op!r}")


#: Turns that a loop takes at most until its derivatives have settled, the part of these that may
#: still change, and that of values that stay.
_SETTLING, _SETTLED, _STAYING = 100, 1e-11, 1e-10


def _of_loop(t: Exprs, e: Expr, d: Sequence[Expr]) -> Expr:
    """d(e) of what a loop gives, where `d` are those of what it takes. It is linear in these, and
    so must be the expression: equations of speeds are linear."""
    alike = {x: tuple(t.one if x is y else t.zero for y in d) for x in d if x is not t.zero}
    return t.add(*(t.mul(_loop_slope(t, e, seeds), x) for x, seeds in alike.items()))


def _loop_slope(t: Exprs, e: Expr, d: Sequence[Expr]) -> Expr:
    """A derivative of what a loop gives by numbers that it takes: a loop of as many turns carries
    derivatives beside what it carried.

    A search that begins at what it looks for takes no turn, and its derivatives have not moved yet.
    So, as long as more turns leave all values about as they are, they are taken for the derivatives
    until these settle. Where they do not, they are those of the loop's own turns.
    """
    loop, output = e.data
    values, rates, ends = (symbols_of(t, loop, mark) for mark in ("", "'", "''"))
    condition, left = opened(t, loop, values)
    following = [t.if_(e, t.one, t.zero) if e.op in _TRUTHS else e for e in left]
    moving = [x is not t.zero for x in d]
    slopes = _slopes_of_turn(t, following, values, rates, moving)
    if output == loop.ended or not moving[output]:
        return t.zero
    states, own = loop.carried - loop.aside, [i for i in range(loop.carried) if moving[i]]
    turns, most = t.symbol("$turns"), t.const(float(_SETTLING))
    stays = settled = t.true
    read = set(below((condition, *following)))
    for i in (i for i in range(states) if values[i] in read):
        size = t.add(t.one, t.call("abs", following[i]))
        stays = t.and_(stays, _is_near(t, values[i], following[i], t.mul(t.const(_STAYING), size)))
    for i in own:
        size = t.call("abs", slopes[i])
        settled = t.and_(settled, _is_near(t, rates[i], slopes[i], t.mul(t.const(_SETTLED), size)))
    goes_on = t.or_(condition, t.and_(stays, t.and_(t.not_(settled), t.less(turns, most))))
    carried = [(values[i], e.args[i], following[i]) for i in range(states)]
    carried += [(rates[i], d[i], slopes[i]) for i in own if i < states]
    counting = len(carried)
    carried += [(values[i], e.args[i], following[i]) for i in range(states, loop.carried)]
    carried += [(rates[i], d[i], slopes[i]) for i in own if i >= states]
    carried += [(ends[i], d[i], t.if_(condition, slopes[i], ends[i])) for i in own]
    carried += [(turns, t.zero, t.if_(condition, t.zero, t.add(turns, t.one)))]
    symbols, first, next_ = zip(*carried, strict=True)
    tangent, given = close(loop.name, symbols, goes_on, next_, len(carried) - counting)
    put_in = Substitution(t, dict(zip((*values, *rates), (*e.args, *d), strict=True)))
    args = (*first, *map(put_in, given))
    rate, end, taken = (
        t.loop(tangent, symbols.index(s), args) for s in (rates[output], ends[output], turns)
    )
    return t.if_(t.less(taken, most), rate, end)


def _is_near(t: Exprs, a: Expr, b: Expr, reach: Expr) -> Expr:
    return t.less_equal(t.call("abs", t.sub(a, b)), reach)


def _slopes_of_turn(
    t: Exprs,
    following: Sequence[Expr],
    values: Sequence[Expr],
    rates: Sequence[Expr],
    moving: list[bool],
) -> list[Expr]:
    """The derivatives of what follows a turn. What moves with what does so is marked, too."""
    place = {value: i for i, value in enumerate(values)}

    def rate(leaf: Expr) -> Expr:
        i = place.get(leaf)
        return t.zero if i is None or not moving[i] else rates[i]

    while True:
        slopes = list(map(Differentiator(t, rate), following))
        found = [i for i, s in enumerate(slopes) if s is not t.zero and not moving[i]]
        if not found:
            return slopes
        for i in found:
            moving[i] = True


def partial(table: Exprs, symbol: Expr) -> Differentiator:
    """Differentiates by one symbol; all others, time and discrete values are constant."""
    return Differentiator(table, lambda leaf: table.one if leaf is symbol else table.zero)


class Partials(Differentiator):
    """Derivatives by several symbols, where each is in a part of an expression alone."""

    def __init__(self, table: Exprs) -> None:
        super().__init__(table, lambda _: table.zero)

    def by(self, root: Expr, symbols: Sequence[Expr]) -> list[Expr]:
        """The derivatives by `symbols`: what `partial` gives for each."""
        zero, one = self._table.zero, self._table.one
        holds = {s: 1 << i for i, s in enumerate(symbols)}

        def held(e: Expr) -> int:
            found = 0
            for a in e.args:
                found |= holds[a]
            return found

        fold(root, holds, held)
        found = []
        for i, s in enumerate(symbols):
            slopes = {s: one}
            for e, held_here in holds.items():
                if held_here >> i & 1 and e.args:
                    slopes[e] = self._by_arguments(e, [slopes.get(a, zero) for a in e.args])
            found.append(slopes.get(root, zero))
        return found


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
    by_exponent = t.mul(e, t.call("log", base))
    if base.is_const:
        return by_base, by_exponent
    # 0^x stays 0 while x changes, though the logarithm has no value there.
    return by_base, t.if_(t.equal(base, t.zero), t.zero, by_exponent)


# Slopes of elementary functions --------------------------------------------------------------


def _both(make: Callable[[Exprs, Expr, Expr], Expr]) -> tuple[Callable[..., Any], ...]:
    """An operator of terms, and the same with its operands exchanged."""

    def direct(a: _Term, b: _Term | float) -> _Term:
        return _Term(a.t, make(a.t, a.e, _expression(a.t, b)))

    def exchanged(a: _Term, b: _Term | float) -> _Term:
        return _Term(a.t, make(a.t, _expression(a.t, b), a.e))

    return direct, exchanged


class _Term:
    """An expression with operators, as the formulas of `runtime.elementary` take them."""

    __slots__ = ("e", "t")

    def __init__(self, t: Exprs, e: Expr) -> None:
        self.t, self.e = t, e

    __add__, __radd__ = _both(Exprs.add)
    __sub__, __rsub__ = _both(Exprs.sub)
    __mul__, __rmul__ = _both(Exprs.mul)
    __truediv__, __rtruediv__ = _both(Exprs.div)
    __lt__, __gt__ = _both(Exprs.less)
    __le__, __ge__ = _both(Exprs.less_equal)

    def __neg__(self) -> _Term:
        return _Term(self.t, self.t.neg(self.e))


class _Functions:
    """The functions that these formulas use."""

    def __init__(self, t: Exprs) -> None:
        self._t = t

    def __getattr__(self, name: str) -> Callable[..., _Term]:
        t = self._t
        return lambda *x: _Term(t, t.call(name, *(_expression(t, a) for a in x)))

    def where(self, condition: _Term, then: _Term | float, otherwise: _Term | float) -> _Term:
        t = self._t
        return _Term(t, t.if_(condition.e, _expression(t, then), _expression(t, otherwise)))


def _expression(t: Exprs, value: _Term | float) -> Expr:
    return value.e if isinstance(value, _Term) else t.const(value)


def _call_slopes(t: Exprs, e: Expr) -> tuple[Expr, ...]:
    slopes = elementary.TABLE[e.data].slopes
    return (t.zero,) * len(e.args) if slopes is None else formula(t, slopes, *e.args)


def formula(t: Exprs, made: elementary.Formula, *args: Expr) -> tuple[Expr, ...]:
    """The values of a formula of `runtime.elementary`."""
    found = made(_Functions(t), *(_Term(t, a) for a in args))
    return tuple(_expression(t, s) for s in (found if isinstance(found, tuple) else (found,)))
