"""The Jacobian of a torn block: residuals by tears, inner assignments put in.

In:   tears, inner assignments, residuals
Out:  `Unrolled`  every non-zero entry as an expression, for small blocks
      `Tangent`   one column as a list of statements with a seed for each tear, for
                  large ones: run once a column, so that code grows with the block
                  only as fast as the block itself

Example, tears (x, y):

    a = sin(x)          d(a)/d(x) = cos(x)
    r1 = a*y            d(r1)/d(x) = cos(x)*y    d(r1)/d(y) = a

Needs:     inner assignments stand in the order of evaluation.
Promises:  only non-zero entries are listed, row by row.
Reference: forward accumulation; A. Griewank and A. Walther, Evaluating Derivatives,
           2nd ed., SIAM 2008, section 3.1.
"""

from __future__ import annotations

from collections.abc import Callable

from planarc.core.data import Data
from planarc.ir.calculus import Differentiator, partial
from planarc.ir.expr import Expr, Exprs, Op, below

#: Entries (tangents of inner assignments and residuals) up to which a block is unrolled.
LARGEST_UNROLLED = 400


class Local(Data):
    """The slopes of one formula by the varying symbols in it."""

    target: Expr | None  # None: a residual
    slopes: tuple[tuple[Expr, Expr], ...]  # (symbol, d(value)/d(symbol))


class Unrolled(Data):
    steps: tuple[tuple[Expr, Expr], ...]  # (temporary, value), in order
    entries: tuple[tuple[int, int, Expr], ...]


class Tangent(Data):
    slopes: tuple[tuple[Expr, Expr], ...]  # (temporary, value), the same for all columns
    seeds: tuple[Expr, ...]  # a symbol for each tear: 1 in its column, else 0
    steps: tuple[tuple[Expr, Expr], ...]
    entries: tuple[Expr, ...]  # of the column, one a residual


def local_slopes(
    table: Exprs,
    tears: tuple[Expr, ...],
    inner: tuple[tuple[Expr, Expr], ...],
    residuals: tuple[Expr, ...],
) -> tuple[Local, ...]:
    """The slopes of all formulas that a residual depends on."""
    varying = set(tears) | {target for target, _ in inner}
    by: dict[Expr, Differentiator] = {}

    def slopes(target: Expr | None, value: Expr) -> Local:
        found = []
        for s in sorted(varying.intersection(below((value,)))):
            if s not in by:
                by[s] = partial(table, s)
            slope = by[s](value)
            if slope is not table.zero:
                found.append((s, slope))
        return Local(target, tuple(found))

    reached = [slopes(None, r) for r in residuals]
    wanted = {s for item in reached for s, _ in item.slopes}
    result: list[Local] = []
    for target, value in reversed(inner):
        if target in wanted:
            item = slopes(target, value)
            wanted.update(s for s, _ in item.slopes)
            result.append(item)
    return (*reversed(result), *reached)


def is_long(tears: tuple[Expr, ...], formulas: tuple[Local, ...]) -> bool:
    """Whether there are more non-zero tangents than are unrolled."""
    reach: dict[Expr, frozenset[int]] = {s: frozenset((i,)) for i, s in enumerate(tears)}
    total = 0
    for f in formulas:
        columns = frozenset[int]().union(*(reach.get(s, frozenset()) for s, _ in f.slopes))
        total += len(columns)
        if total > LARGEST_UNROLLED:
            return True
        if f.target is not None:
            reach[f.target] = columns
    return False


def unroll(
    table: Exprs,
    tears: tuple[Expr, ...],
    formulas: tuple[Local, ...],
    shorten: Callable[[Expr], Expr],
) -> Unrolled:
    """Every entry by itself."""
    tangents: dict[Expr, dict[int, Expr]] = {s: {i: table.one} for i, s in enumerate(tears)}
    steps: list[tuple[Expr, Expr]] = []
    entries: list[tuple[int, int, Expr]] = []
    row = 0
    for f in formulas:
        columns = {j: shorten(e) for j, e in _columns(table, f, tangents).items()}
        if f.target is None:
            entries.extend((row, j, value) for j, value in sorted(columns.items()))
            row += 1
        else:
            tangents[f.target] = {
                j: _held(table, steps, f.target, f"{j}", value) for j, value in columns.items()
            }
    return Unrolled(tuple(steps), tuple(entries))


def _columns(table: Exprs, f: Local, tangents: dict[Expr, dict[int, Expr]]) -> dict[int, Expr]:
    """d(f)/d(tear j) by the chain rule."""
    terms: dict[int, list[Expr]] = {}
    for s, slope in f.slopes:
        for j, tangent in tangents[s].items():
            terms.setdefault(j, []).append(table.mul(slope, tangent))
    sums = {j: table.add(*parts) for j, parts in terms.items()}
    return {j: value for j, value in sums.items() if value is not table.zero}


def _held(
    table: Exprs, steps: list[tuple[Expr, Expr]], target: Expr, mark: str, value: Expr
) -> Expr:
    """A name for a sum or product, so that sums of sums do not grow out."""
    if value.op not in (Op.ADD, Op.MUL, Op.DIV):
        return value
    name = table.symbol(f"$d[{mark}]({target})")
    steps.append((name, value))
    return name


def tangent(table: Exprs, tears: tuple[Expr, ...], formulas: tuple[Local, ...]) -> Tangent:
    """A column as code."""
    seeds = tuple(table.symbol(f"$seed[{i}]({s})") for i, s in enumerate(tears))
    tangents = dict(zip(tears, seeds, strict=True))
    slopes: dict[Expr, Expr] = {}  # by value, so that equal ones are computed once
    steps: list[tuple[Expr, Expr]] = []
    entries: list[Expr] = []

    def name(slope: Expr) -> Expr:
        if not slope.args or (slope.op is Op.NEG and not slope.args[0].args):
            return slope
        return slopes.setdefault(slope, table.symbol(f"$k[{slope.id}]"))

    for f in formulas:
        value = table.add(*(table.mul(name(k), tangents[s]) for s, k in f.slopes if s in tangents))
        if f.target is None:
            entries.append(value)
        elif value is not table.zero:
            tangents[f.target] = _held(table, steps, f.target, "", value)
    named = tuple((symbol, slope) for slope, symbol in slopes.items())
    return Tangent(named, seeds, tuple(steps), tuple(entries))
