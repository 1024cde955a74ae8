"""Writes every formula in the symbols that are computed.

In:   the aliases of the sorted model
Out:  `Aliases`, which rewrites expressions, messages and actions

Example, with the aliases  w = der(phi),  frame.f = -force:

    assert(w < 10)       ->  assert(der(phi) < 10)
    reinit(w, -e*w)      ->  reinit(der(phi), -e*der(phi))
    frame.f*2            ->  -force*2
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.ir.calculus import time_derivative
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Op, fold
from planarc.ir.sorted import Alias

_SYMBOL = Op.SYMBOL  # as in `ir.expr`


class Aliases:
    """The aliases by name, and rewriting by them."""

    def __init__(self, dae: Dae, aliases: Iterable[Alias]) -> None:
        self._table = dae.table
        self._by_name = {a.name: a for a in aliases}
        self._rewritten: dict[Expr, Expr] = {}  # each node once, for all expressions
        constant = {p.name for p in dae.parameters} | {d.name for d in dae.discretes}
        self._differentiate = time_derivative(dae.table, constant.__contains__)

    def target(self, symbol: Expr) -> Expr:
        """The computed expression that a symbol stands for."""
        sign, e = 1, symbol
        while e.op is _SYMBOL and e.data[0] in self._by_name:
            name, order = e.data
            alias = self._by_name[name]
            sign, e = sign * alias.sign, alias.target
            for _ in range(order):  # der(x) of x = der(y) is der(der(y))
                e = self._differentiate(e)
        return e if sign > 0 else self._table.neg(e)

    def __call__(self, root: Expr) -> Expr:
        return fold(root, self._rewritten, self._of)

    def _of(self, e: Expr) -> Expr:
        if e.args:
            return self._table.rebuild(e, tuple(map(self._rewritten.__getitem__, e.args)))
        return self.target(e) if e.op is _SYMBOL else e
