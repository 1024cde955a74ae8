"""Where the variables of a function have no value.

In:   two ways through statements, and the condition that chooses between them
Out:  Unset, of both together

A way that ends in an assertion that never holds leaves nothing open.

Example: behind `if x > 1 then y := 1; end if;` the variable y has no value where x <= 1. Whoever
reads it there, or is given it as a result, ends the run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from msgspec import field

from planarc.core.data import Data
from planarc.ir.expr import Expr, Exprs, Op


class Unset(Data):
    """The conditions under which some variables have no value. `over`: nothing comes behind."""

    conditions: Mapping[str, Expr] = field(default_factory=dict)
    over: bool = False

    def having(self, names: Collection[str]) -> Unset:
        """Where some more have a value."""
        if self.conditions.keys().isdisjoint(names):
            return self
        left = {n: c for n, c in self.conditions.items() if n not in names}
        return Unset(left, self.over)

    def _of(self, table: Exprs, name: str, known: Collection[str]) -> Expr:
        if self.over:
            return table.false
        return self.conditions.get(name, table.false if name in known else table.true)


def join(
    table: Exprs,
    condition: Expr,
    then: tuple[Unset, Mapping[str, object]],
    otherwise: tuple[Unset, Mapping[str, object]],
) -> Unset:
    """Both ways in one; `then` is taken where the condition holds. Each with its values."""
    (one, ours), (two, theirs) = then, otherwise
    names = (ours.keys() ^ theirs.keys()) | one.conditions.keys() | two.conditions.keys()
    found = {}
    for name in sorted(names):
        here = table.and_(condition, one._of(table, name, ours))
        there = table.and_(table.not_(condition), two._of(table, name, theirs))
        if (either := table.or_(here, there)) is not table.false:
            found[name] = either
    return Unset(found, one.over and two.over)


def exclude(table: Exprs, path: Expr, condition: Expr) -> bool:
    """Whether two conditions plainly cannot hold together: one asks for what the other denies."""
    asked = {*_parts(path), *_parts(condition)}
    return any(table.not_(part) in asked for part in asked)


def _parts(e: Expr) -> Iterator[Expr]:
    left = [e]
    while left:
        e = left.pop()
        if e.op is Op.AND:
            left += e.args
        else:
            yield e
