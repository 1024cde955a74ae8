"""An equation solved for an unknown in which it is not affine by its form (`linear`).

In:   a residual and one of its symbols
Out:  the value of the symbol, or None

The residual is multiplied out. What is affine then is solved, for the unknown itself or for a
function in which all of it stands; that is undone, and the next one looked at.

    (x + a)^2 - x^2 = b, a > 0      x = (b - a^2)/(2*a)     affine after all
    exp(x/T) = y                    x = T*log(y)            one function undone
    sqrt(x) = y                     None: x = y^2 forgets y >= 0
    atan2(y, x) = 0                 None: y = 0 forgets x > 0
    asin(x) = y, atan(x) = y        None: forgets the range of y
    x*x = L*L                       None: two branches
    a/x = b                         None: divides by b, which may vanish

So an unknown may stand only inside sums, products, whole powers and the functions whose
`inverse` is defined exactly where there is a solution.

Promises:  an answer is the only solution wherever there is one, and divides by nothing
           that may vanish. It tells whether it is one everywhere: of x = log(y) that is not
           known, and where Newton's method may pass by y < 0 on its way, the equation is better
           left as it is.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import reduce
from math import inf
from typing import TypeAlias

from planarc.core.data import Data
from planarc.ir.calculus import formula
from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.runtime import elementary
from planarc.structure.linear import Contents
from planarc.structure.signs import Signs

_LARGEST = 60  # nodes of an equation that is still looked at
_HIGHEST = 6  # exponent
_MOST = 200  # products of an equation that is multiplied out

#: A product of powers of leaves: of what does not hold the unknown, of itself and functions of it.
Product: TypeAlias = frozenset[tuple[Expr, int]]
#: A sum of products, each with its number. These are exact: 0.1*0.1 - 0.01 is nothing.
Sum: TypeAlias = dict[Product, Fraction]


_TRANSPARENT = frozenset({Op.ADD, Op.NEG, Op.MUL, Op.DIV, Op.POW})


class _NoSum(Exception):
    """An expression that is no sum of such products, or a long one."""


class Answer(Data):
    """The value of an unknown, and whether it is one whatever its other symbols are."""

    value: Expr
    everywhere: bool


class Algebra:
    """Answers for one model."""

    def __init__(self, table: Exprs, contents: Contents, signs: Signs) -> None:
        self._table, self._contents, self._signs = table, contents, signs

    def solve(self, residual: Expr, unknown: Expr) -> Answer | None:
        """What `unknown` is where residual = 0, or None where that is not safe."""
        nodes = postorder((residual,))
        if len(nodes) > _LARGEST or not all(map(_may_hold, self._around(nodes, unknown))):
            return None
        try:
            return self._solve(residual, unknown)
        except (_NoSum, ArithmeticError, ValueError):
            return None

    def _around(self, nodes: Iterable[Expr], unknown: Expr) -> Iterable[Expr]:
        """The nodes that hold the unknown."""
        return (e for e in nodes if e.args and unknown in self._contents(e))

    def _solve(self, residual: Expr, unknown: Expr) -> Answer | None:
        everywhere = True
        while True:
            terms = self._expanded(residual, unknown)
            leaves = {leaf for product in terms for leaf, _ in product}
            moving = [leaf for leaf in leaves if unknown in self._contents(leaf)]
            if len(moving) != 1:
                return None
            (inner,) = moving
            value = self._affine(terms, inner)
            if value is None or inner is unknown:
                return None if value is None else Answer(value, everywhere)
            row, signs = elementary.TABLE[inner.data], self._signs(value)
            if row.inverse is None or not signs & row.sign:  # exp(x) = -1
                return None
            everywhere &= not signs & ~row.sign and row.size == inf
            residual = self._table.sub(inner.args[0], *formula(self._table, row.inverse, value))

    def _expanded(self, e: Expr, unknown: Expr) -> Sum:
        if e.is_const:
            return {frozenset(): Fraction(repr(float(e.data)))}
        if e is unknown or unknown not in self._contents(e):
            return _leaf(e)
        match e.op:
            case Op.CALL:
                return _leaf(e)
            case Op.ADD:
                return _sum(self._expanded(a, unknown) for a in e.args)
            case Op.NEG:
                return _times(_NEGATIVE, self._expanded(e.args[0], unknown))
            case Op.MUL:
                return reduce(_times, (self._expanded(a, unknown) for a in e.args))
            case Op.DIV if unknown not in self._contents(e.args[1]):
                below = e.args[1]
                inverse = (
                    {frozenset(): 1 / Fraction(repr(float(below.data)))}
                    if below.is_const
                    else _leaf(below, -1)
                )
                return _times(self._expanded(e.args[0], unknown), inverse)
            case Op.POW if e.args[1].is_const and e.args[1].data in range(1, _HIGHEST + 1):
                return reduce(_times, [self._expanded(e.args[0], unknown)] * int(e.args[1].data))
        raise _NoSum

    def _affine(self, terms: Sum, leaf: Expr) -> Expr | None:
        """-c0/c1 for c0 + c1*leaf, where c1 never vanishes."""
        parts: tuple[list[Expr], list[Expr]] = ([], [])
        for product, number in terms.items():
            power = dict(product).get(leaf, 0)
            if power not in (0, 1):
                return None
            parts[power].append(self._product(product - {(leaf, 1)}, number if power else -number))
        slope = self._table.add(*parts[1])
        if not self._signs.never_zero(slope):
            return None
        return self._table.div(self._table.add(*parts[0]), slope)

    def _product(self, product: Product, number: Fraction) -> Expr:
        t = self._table
        powers = sorted(product, key=lambda power: power[0].id)
        above, below = (
            [t.pow(leaf, t.const(abs(n))) for leaf, n in powers if n * side > 0] for side in (1, -1)
        )
        return t.div(t.mul(t.const(float(number)), *above), t.mul(*below))


def _may_hold(e: Expr) -> bool:
    """Whether an unknown may stand in the arguments."""
    if e.op is Op.CALL:
        return elementary.TABLE[e.data].inverse is not None
    return e.op in _TRANSPARENT


def _leaf(e: Expr, power: int = 1) -> Sum:
    return {frozenset(((e, power),)): Fraction(1)}


_NEGATIVE: Sum = {frozenset(): Fraction(-1)}


def _sum(sums: Iterable[Sum]) -> Sum:
    found: Sum = {}
    for terms in sums:
        for product, number in terms.items():
            found[product] = found.get(product, Fraction(0)) + number
    if len(found) > _MOST:
        raise _NoSum
    return {product: number for product, number in found.items() if number}


def _times(a: Sum, b: Sum) -> Sum:
    return _sum({_joined(p, q): m * n} for p, m in a.items() for q, n in b.items())


def _joined(a: Product, b: Product) -> Product:
    powers = dict(a)
    for leaf, n in b:
        powers[leaf] = powers.get(leaf, 0) + n
    return frozenset((leaf, n) for leaf, n in powers.items() if n)
