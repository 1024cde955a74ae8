"""Expressions as LLVM instructions.

Truth values are bits in registers and 1.0 or 0.0 in the workspace. Both branches of
a condition are computed and one is selected: nothing traps, and what is not selected
may be not a number. A loop stands where its value is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping
from typing import Final

from planarc.codegen.certain import is_hidden, unconditional
from planarc.codegen.native.assembly import BIT, INT, POINTER, REAL, Code, Negative, Value
from planarc.ir.closing import opened, symbols_of
from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.ir.loop import LOST, MOST_TURNS
from planarc.runtime import elementary, external

_TRUNC: Final = "llvm.trunc.f64"


def declarations() -> str:
    """Functions of C's library, and those that the processor or LLVM itself knows."""
    rows = {r.in_native: r.arity for r in elementary.TABLE.values() if r.in_native}
    rows |= {"pow": 2, _TRUNC: 1}
    return "".join(
        f"declare double @{name}({', '.join(['double'] * arity)})"
        f"{'' if name.startswith('llvm.') else ' nounwind willreturn memory(none)'}\n"
        for name, arity in rows.items()
    )


#: Largest whole power that is written as a product.
LARGEST_PRODUCT = 16


BINARY = {
    Op.DIV: Value.__truediv__,
    Op.LESS: Value.__lt__,
    Op.LESS_EQUAL: Value.__le__,
    Op.EQUAL: Value.equals,
}
_CONST, _ADD, _MUL, _NEG = Op.CONST, Op.ADD, Op.MUL, Op.NEG


def real(c: Code, value: Value) -> Value:
    """A truth value as 1.0 or 0.0, a number as it is."""
    if value.type != BIT:
        return value
    if value.text in ("true", "false"):
        return c.constant(float(value.text == "true"), REAL)
    return c.emit(REAL, f"uitofp i1 {value.text} to double")


def bit(c: Code, value: Value) -> Value:
    return value if value.type == BIT else c.emit(BIT, f"fcmp une double {value.text}, 0.0")


def formula(
    c: Code,
    root: Expr,
    leaf: Callable[[Expr], Value],
    varied: Container[Expr] = (),
    known: dict[Expr, Value] | None = None,
) -> Value:
    """Emit the expression; `leaf` gives symbols, time, events, left limits and `varied` numbers.
    What is `known` is not emitted again, and added to.

    What is not a number may not become one by a comparison: where the value hangs on such a
    comparison whatever other conditions say, it is not a number either.
    """
    done: dict[Expr, Value] = {} if known is None else known
    doubtful: list[Expr] = []
    nodes = postorder((root,))
    if done:
        doubtful = [e for e in nodes if e in done and e.op in TRUTHS]
        nodes = [e for e in nodes if e not in done]
    for e in nodes:
        op = e.op
        if not e.args:
            fixed = op is _CONST and e not in varied
            done[e] = _constant(c, e.data) if fixed else leaf(e)
        elif op is _ADD:
            done[e] = c.sum([real(c, done[a]) for a in e.args])
        elif op is _MUL:
            done[e] = c.product([real(c, done[a].kept()) for a in e.args])
        elif op is _NEG:
            done[e] = Negative(real(c, done[e.args[0]]))
        else:
            done[e] = _node(c, e, [done[a].kept() for a in e.args])
            if op in TRUTHS:
                doubtful.append(e)
    found = done[root].kept()
    if doubtful:
        certain = unconditional(root)
        for doubt in [d for e in doubtful if e in certain for d in _doubts(c, e, done)]:
            found = c.select(doubt, math.nan, real(c, found))
    return found


COMPARED = (Op.LESS, Op.LESS_EQUAL, Op.EQUAL)
TRUTHS = (*COMPARED, Op.AND, Op.OR, Op.NOT, Op.IF)


def _doubts(c: Code, e: Expr, done: Mapping[Expr, Value]) -> Iterator[Value]:
    """Bits that say that a truth is not known, since what makes it is not a number."""
    if e.op in COMPARED:
        a, b = (real(c, done[x].kept()) for x in e.args)
        yield c.emit(BIT, f"fcmp uno {a.type} {a.text}, {b.text}")
    elif is_doubtful(e) and done[e.args[0]].type == REAL:
        yield done[e.args[0]].is_nan()


def is_doubtful(e: Expr) -> bool:
    """Whether a truth may be one that is not known."""
    asked = e.args[0]
    return e.op in COMPARED or asked.op is Op.LOOP or (asked.op is Op.SYMBOL and is_hidden(asked))


def _constant(c: Code, value: float | bool) -> Value:
    if isinstance(value, bool):
        return Value(c, BIT, "true" if value else "false")
    return c.constant(value, REAL)


def _node(c: Code, e: Expr, args: list[Value]) -> Value:
    match e.op:
        case Op.AND | Op.OR:
            a, b = (bit(c, x) for x in args)
            return a & b if e.op is Op.AND else a | b
        case Op.NOT:
            return ~bit(c, args[0])
        case Op.IF:
            return _choice(c, args)
    numbers = [real(c, x) for x in args]
    match e.op:
        case Op.DIV | Op.LESS | Op.LESS_EQUAL | Op.EQUAL:
            return BINARY[e.op](*numbers)
        case Op.POW:
            return _power(c, e.args[1], numbers)
        case Op.CALL:
            return call_function(c, e.data, numbers)
        case Op.PAST:
            frame = Value(c, POINTER, "%frame")
            delay, order = (c.constant(n, INT) for n in e.data)
            return c.call(REAL, "pc_past", frame, delay, order, numbers[0])
        case Op.APPLY:
            return _external(c, e, numbers)
        case Op.LOOP:
            return _loop(c, e, numbers)
    raise AssertionError(f"no code for {e.op!r}")


def _external(c: Code, e: Expr, numbers: list[Value]) -> Value:
    """A call back to Python: such functions are called at events."""
    function, output, wrt = e.data
    if wrt:
        from planarc.codegen.refusal import NotDifferentiable

        raise NotDifferentiable(function)
    row = c.place(REAL, len(numbers))
    for i, number in enumerate(numbers):
        row.store(number, i)
    places = [c.constant(n, INT) for n in (external.INDEX[function], output, len(numbers))]
    return c.call(REAL, "pc_external", *places, row)


def _loop(c: Code, e: Expr, numbers: list[Value]) -> Value:
    """A value behind the last turn, or whether the loop ended (`ir.loop`)."""
    loop, output = e.data
    table = Exprs()
    symbols = symbols_of(table, loop)
    condition, following = opened(table, loop, symbols)
    carried = [c.variable(n) for n in numbers[: loop.carried]]
    turns, ended = c.variable(0, INT), c.variable(LOST)
    test, body, late, lost, over, behind = (c.label() for _ in range(6))
    c.enter(test)
    values = (*(v.get() for v in carried), *numbers[loop.carried :])
    known = dict(zip(symbols, values, strict=True))
    goes_on = formula(c, condition, known.__getitem__, known=known)
    if goes_on.type == REAL:
        c.leave(goes_on.is_nan(), lost)
    c.branch(bit(c, goes_on), body, over)
    c.begin(body)
    turns.set(turns.get() + 1)
    c.leave(turns.get() > MOST_TURNS, late)
    found = [real(c, formula(c, f, known.__getitem__, known=known)) for f in following]
    for variable, value in zip(carried, found, strict=True):
        variable.set(value)
    c.jump(test)
    wanted = ended if output == loop.ended else carried[output]
    c.begin(late)
    ended.set(0.0)
    c.enter(lost)
    if wanted is not ended:
        wanted.set(math.nan)
    c.jump(behind)
    c.begin(over)
    ended.set(1.0)
    c.enter(behind)
    return wanted.get()


def _choice(c: Code, args: list[Value]) -> Value:
    condition, then, otherwise = bit(c, args[0]), args[1], args[2]
    if then.type != otherwise.type:
        then, otherwise = real(c, then), real(c, otherwise)
    return c.select(condition, then, otherwise)


def _power(c: Code, exponent: Expr, numbers: list[Value]) -> Value:
    n = whole_power(exponent)
    if not n:
        return c.call(REAL, "pow", *numbers)
    product = _product(numbers[0], abs(n))
    return product if n > 0 else c.constant(1.0, REAL) / product


def whole_power(exponent: Expr) -> int:
    """The power that is written as a product, or 0."""
    if exponent.is_const and float(exponent.data).is_integer():
        n = int(exponent.data)
        return n if abs(n) <= LARGEST_PRODUCT else 0
    return 0


def _product(x: Value, n: int) -> Value:
    """x^n by squaring."""
    if n == 1:
        return x
    if n % 2:
        return _product(x, n - 1) * x
    half = _product(x, n // 2)
    return half * half


class _Functions:
    """The functions that formulas of `runtime.elementary` use."""

    def __init__(self, c: Code) -> None:
        self._c = c
        self.where = c.select

    def __getattr__(self, name: str) -> Callable[..., Value]:
        return lambda *x: call_function(self._c, name, [self._c.constant(a, REAL) for a in x])

    def trunc(self, x: Value) -> Value:
        return self._c.call(REAL, _TRUNC, x)


def call_function(c: Code, function: str, a: list[Value]) -> Value:
    row = elementary.TABLE[function]
    if row.in_native:
        return c.call(REAL, row.in_native, *a)
    assert row.built is not None
    found: Value = row.built(_Functions(c), *a)
    return found
