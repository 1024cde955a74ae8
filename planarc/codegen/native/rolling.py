"""Statements that follow each other again and again, as loops.

In:   a statement list
Out:  the same list, where runs of equal groups are one `Roll` each

Equal parts give equal statements that differ by what they read and set alone. Three
rods in a row:

    x1 := x0 + L1*c1        for t in 0, 1, 2:
    y1 := y0 + L1*s1            (x1, x2, x3)[t] := (x0, x1, x2)[t] + (L1, L2, L3)[t]*...
    x2 := x1 + L2*c2   ->       (y1, y2, y3)[t] := ...
    y2 := y1 + L2*s2
    x3 := ...

so that LLVM compiles a group once. The order of statements stays, and with it each value
to the last bit. Where code shall be small, as in files that leave the house, equal statements
are brought together first (`roll_gathered`), and long sums may be taken apart (`summing`): each
value stays as it is.

Promises:  groups are equal in operations, exponents and functions, in which leaves are the
           same one, and in which have slots. Numbers are leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cache, partial
from itertools import accumulate, groupby
from typing import TypeAlias

from planarc.codegen.certain import is_hidden
from planarc.codegen.native.shapes import LEAVES, Shapes
from planarc.codegen.native.summing import Sums
from planarc.core.data import Data
from planarc.ir.expr import Expr, below
from planarc.ir.program import Let, Statement

#: Lists below this length are left as they are: compiled straight they run a little faster. Of
#: those that run seldom, only the shortest ones are.
SHORTEST, SHORTEST_SELDOM = 200, 24
#: A run is rolled that has so many groups, and saves so many statements.
FEWEST, LEAST = 2, 12
#: Groups are not longer, and begin at one of so many next statements that equal the first.
_LONGEST, _TRIED = 400, 8
#: What is tried where equal statements are brought together: loops of so many times stay as they
#: are.
_ALL_APART = (1 << 30,)
_KEPT = (6, *_ALL_APART)
#: Sums are taken apart in lists that leave so many operations, where that leaves less than this
#: part of them.
_WORTH, _APART = 10000, 0.8
#: What a loop costs in operations, and a place in its table.
_LOOP, _ENTRY = 8, 0.2
#: Statements are brought together where that leaves less than this part of their operations: what
#: is in registers otherwise goes through memory then.
_PART = 0.7

Column = tuple[Expr, ...]
#: Where a run begins, the statements of a group, and how often the group stands there.
_Run: TypeAlias = "tuple[int, int, int]"


class Roll(Data):
    """`body` is the first group; columns say, time by time, what stands in its place."""

    statements: tuple[Let, ...]  # as they were
    body: tuple[Let, ...]
    targets: tuple[Column, ...]  # of each statement
    leaves: tuple[tuple[Column, ...], ...]  # of each statement, those of the first time first


def is_one(column: Column) -> bool:
    """Whether the same leaf stands there each time."""
    return column.count(column[0]) == len(column)


def roll(
    statements: Sequence[Statement],
    home: Callable[[Expr], int],
    seldom: bool = False,
    shapes: Shapes | None = None,
) -> Sequence[Statement | Roll]:
    """The statements, rolled where they repeat themselves. `home` tells memories apart, of which a
    value is in one each time; `shapes` are those that the program's lists share."""
    if len(statements) < (SHORTEST_SELDOM if seldom else SHORTEST):
        return statements
    kinds, leaves = _kinds(statements, home, shapes or Shapes())
    return _rolled_in(statements, leaves, _runs(kinds, [1] * len(statements)))


def roll_gathered(
    statements: Sequence[Statement],
    home: Callable[[Expr], int],
    place: Callable[[Expr], Hashable],
    shapes: Shapes | None = None,
    sums: Sums | None = None,
) -> Sequence[Statement | Roll]:
    """As `roll`, with equal statements brought together first (`gathering`), in the order that
    leaves least to compile. `place` tells where a value is kept: what reads there stays behind
    what sets it. Blocks stay where they are. `sums` are taken apart where that pays."""
    out: list[Statement | Roll] = []
    for is_let, found in groupby(statements, lambda s: isinstance(s, Let)):
        listed = [*found]
        rolled = is_let and len(listed) >= SHORTEST_SELDOM
        out += (
            _smallest(
                [s for s in listed if isinstance(s, Let)], home, place, shapes or Shapes(), sums
            )
            if rolled
            else listed
        )
    return out


def _smallest(
    lets: Sequence[Let],
    home: Callable[[Expr], int],
    place: Callable[[Expr], Hashable],
    shapes: Shapes,
    sums: Sums | None,
) -> Sequence[Statement | Roll]:
    whole, left = _gathered(lets, home, place, shapes, _KEPT)
    if sums is None or left < _WORTH:
        return whole
    apart = sums.take_apart(lets)
    found, cost = _gathered(apart, home, place, shapes, _ALL_APART)
    return found if cost < _APART * left else whole


def _gathered(
    lets: Sequence[Let],
    home: Callable[[Expr], int],
    place: Callable[[Expr], Hashable],
    shapes: Shapes,
    kept: Sequence[int],
) -> tuple[Sequence[Statement | Roll], float]:
    """The statements, and about the instructions that are left."""
    from planarc.codegen.native.gathering import gather

    kinds, leaves = _kinds(lets, home, shapes)
    of_kind: dict[int, int] = {}
    for kind, let in zip(kinds, lets, strict=True):
        if kind not in of_kind:
            of_kind[kind] = operations(let)
    weights = [of_kind[kind] for kind in kinds]
    as_written: Sequence[int] = range(len(lets))
    straight, first = _runs(kinds, [1] * len(lets)), _runs(kinds, weights)
    best, order, least = first, as_written, _cost(weights, leaves, first)
    before = _before(lets, leaves, place)
    for fewest in kept:
        units = _units(len(lets), first, fewest)
        unit = [u for u, members in enumerate(units) for _ in members]
        of_units = [kinds[m[0]] if len(m) == 1 else -u for u, m in enumerate(units, 1)]
        ahead = [
            list(dict.fromkeys(unit[b] for i in members for b in before[i] if unit[b] != u))
            for u, members in enumerate(units)
        ]
        tried = [i for u in gather(of_units, ahead) for i in units[u]]
        told, of_tried = [weights[i] for i in tried], [leaves[i] for i in tried]
        found = _runs([kinds[i] for i in tried], told)
        if (cost := _cost(told, of_tried, found)) < least:
            best, order, least = found, tried, cost
    cost = _cost(weights, leaves, straight)
    if least >= _PART * cost:
        best, order, least = straight, as_written, cost
    return _rolled_in([lets[i] for i in order], [leaves[i] for i in order], best), least


def _units(count: int, runs: Sequence[_Run], fewest: int) -> list[range]:
    """The statements by their places; those of loops of so many times and more stay together."""
    units: list[range] = []
    at = 0
    for first, length, times in (*runs, (count, 0, fewest)):
        end = first + length * times
        alone = first if times >= fewest else end
        units += [range(i, i + 1) for i in range(at, alone)]
        if alone < end:
            units.append(range(first, end))
        at = end
    return units


def _before(
    lets: Sequence[Let],
    leaves: Sequence[tuple[Expr, ...]],
    place: Callable[[Expr], Hashable],
) -> list[tuple[int, ...]]:
    """The statements that each must stand behind: those that set what it reads or sets, and those
    that read what it sets. `leaves` are those of statements that others may equal."""
    known = cache(place)
    setters: dict[Hashable, int] = {}
    readers: dict[Hashable, list[int]] = {}
    found = []
    for i, let in enumerate(lets):
        reads = [known(e) for e in leaves[i] or below((let.value,)) if e.op in LEAVES]
        target = known(let.target)
        behind = [setters[p] for p in (*reads, target) if p in setters]
        found.append(tuple(dict.fromkeys((*behind, *readers.pop(target, ())))))
        for p in reads:
            if p != target:
                readers.setdefault(p, []).append(i)
        setters[target] = i
    return found


def _cost(
    weights: Sequence[int], leaves: Sequence[tuple[Expr, ...]], runs: Sequence[_Run]
) -> float:
    """About the instructions to compile."""
    total = float(sum(weights))
    for first, length, times in runs:
        end = first + length * times
        varied = sum(
            not is_one(column)
            for i in range(first, first + length)
            for column in zip(*leaves[i:end:length], strict=True)
        )
        rest = sum(weights[first + length : end])
        total += _LOOP + _ENTRY * varied * times - rest
    return total


def operations(let: Let) -> int:
    """About the instructions of a statement."""
    found, todo = 1, [let.value]
    seen = set(todo)
    for e in todo:
        found += len(e.args)
        for a in e.args:
            if a.args and a not in seen:
                seen.add(a)
                todo.append(a)
    return found


_Kinds: TypeAlias = "tuple[list[int], list[tuple[Expr, ...]]]"


def _kinds(statements: Sequence[Statement], home: Callable[[Expr], int], shapes: Shapes) -> _Kinds:
    """The kind of each statement, as a number, and its leaves."""
    numbers: dict[object, int] = {}
    kinds: list[int] = []
    leaves: list[tuple[Expr, ...]] = []
    known = cache(partial(_told, home))
    for i, s in enumerate(statements):
        shape, found = shapes(s.value) if isinstance(s, Let) else (None, ())
        kind: object = i  # no other is equal
        if shape is not None and isinstance(s, Let):
            kind = (shape, home(s.target), *map(known, found))
        kinds.append(numbers.setdefault(kind, len(numbers)))
        leaves.append(found)
    return kinds, leaves


def _rolled_in(
    statements: Sequence[Statement], leaves: Sequence[tuple[Expr, ...]], runs: Sequence[_Run]
) -> Sequence[Statement | Roll]:
    """The statements with their runs rolled."""
    out: list[Statement | Roll] = []
    at = 0
    for run in runs:
        first, length, times = run
        out += statements[at:first]
        out.append(_rolled(statements, leaves, *run))
        at = first + length * times
    return [*out, *statements[at:]]


def _runs(kinds: Sequence[int], weights: Sequence[int]) -> list[_Run]:
    """The runs whose loops save so much of the weights."""
    until = [0, *accumulate(weights)]
    following, repeated = _following(kinds), dict[int, int]()
    found: list[_Run] = []
    i = 0
    while i < len(kinds):
        length, times = _longest_run(kinds, following, until, repeated, i)
        if times:
            found.append((i, length, times))
        i += length * times or 1
    return found


def _told(home: Callable[[Expr], int], e: Expr) -> tuple[int, bool] | None:
    """What is told of a leaf: its memory, and whether it is hidden, so that its truth may not be
    known; nothing of a number."""
    return None if e.is_const else (home(e), e.is_symbol and is_hidden(e))


def _following(kinds: Sequence[int]) -> list[int]:
    """The next statement equal to each; the end where there is none."""
    last: dict[int, int] = {}
    found = [len(kinds)] * len(kinds)
    for i in range(len(kinds) - 1, -1, -1):
        found[i] = last.get(kinds[i], len(kinds))
        last[kinds[i]] = i
    return found


def _longest_run(
    kinds: Sequence[int],
    following: Sequence[int],
    until: Sequence[int],
    repeated: dict[int, int],
    i: int,
) -> tuple[int, int]:
    """The group at `i` that saves most: its length, and how often it stands there; else 0. The
    statements before a place weigh together what `until` says. `repeated` remembers, of each
    length, up to where statements equal those so far before them."""
    best, end = (0, 0), len(kinds)
    saved = LEAST - 1
    at = following[i]
    for _ in range(_TRIED):
        length = at - i
        if at == end or length > _LONGEST:
            break
        behind = max(at, repeated.get(length, 0))
        while behind < end and kinds[behind] == kinds[behind - length]:
            behind += 1
        repeated[length] = behind
        times = (behind - i) // length
        less = (times - 1) * (until[at] - until[i])
        if times >= FEWEST and less > saved:
            best, saved = (length, times), less
        at = following[at]
    return best


def _rolled(
    statements: Sequence[Statement],
    leaves: Sequence[tuple[Expr, ...]],
    first: int,
    length: int,
    times: int,
) -> Roll:
    end = first + length * times
    lets = tuple(s for s in statements[first:end] if isinstance(s, Let))
    targets = tuple(tuple(s.target for s in lets[i::length]) for i in range(length))
    columns = (tuple(zip(*leaves[i:end:length], strict=True)) for i in range(first, first + length))
    return Roll(lets, lets[:length], targets, tuple(columns))
