"""The residuals of a linear block: where all its tears are zero, and how exact they can be.

In:   a block whose residuals are affine in its tears, inner assignments put in
Out:  steps that give inner unknowns names of their own, and the residuals that use them:
      where all tears are zero, or as the sums of the sizes of all their terms

Example, tear z:                        at z = 0                    sizes

    a = g - r*z                         $z[a] := g                  $size[a] := |g| + |r|*|z|
    residual  m*a - f                   m*g - f                     |m|*$size[a] + |f|

(A plain symbol is used directly.) With the Jacobian J the first is all that solving needs:
residual(z) = residual(0) + J*z. Rounding errors are a small part of the second: residuals of a
good solution are some 1e-15 of that, in whatever units they are.

Promises:  what vanishes with the tears is gone from the first; nothing depends on them any more.
Reference: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM
           2002, section 3.3 (running error analysis).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from planarc.codegen.statements import is_trivial
from planarc.ir.expr import Expr, Exprs, Op, Substitution, below, postorder
from planarc.ir.sorted import Block

Steps = tuple[tuple[Expr, Expr], ...]  # (symbol, value), in order


def at_zero(table: Exprs, block: Block) -> tuple[Steps, tuple[Expr, ...]]:
    """The steps, and the residuals that use them."""
    known: dict[Expr, Expr] = dict.fromkeys(block.tears, table.zero)

    def put_in(value: Expr) -> Expr:
        found = {s: known[s] for s in below((value,)) if s in known}
        return Substitution(table, found)(value) if found else value

    return _follow(table, block, known, "z", put_in)


def size_terms(table: Exprs, block: Block) -> tuple[Steps, tuple[Expr, ...]]:
    """Measures of the rounding errors of the residuals: sums of the sizes of all terms."""
    known: dict[Expr, Expr] = {tear: table.call("abs", tear) for tear in block.tears}
    return _follow(table, block, known, "size", lambda value: _size(table, value, known))


def _follow(
    table: Exprs, block: Block, known: dict[Expr, Expr], mark: str, of: Callable[[Expr], Expr]
) -> tuple[Steps, tuple[Expr, ...]]:
    """What `of` makes of each formula, through the inner unknowns to the residuals."""
    steps: list[tuple[Expr, Expr]] = []
    for a in block.inner:
        value = of(a.value)
        if not is_trivial(value):
            steps.append((table.symbol(f"${mark}[{a.target}]"), value))
            value = steps[-1][0]
        known[a.target] = value
    return tuple(steps), tuple(of(r.value) for r in block.residuals)


def _size(table: Exprs, root: Expr, known: Mapping[Expr, Expr]) -> Expr:
    """The sum of the sizes of the terms; what does not depend on the unknowns is one."""
    found: dict[Expr, Expr] = {}  # of what depends on the unknowns
    for e in postorder((root,)):
        if e in known:
            found[e] = known[e]
        elif not found.keys().isdisjoint(e.args):
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
