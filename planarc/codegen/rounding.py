"""The size of rounding errors in the residuals of a linear block.

In:   the block
Out:  formulas for the sum of the sizes of all terms that make each residual, inner
      unknowns put in: rounding errors are a small part of it

Example, tear z:

    a = g - r*z            |g| + |r|*|z|
    residual m*a - f       |m|*(|g| + |r|*|z|) + |f|

Residuals of a good solution are some 1e-15 of that, in whatever units they are.

Reference: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM
           2002, section 3.3 (running error analysis).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from planarc.codegen.statements import is_trivial
from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.ir.sorted import Block

Steps = tuple[tuple[Expr, Expr], ...]  # (symbol, value), in order


def size_terms(table: Exprs, block: Block) -> tuple[Steps, tuple[Expr, ...]]:
    """Measures of the rounding errors of the residuals: sums of the sizes of all terms.

    Steps give each inner unknown's, then come those of the residuals.
    """
    known: dict[Expr, Expr] = {tear: table.call("abs", tear) for tear in block.tears}
    steps: list[tuple[Expr, Expr]] = []
    for a in block.inner:
        size = _size(table, a.value, known)
        if not is_trivial(size):
            steps.append((table.symbol(f"$size[{a.target}]"), size))
            size = steps[-1][0]
        known[a.target] = size
    return tuple(steps), tuple(_size(table, r.value, known) for r in block.residuals)


def _size(table: Exprs, root: Expr, known: Mapping[Expr, Expr]) -> Expr:
    """The sum of the sizes of the terms; what does not depend on the unknowns is one."""
    found: dict[Expr, Expr] = {}  # of what depends on the unknowns
    for e in postorder((root,)):
        if e in known:
            found[e] = known[e]
        elif any(a in found for a in e.args):
            found[e] = _size_of(table, e, [found.get(a) or _absolute(table, a) for a in e.args])
    return found.get(root) or _absolute(table, root)


def _absolute(table: Exprs, e: Expr) -> Expr:
    return table.const(abs(e.data)) if e.is_const else table.call("abs", e)


def _size_of(table: Exprs, e: Expr, parts: Sequence[Expr]) -> Expr:
    match e.op:
        case Op.ADD:
            return table.add(*parts)
        case Op.NEG:
            return parts[0]
        case Op.MUL:
            return table.mul(*parts)
        case Op.DIV:
            return table.div(*parts)
        case Op.IF:
            return table.if_(e.args[0], parts[1], parts[2])
    return _absolute(table, e)
