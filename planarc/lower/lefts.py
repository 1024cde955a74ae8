"""Left limits of continuous variables that when-clauses ask for.

In:   `pre(u)` at an event
Out:  a discrete variable that follows `u`, and its left limit

At an event `u` may jump with what happens there, as the input of a delay behind another one does;
its left limit is the value before. Each event begins with `$left[1] := u` and its left limit, while
everything is as it was. What is differentiated does not jump but by `reinit`, whose value is put in
last: it is its own left limit.

Reference: Modelica Language Specification 3.6, sections 3.7.5 and 8.6.
"""

from __future__ import annotations

from functools import cached_property

from msgspec import Struct

from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr, Substitution, symbols
from planarc.ir.flatwalk import expressions_of_model, nodes_of
from planarc.lower.scope import Model


class Moving(Struct, dict=True):
    """The variables that a model differentiates."""

    source: flat.FlatModel

    def __call__(self, name: str) -> bool:
        """Whether it is one of them, or an entry of one."""
        return name in self._names or name.rpartition("[")[0] in self._names

    @cached_property
    def _names(self) -> frozenset[str]:
        return frozenset(
            r.name
            for e in nodes_of(expressions_of_model(self.source))
            if isinstance(e, flat.Builtin) and e.function == "der"
            for r in nodes_of(e.arguments)
            if isinstance(r, flat.Reference)
        )


def left_limit(model: Model, symbol: Expr, span: Span) -> Expr:
    """The value of a continuous variable before the event."""
    t = model.table
    if model.is_moving(symbol.name) and not symbol.data[1]:
        return symbol
    known = model.lefts.get(symbol)
    if known is None:
        known = t.symbol(f"{dae.LEFT}[{len(model.lefts) + 1}]")
        model.lefts[symbol] = known
        model.discretes.add(known.name)
        variable = dae.Variable(known.name, dae.Kind.REAL, protected=True, span=span)
        model.auxiliaries.append((variable, dae.Equation(known, symbol, span)))
    return t.if_(t.symbol(dae.INITIAL), symbol, t.pre(known.name))


def left_limits(model: Model, e: Expr, span: Span) -> Expr:
    """An expression with what its variables were before the event."""
    t = model.table
    before: dict[Expr, Expr] = {}
    for symbol in symbols(e):
        if symbol.name in model.discretes:
            before[symbol] = t.pre(symbol.name)
        elif symbol.name not in model.parameters and not symbol.name.startswith("$"):
            before[symbol] = left_limit(model, symbol, span)
    return Substitution(t, before)(e)
