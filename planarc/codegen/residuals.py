"""The residuals of a linear block where all its tears are zero.

In:   a block whose residuals are affine in its tears, inner assignments put in
Out:  steps that give inner unknowns names of their own, and the residuals that use them

Example, tear z:                        at z = 0

    a = g - r*z                         $z[a] := g
    residual  m*a - f                   m*g - f

(A plain symbol is used directly.) With the Jacobian J that is all that solving needs:
residual(z) = residual(0) + J*z.

Promises:  what vanishes with the tears is gone; nothing depends on them any more.
"""

from __future__ import annotations

from planarc.codegen.statements import is_trivial
from planarc.ir.expr import Expr, Exprs, Substitution, below
from planarc.ir.sorted import Block

Steps = tuple[tuple[Expr, Expr], ...]  # (symbol, value), in order


def at_zero(table: Exprs, block: Block) -> tuple[Steps, tuple[Expr, ...]]:
    """The steps, and the residuals that use them."""
    known: dict[Expr, Expr] = dict.fromkeys(block.tears, table.zero)

    def put_in(value: Expr) -> Expr:
        found = {s: known[s] for s in below((value,)) if s in known}
        return Substitution(table, found)(value) if found else value

    steps: list[tuple[Expr, Expr]] = []
    for a in block.inner:
        value = put_in(a.value)
        if not is_trivial(value):
            steps.append((table.symbol(f"$z[{a.target}]"), value))
            value = steps[-1][0]
        known[a.target] = value
    return tuple(steps), tuple(put_in(r.value) for r in block.residuals)
