"""The value of an expression at one point, on Python's numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from planarc.evaluate.operations import VALUES
from planarc.ir.expr import Expr, Op
from planarc.runtime import elementary, external


def apply_function(e: Expr, arguments: Sequence[Any]) -> Any:
    """The value of an elementary function, of one that the model calls, or of a loop."""
    if e.op is Op.CALL:
        return elementary.TABLE[e.data].value(*arguments)
    if e.op is Op.LOOP:
        from planarc.evaluate.loops import value_behind

        loop, place = e.data
        return value_behind(loop, place, arguments)
    function, output, _ = e.data
    return external.number(function, output, arguments)


def evaluate(
    root: Expr,
    leaf: Callable[[Expr], Any],
    apply: Callable[[Expr, Sequence[Any]], Any] = apply_function,
    values: dict[Expr, Any] | None = None,
) -> Any:
    """The value of an expression; `leaf` gives that of symbols, time, pre and events, `apply`
    that of functions, of numbers as the leaves are. `values` are known, and are added to.

    Python's arithmetic errors come through (ZeroDivisionError, ValueError, OverflowError).
    Of a condition's branches only the one that it chooses is evaluated.
    """
    values = {} if values is None else values
    stack = [root]
    while stack:
        e = stack[-1]
        needed = _needed(e, values)
        waiting = [a for a in needed if a not in values]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        if e in values:
            continue
        if e.op is Op.CONST:
            values[e] = e.data
        elif not e.args or e.op is Op.PAST:
            values[e] = leaf(e)
        elif e.op in _CHOICES:
            values[e] = values[needed[-1]]
        elif e.op in (Op.CALL, Op.APPLY, Op.LOOP):
            values[e] = apply(e, [values[a] for a in e.args])
        else:
            values[e] = VALUES[e.op](*(values[a] for a in e.args))
    return values[root]


_CHOICES = frozenset({Op.IF, Op.AND, Op.OR})


def _needed(e: Expr, values: Mapping[Expr, Any]) -> tuple[Expr, ...]:
    """The arguments that the value hangs on, as far as is known; of a choice the last of
    them is its value."""
    if e.op not in _CHOICES or e.args[0] not in values:
        return e.args if e.op not in _CHOICES else e.args[:1]
    first = bool(values[e.args[0]])
    if e.op is Op.IF:
        return (e.args[0], e.args[1] if first else e.args[2])
    return e.args if first is (e.op is Op.AND) else e.args[:1]
