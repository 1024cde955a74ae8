"""Assigning to variables, their entries and their fields."""

from __future__ import annotations

import math
from collections.abc import Sequence

from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.expr import Expr, Exprs
from planarc.lower import scalar
from planarc.lower.scope import Scope, outside_array, unsupported
from planarc.lower.values import RecordValue, Value, expr, fixed_dims
from planarc.runtime.tensor import Tensor, elements, stack


def zero_of(type_: flat.Type, table: Exprs) -> Value:
    """The value of a type with all numbers zero and all truths false."""
    if dims := fixed_dims(type_):
        one = zero_of(type_.element(len(dims)), table)
        return Tensor(dims, (one,) * math.prod(dims))
    if type_.base is flat.Base.RECORD:
        return RecordValue(tuple((name, zero_of(field, table)) for name, field in type_.fields))
    return table.false if type_.base is flat.Base.BOOLEAN else table.zero


def store(scope: Scope, values: dict[str, Value], target: flat.Target, value: Value) -> None:
    """Assign to a variable, to an entry of it, or to a field (`o.a[1] := ...`); or to several
    ones, a record's or an array's parts."""
    if not isinstance(target, flat.Reference):
        parts = value.rows() if isinstance(value, Tensor) else ()
        if isinstance(value, RecordValue):
            parts = tuple(v for _, v in value.fields)
        for item, part in zip(target.items, parts, strict=True):
            assert isinstance(item, flat.Reference | flat.Record | flat.Array)
            store(scope, values, item, part)
        return
    whole, *path = target.name.split(".")
    if not path or whole not in values:
        whole, path = target.name, []
    if path or target.subscripts:
        old = scope.value(whole, target.span)
        value = _replaced(scope, old, path, target.subscripts, value, target.span)
    values[whole] = value


def _replaced(
    scope: Scope,
    old: Value,
    path: Sequence[str],
    subscripts: tuple[flat.Expression, ...],
    value: Value,
    span: Span,
) -> Value:
    if not path:
        return assigned(scope, old, subscripts, value, span)
    if isinstance(old, Tensor):
        return _replaced_in_entry(scope, old, path, subscripts, value, span)
    assert isinstance(old, RecordValue)
    return RecordValue(
        tuple(
            (n, _replaced(scope, v, path[1:], subscripts, value, span) if n == path[0] else v)
            for n, v in old.fields
        )
    )


def _replaced_in_entry(
    scope: Scope,
    old: Tensor,
    path: Sequence[str],
    subscripts: tuple[flat.Expression, ...],
    value: Value,
    span: Span,
) -> Value:
    """`r[i].x := value`: the first subscript chooses the record."""
    first = subscripts[0] if subscripts else None
    if first is None or isinstance(first, flat.Slice) or first.type.dims:
        raise unsupported("an assignment to a field of several records at once", span)
    number = expr(scalar.lower_expression(scope, first))
    if not number.is_const:
        raise unsupported("an assignment to an entry that is chosen while running", span)
    rows, position = list(old.rows()), int(number.data) - 1
    if not 0 <= position < len(rows):
        raise outside_array(position + 1, len(rows), span)
    rows[position] = _replaced(scope, rows[position], path, subscripts[1:], value, span)
    return stack(rows, old.shape[1:])


def assigned(
    scope: Scope, old: Value, subscripts: tuple[flat.Expression, ...], value: Value, span: Span
) -> Value:
    """The array `old` after `old[subscripts] := value`."""
    if not subscripts:
        return value
    assert isinstance(old, Tensor)
    first, rest = subscripts[0], subscripts[1:]
    count, size = old.shape[0], math.prod(old.shape[1:])
    if isinstance(first, flat.Slice):
        positions = list(range(count))
        many = True
    else:
        at = scalar.lower_expression(scope, first)
        many = isinstance(at, Tensor)
        numbers = [expr(p) for p in elements(at)]
        if not many and not numbers[0].is_const:
            return _assigned_somewhere(scope, old, numbers[0], rest, value, span)
        if not all(n.is_const for n in numbers):
            raise unsupported("an assignment to entries that are chosen while running", span)
        positions = [int(n.data) - 1 for n in numbers]
    values = value.rows() if many and isinstance(value, Tensor) else (value,) * len(positions)
    items = list(old.items)
    for position, entry in zip(positions, values, strict=True):
        if not 0 <= position < count:
            raise outside_array(position + 1, count, span)
        row = Tensor(old.shape[1:], tuple(items[position * size : (position + 1) * size]))
        new = assigned(scope, row if row.shape else row.items[0], rest, entry, span)
        items[position * size : (position + 1) * size] = elements(new)
    return Tensor(old.shape, tuple(items))


def _assigned_somewhere(
    scope: Scope,
    old: Tensor,
    place: Expr,
    rest: tuple[flat.Expression, ...],
    value: Value,
    span: Span,
) -> Value:
    """Each row is the new one where the place, known only while running, is its number."""
    scope.keep_within(place, old.shape[0], span)
    rows = []
    for number, row in enumerate(old.rows(), start=1):
        here = scope.table.equal(place, scope.table.const(number))
        new = assigned(scope, row, rest, value, span)
        rows.append(scalar.choose(scope, here, new, row, span))
    return stack(rows, old.shape[1:])
