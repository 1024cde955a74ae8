"""Loops taken apart, so that most of their statements are done for all times at once.

In:   a loop (`rolling.Roll`)
Out:  its statements, each with what stands time by time in its place, in an order that keeps each
      value

Links of a chain begin where the one before ends: a loop over them waits from time to time, but
next to nothing in it does.

    for t: c[t] := cos(phi[t])                c[:] := cos(phi[:])
           x[t+1] := x[t] + L*c[t]      ->    x[t+1] := x[t] + L*c[t]     one time after the other
           h[t] := g*x[t]                     h[:] := g*x[1:]

A statement whose last operation alone reads what it set the time before is done as the others are:
operation by operation, each for one time behind the other. Those that read each other from time to
time are done time by time, where that is a small part of the loop.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator
from typing import TypeAlias

from planarc.codegen.native.rolling import Column, Roll, operations
from planarc.codegen.native.spelled import in_order, taken
from planarc.core.blocks import sort_blocks
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.program import Let, Statement

#: A statement, and what stands time by time in the place of its target and of each leaf.
Vector: TypeAlias = "tuple[Let, Column, tuple[Column, ...]]"

#: An operation in code takes about as much, for all platforms together, as so many in rows.
_IN_CODE = 9


def vectors(s: Statement | Roll, place: Callable[[Expr], Hashable]) -> list[Vector] | None:
    """A statement, or those of a loop in an order that keeps each value; None where too much of it
    waits, or what is set is set again. `place` tells where a value is kept."""
    if isinstance(s, Roll):
        return _parted(s, place)
    assert isinstance(s, Let)
    leaves = (e for e in postorder((s.value,)) if not e.args and e.op is not Op.TIME)
    return [(s, (s.target,), tuple((e,) for e in leaves))]


def _parted(run: Roll, place: Callable[[Expr], Hashable]) -> list[Vector] | None:
    setters: dict[Hashable, tuple[int, int]] = {}  # time and statement
    for i, column in enumerate(run.targets):
        for t, e in enumerate(column):
            if setters.setdefault(place(e), (t, i)) != (t, i):
                return None
    needed: list[set[int]] = [set() for _ in run.body]
    own: list[set[Expr]] = [set() for _ in run.body]  # leaves that it set itself before
    for i, columns in enumerate(run.leaves):
        for column in columns:
            for t, e in enumerate(column):
                setter = setters.get(place(e), (t, i))
                before = setter < (t, i)
                needed[i if before else setter[1]].add(setter[1] if before else i)
                if before and setter[1] == i:
                    own[i].add(column[0])
    found: list[Vector] = []
    one_by_one = 0
    for block in sort_blocks([sorted(others) for others in needed]):
        first = block[0]
        if len(block) == 1 and _reads_last(run.body[first].value, own[first]):
            found.append((run.body[first], run.targets[first], run.leaves[first]))
        else:
            alone = [*_one_by_one(run, block)]
            one_by_one += sum(operations(let) for let, *_ in alone)
            found += alone
    return found if one_by_one <= _IN_CODE * sum(map(operations, run.body)) else None


def _one_by_one(run: Roll, block: Collection[int]) -> Iterator[Vector]:
    count = len(run.body)
    for t in range(len(run.targets[0])):
        for i in block:
            let = run.statements[t * count + i]
            yield let, (run.targets[i][t],), tuple((column[t],) for column in run.leaves[i])


def _reads_last(value: Expr, leaves: Collection[Expr]) -> bool:
    """Whether none but the last operation reads these."""
    if not leaves:
        return True
    stack: list[bool] = []  # whether it is one of them
    for part in [*in_order(value)][:-1]:
        if isinstance(part, int):
            first = len(stack) - taken(part)
            if any(stack[first:]):
                return False
            stack[first:] = [False]
        else:
            stack.append(part in leaves)
    return True
