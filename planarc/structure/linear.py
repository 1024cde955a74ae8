"""The dependence of an equation on unknowns: coefficients, degrees, the solved form.

An equation may be solved for an unknown by the tree's own rule when it is affine in
it and the coefficient never vanishes: `0 = a + c*x` gives `x = -a/c`.

Example: 0 = ta + tb - sin(phi)*f + m*(a - g), unknowns ta, phi, f, a

    ta: 1     f: -sin(phi)     a: m     phi: None, not affine
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from operator import attrgetter

from planarc.ir.expr import Expr, Exprs, Op, Substitution, fold

_EMPTY: frozenset[Expr] = frozenset()
# Where it counts: an enumeration looks up its members by a function.
_SYMBOL, _ADD, _NEG, _MUL = Op.SYMBOL, Op.ADD, Op.NEG, Op.MUL
_number = attrgetter("id")
_NESTING = 40  # depth from which if-expressions count as not affine


class Contents:
    """The unknown symbols below a node, remembered for all nodes of a model; and the factors of
    those in equations, which several passes ask for."""

    def __init__(self, is_unknown: Callable[[str], bool]) -> None:
        self._is_unknown = is_unknown
        self._memo: dict[Expr, frozenset[Expr]] = {}
        self.factors: dict[Expr, Mapping[Expr, Expr | None]] = {}

    def __call__(self, root: Expr) -> frozenset[Expr]:
        known = self._memo.get(root)
        return fold(root, self._memo, self._of) if known is None else known

    def _of(self, e: Expr) -> frozenset[Expr]:
        if e.op is _SYMBOL:
            return frozenset((e,)) if self._is_unknown(e.data[0]) else _EMPTY
        inside = _EMPTY
        for a in e.args:
            more = self._memo[a]
            if more and more is not inside:
                inside = inside | more if inside else more
        return inside

    def ordered(self, root: Expr) -> list[Expr]:
        """The unknown symbols below a node, by order of creation."""
        return sorted(self(root), key=_number)


def coefficients(table: Exprs, contents: Contents, root: Expr) -> Mapping[Expr, Expr | None]:
    """The factor of each unknown symbol in `root`; None where it is not affine in it."""
    known = contents.factors.get(root)
    if known is None:
        found = _coefficients(table, contents, root, 0)
        known = contents.factors[root] = {
            symbol: None if factor is None or symbol in contents(factor) else factor
            for symbol, factor in found.items()
        }
    return known


def _coefficients(
    table: Exprs, contents: Contents, root: Expr, depth: int
) -> dict[Expr, Expr | None]:
    parts: dict[Expr, list[Expr] | None] = {}
    bent: set[Expr] = set()  # symbols known to be curved: nothing more is to be found of them

    def curved(symbols: Collection[Expr]) -> None:
        bent.update(symbols)
        parts.update(dict.fromkeys(sorted(symbols)))

    stack: list[tuple[Expr, Expr]] = [(root, table.one)]
    while stack:
        e, factor = stack.pop()
        if e.op is _SYMBOL:
            if contents(e) and (present := parts.setdefault(e, [])) is not None:
                present.append(factor)
            continue
        inside = contents(e)
        if not inside or bent.issuperset(inside):
            continue
        op = e.op
        if op is _ADD:
            stack.extend([(a, factor) for a in reversed(e.args)])
        elif op is _NEG:
            stack.append((e.args[0], table.neg(factor)))
        elif op is _MUL:
            for i, a in reversed(list(enumerate(e.args))):
                if contents(a):
                    stack.append((a, table.mul(factor, *e.args[:i], *e.args[i + 1 :])))
        elif op is Op.DIV:
            curved(contents(e.args[1]))
            stack.append((e.args[0], table.div(factor, e.args[1])))
        elif op is Op.IF and depth < _NESTING:
            curved(contents(e.args[0]))
            if bent.issuperset(inside):  # branches of numbers, as in a table
                continue
            for symbol, part in _branches(table, contents, e, depth).items():
                present = parts.setdefault(symbol, [])
                if part is None:
                    curved((symbol,))
                elif present is not None:
                    present.append(table.mul(factor, part))
        else:
            curved(contents(e))
    return {
        s: None if p is None else p[0] if len(p) == 1 else table.add(*p) for s, p in parts.items()
    }


def _branches(table: Exprs, contents: Contents, e: Expr, depth: int) -> dict[Expr, Expr | None]:
    condition, then, otherwise = e.args
    a = _coefficients(table, contents, then, depth + 1)
    b = _coefficients(table, contents, otherwise, depth + 1)
    merged: dict[Expr, Expr | None] = {}
    for symbol in (*a, *(s for s in b if s not in a)):
        x, y = a.get(symbol, table.zero), b.get(symbol, table.zero)
        merged[symbol] = None if x is None or y is None else table.if_(condition, x, y)
    return merged


def solve_affine(
    table: Exprs, contents: Contents, left: Expr, right: Expr, unknown: Expr, factor: Expr
) -> Expr:
    """The value of `unknown` from left = right; `factor` is its coefficient in left - right."""
    if left is unknown and factor is table.one and unknown not in contents(right):
        return right
    if right is unknown and factor.is_const and factor.data == -1 and unknown not in contents(left):
        return left
    residual = table.sub(left, right)
    rest = _without(table, residual, unknown, factor)
    if rest is None:
        rest = Substitution(table, {unknown: table.zero})(residual)
    if factor.is_const and factor.data == -1:
        return rest
    return table.div(_negative(table, rest), factor)


def _negative(table: Exprs, e: Expr) -> Expr:
    """-e with the sign inside a sum: a + b for -(-a - b)."""
    if e.op is Op.ADD:
        return table.add(*(table.neg(a) for a in e.args))
    return table.neg(e)


def _without(table: Exprs, residual: Expr, unknown: Expr, factor: Expr) -> Expr | None:
    """The sum without its one term factor*unknown, when that stands in it as such."""
    if residual.op is not Op.ADD:
        return None
    term = table.mul(factor, unknown)
    rest = [a for a in residual.args if a is not term]
    return table.add(*rest) if len(rest) == len(residual.args) - 1 else None


class Degrees:
    """The degree of expressions in the unknowns of a block: 0, 1 (affine) or 2 (curved)."""

    def __init__(self, unknowns: Mapping[Expr, int]) -> None:
        self._of_symbol = dict(unknowns)
        self._memo: dict[Expr, int] = {}

    def define(self, symbol: Expr, value: Expr) -> None:
        """`symbol` stands for `value` from now on; it is an unknown of the block even where this is
        a number, and no number of its matrix."""
        self._of_symbol[symbol] = max(1, self(value))

    def __call__(self, root: Expr) -> int:
        return fold(root, self._memo, self._degree)

    def _degree(self, e: Expr) -> int:
        op = e.op
        if op is _SYMBOL:
            return self._of_symbol.get(e, 0)
        degrees = [*map(self._memo.__getitem__, e.args)]
        highest = max(degrees, default=0)
        if highest == 0 or op is _ADD or op is _NEG:
            return highest
        match op:
            case Op.MUL:
                return min(sum(degrees), 2)
            case Op.DIV:
                return 2 if degrees[1] else degrees[0]
            case Op.IF:
                return 2 if degrees[0] else highest
        return 2
