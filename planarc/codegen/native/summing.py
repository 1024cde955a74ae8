"""Long sums taken apart, so that those of different lengths become loops together.

In:   statements
Out:  statements that do the same operations in the same order, two terms at a time

An elimination in a fixed order has sums of any length, of which no two are equal:

    x := -a*b - c*d - e*f         $sum1 := -a*b - c*d
    y := -g*h - i*j               x := $sum1 - e*f
                                  y := -g*h - i*j

Promises:  values are equal to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.ir.expr import Expr, Exprs, Op, below
from planarc.ir.program import Let

#: What values are made of that may be taken apart: where something is chosen, it stays together.
_PLAIN = frozenset({Op.ADD, Op.MUL, Op.NEG, Op.DIV, Op.SYMBOL, Op.CONST, Op.POW})


class Sums:
    """Taken apart; `kept` are the sums so far, each with the first one of those that it goes on
    with: it may stand in that one's place, which nothing else reads any more."""

    def __init__(self, table: Exprs, kept: dict[Expr, Expr]) -> None:
        self._table, self._kept = table, kept

    def take_apart(self, lets: Sequence[Let]) -> list[Let]:
        return [part for let in lets for part in self._parts(let)]

    def _parts(self, let: Let) -> Iterator[Let]:
        if all(e.op is not Op.ADD or len(e.args) == 2 for e in below((let.value,))):
            yield let
        elif all(e.op in _PLAIN for e in below((let.value,))):
            own: list[Let] = []
            value = self._shortened(let.value, own)
            yield from own
            yield Let(let.target, value)
        else:
            yield let

    def _shortened(self, e: Expr, own: list[Let]) -> Expr:
        if not e.args:
            return e
        args = [self._shortened(a, own) for a in e.args]
        if e.op is not Op.ADD:
            return self._table.node(e.op, tuple(args), e.data)
        sum_, before = args[0], None
        for term in args[1:-1]:
            own.append(Let(self._symbol(before), self._table.node(Op.ADD, (sum_, term))))
            sum_ = before = own[-1].target
        return self._table.node(Op.ADD, (sum_, args[-1]))

    def _symbol(self, before: Expr | None) -> Expr:
        symbol = self._table.symbol(f"$sum{len(self._kept) + 1}")
        self._kept[symbol] = symbol if before is None else self._kept[before]
        return symbol
