"""The sign of an expression, whatever its variables are.

The sign decides whether an equation may be solved by a division: only a factor that
can never vanish may be divided by. A parameter can be set to any value within its
`min`, so `m` with `min = 0` may vanish, `T` with `min = 1e-6` may not.
"""

from __future__ import annotations

from planarc.ir.dae import Parameter
from planarc.ir.expr import Expr, Op, fold
from planarc.runtime import elementary
from planarc.runtime.elementary import Sign

_NOT_NEGATIVE = Sign.ZERO | Sign.PLUS


class Signs:
    """Answers for one model, remembered."""

    def __init__(self, parameters: tuple[Parameter, ...]) -> None:
        self._parameters = {p.name: p for p in parameters}
        self._memo: dict[Expr, int] = {}

    def __call__(self, root: Expr) -> int:
        return fold(root, self._memo, self._of)

    def never_zero(self, e: Expr) -> bool:
        return not self(e) & Sign.ZERO

    def _of(self, e: Expr) -> int:
        args = [self._memo[a] for a in e.args]
        match e.op:
            case Op.CONST:
                return _of_number(e.data)
            case Op.SYMBOL:
                return self._of_parameter(e) if e.name in self._parameters else Sign.ANY
            case Op.NEG:
                return _negative(args[0])
            case Op.ADD:
                return _sum(args)
            case Op.MUL | Op.DIV:
                # A denominator that may vanish makes no value; the quotient's sign stands.
                product = args[0]
                for a in args[1:]:
                    product = _product(product, a)
                return product
            case Op.POW:
                return _power(args[0], e.args[1])
            case Op.IF:
                return args[1] | args[2]
            case Op.CALL:
                row = elementary.TABLE[e.data]
                return args[0] if row.odd else row.sign
        return Sign.ANY

    def _of_parameter(self, e: Expr) -> int:
        p = self._parameters[e.name]
        if p.constant and p.value.is_const:
            return _of_number(p.value.data)
        sign = Sign.ANY
        if p.minimum is not None and p.minimum.is_const and p.minimum.data >= 0:
            sign &= Sign.PLUS if p.minimum.data > 0 else _NOT_NEGATIVE
        if p.maximum is not None and p.maximum.is_const and p.maximum.data <= 0:
            sign &= Sign.MINUS if p.maximum.data < 0 else Sign.MINUS | Sign.ZERO
        return sign or Sign.ANY


def _of_number(value: float) -> int:
    if value > 0:
        return Sign.PLUS
    return Sign.MINUS if value < 0 else Sign.ZERO if value == 0 else Sign.ANY


def _negative(a: int) -> int:
    turned = a & Sign.ZERO
    if a & Sign.PLUS:
        turned |= Sign.MINUS
    if a & Sign.MINUS:
        turned |= Sign.PLUS
    return turned


def _sum(args: list[int]) -> int:
    union = 0
    for a in args:
        union |= a
    if union & Sign.MINUS and union & Sign.PLUS:
        return Sign.ANY
    if not all(a & Sign.ZERO for a in args):  # one-sided, and one term is off zero
        union &= ~Sign.ZERO
    return union


def _product(a: int, b: int) -> int:
    result = (a | b) & Sign.ZERO
    if a & Sign.PLUS:
        result |= b & ~Sign.ZERO
    if a & Sign.MINUS:
        result |= _negative(b) & ~Sign.ZERO
    return result


def _power(base: int, exponent: Expr) -> int:
    if base == Sign.PLUS:
        return Sign.PLUS
    if not exponent.is_const or exponent.data != int(exponent.data):
        return Sign.ANY
    if exponent.data % 2:
        return base
    return Sign.PLUS | base & Sign.ZERO
