"""Parts of formulas that parameters alone make: computed once, before the run.

In:   the formulas of what moves; the names of parameters and constant unknowns
Out:  the largest such parts, each with its symbol `$p1`, `$p2`, ...

Example:

    tau = -m*g*(L/2)*sin(phi)        $p1 := L/2, tau = -m*g*$p1*sin(phi)
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.codegen.statements import is_trivial
from planarc.ir.expr import Expr, Exprs, postorder


def name_parts(table: Exprs, formulas: Iterable[Expr], names: set[str]) -> dict[Expr, Expr]:
    """The parts and their symbols, in the order of evaluation."""
    constant: set[Expr] = set()
    found: dict[Expr, None] = {}
    roots = list(formulas)
    for e in postorder(roots):
        if not e.args:
            if e.is_const or (e.is_symbol and e.order == 0 and e.name in names):
                constant.add(e)
        elif constant.issuperset(e.args):
            constant.add(e)
        elif not constant.isdisjoint(e.args):
            for a in e.args:
                if a in constant and not is_trivial(a):
                    found[a] = None
    found.update((e, None) for e in roots if e in constant and not is_trivial(e))
    return {e: table.symbol(f"$p{i}") for i, e in enumerate(found, 1)}
