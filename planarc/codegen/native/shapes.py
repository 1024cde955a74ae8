"""Shapes of formulas: what equal ones share, as a number, and the leaves that they differ by.

    L1*c1 + x0, L2*c2 + x1    one shape, leaves (L1, c1, x0) and (L2, c2, x1)
    x*x + y, x*y + z          two shapes: leaves that are the same one count

Numbers are leaves; exponents, functions, truths and time are not. What reads memory or calls back
has no shape.

Promises:  each formula is walked through once, however many ask for it.
"""

from __future__ import annotations

from typing import TypeAlias

from planarc.ir.expr import Expr, Op, below

#: The number of a shape, None for none; the leaves, each once.
Shape: TypeAlias = "tuple[int | None, tuple[Expr, ...]]"

# Where it counts: an enumeration looks up its members by a function.
_POW = Op.POW
LEAVES = frozenset({Op.SYMBOL, Op.PRE, Op.EVENT})
#: What takes values to a value, wherever it stands.
_SHAPED = frozenset(
    {Op.ADD, Op.MUL, Op.NEG, Op.DIV, Op.POW, Op.CALL, Op.LESS, Op.LESS_EQUAL, Op.EQUAL, Op.AND,
     Op.OR, Op.NOT, Op.IF}
)  # fmt: skip


def is_number(e: Expr) -> bool:
    """Whether it is a constant, and no truth."""
    return e.is_const and not isinstance(e.data, bool)


class Shapes:
    """The shapes of a program's formulas."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[object, ...], int] = {}
        self._known: dict[Expr, Shape] = {}

    def __call__(self, formula: Expr) -> Shape:
        known = self._known.get(formula)
        if known is None:
            known = self._known[formula] = self._of(formula)
        return known

    def _of(self, formula: Expr) -> Shape:
        leaves: dict[Expr, int] = {}
        told: list[object] = []
        exponents = set()
        stack = [formula]
        while stack:
            e = stack.pop()
            op, args = e.op, e.args
            if args:
                if op not in _SHAPED:
                    return None, tuple(a for a in below((formula,)) if not a.args)
                told += (op, len(args), e.data)
                if op is _POW and args[1].is_const:  # a whole one is a product
                    told.append(args[1])
                    exponents.add(args[1])
                    stack.append(args[0])
                else:
                    stack += args
            elif op in LEAVES:
                told.append(leaves.setdefault(e, len(leaves)))
            elif is_number(e):
                told.append(-1 - leaves.setdefault(e, len(leaves)))
            else:  # a truth, or time: shared nodes are equal when they are the same
                told.append(e)
        if not exponents.isdisjoint(leaves):
            return None, tuple(leaves)
        return self._numbers.setdefault(tuple(told), len(self._numbers)), tuple(leaves)
