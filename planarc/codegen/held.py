"""Values that change at events only, and not between them.

In:   a sorted model
Out:  `Held`, which says of a variable, or of a formula, whether it is held

Held are parameters, what when-clauses set, left limits, stored truths of relations, and all that
is computed from these alone. A discrete variable with an equation need not be: `noEvent(x > 0)` is
another truth from one row to the next.
"""

from __future__ import annotations

from planarc.ir.dae import PHASE, set_by_whens
from planarc.ir.expr import Expr, Op, fold
from planarc.ir.sorted import Assignment, SortedDae

_ALWAYS = (Op.CONST, Op.PRE, Op.EVENT)


class Held:
    def __init__(self, sorted: SortedDae) -> None:
        dae = sorted.dae
        self.names = {p.name for p in dae.parameters} | set_by_whens(dae.whens)
        self.names |= {v.name for v in dae.discretes if v.name.startswith(PHASE)}  # never change
        steps = [step for level in sorted.levels for step in level.steps]
        assigned = [a for a in (*sorted.discrete, *steps) if isinstance(a, Assignment)]
        found = -1
        while found < len(self.names):  # discrete equations and others need each other
            found = len(self.names)
            self.names.update(
                a.target.name for a in assigned if a.target.order == 0 and self(a.value)
            )

    def __call__(self, value: Expr) -> bool:
        """Whether a formula is held."""
        memo: dict[Expr, bool] = {}

        def of(e: Expr) -> bool:
            if e.op is Op.SYMBOL:
                return e.order == 0 and e.name in self.names
            made = bool(e.args) and all(memo[a] for a in e.args)
            return made or e.op in _ALWAYS or _is_watched(e)

        return fold(value, memo, of)


def _is_watched(e: Expr) -> bool:
    """Whether a relation tells each time that this function rounds to another number: it is
    `floor(0.5*(x + phase))`, as `lower.rounding` writes it."""
    if e.op is not Op.CALL or e.data != "floor" or e.args[0].op is not Op.MUL:
        return False
    terms = [t for factor in e.args[0].args for t in (factor, *factor.args)]
    return any(t.is_symbol and t.name.startswith(f"{PHASE}[") for t in terms)
