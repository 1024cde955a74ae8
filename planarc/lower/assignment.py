"""Assigning to variables, their entries and their fields."""

from __future__ import annotations

import math
from collections.abc import Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Misfit
from planarc.core.prose import counted
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.expr import Expr, Exprs
from planarc.lower import scalar
from planarc.lower.scope import Scope, outside_array, unsupported
from planarc.lower.values import RecordValue, Text, Value, expect_size, expr, exprs, fixed_dims
from planarc.runtime.tensor import Tensor, elements, shape_of, stack


def zero_of(type_: flat.Type, table: Exprs) -> Value:
    """The value of a type with all numbers zero, all truths false and all texts empty."""
    if dims := fixed_dims(type_):
        one = zero_of(type_.element(len(dims)), table)
        return Tensor(dims, (one,) * math.prod(dims))
    if type_.base is flat.Base.RECORD:
        return RecordValue(tuple((name, zero_of(field, table)) for name, field in type_.fields))
    if type_.base is flat.Base.STRING:
        return Text(("",))
    return table.false if type_.base is flat.Base.BOOLEAN else table.zero


def store(scope: Scope, values: dict[str, Value], target: flat.Target, value: Value) -> None:
    """Assign to a variable, to an entry of it, or to a field (`o.a[1] := ...`); or to several
    ones, a record's or an array's parts."""
    if not isinstance(target, flat.Reference):
        parts = value.rows() if isinstance(value, Tensor) else ()
        if isinstance(value, RecordValue):
            parts = tuple(v for _, v in value.fields)
        if len(parts) != len(target.items):
            raise _unlike(len(target.items), len(parts), target.span)
        for item, part in zip(target.items, parts, strict=True):
            assert isinstance(item, flat.Reference | flat.Record | flat.Array)
            store(scope, values, item, part)
        return
    whole, *path = target.name.split(".")
    if not path or whole not in values:
        whole, path = target.name, []
    if path or target.subscripts:
        part = _Part(scope, value, target.span)
        value = part.put_in(scope.value(whole, target.span), path, target.subscripts)
    values[whole] = value


def _unlike(entries: int, values: int, span: Span) -> Misfit:
    message = f"{entries} entries cannot be given {counted(values, 'value')}"
    return Misfit(Diagnostic("L331", message, span))


class _Part(Data):
    """A value that takes the place of a field or of entries."""

    scope: Scope
    value: Value
    span: Span

    def put_in(self, old: Value, path: Sequence[str], subscripts: flat.Expressions) -> Value:
        """`old` with the value in it; the first subscripts choose records of arrays."""
        if not path:
            return self.put_at(old, subscripts)
        if isinstance(old, Tensor):
            return self._put_in_entry(old, path, subscripts)
        assert isinstance(old, RecordValue)
        return RecordValue(
            tuple(
                (n, self.put_in(v, path[1:], subscripts) if n == path[0] else v)
                for n, v in old.fields
            )
        )

    def _put_in_entry(
        self, old: Tensor, path: Sequence[str], subscripts: flat.Expressions
    ) -> Value:
        """`r[i].x := value`."""
        first = subscripts[0] if subscripts else None
        if first is None or isinstance(first, flat.Slice) or first.type.dims:
            raise unsupported("an assignment to a field of several records at once", self.span)
        number = expr(scalar.lower_expression(self.scope, first))
        if not number.is_const:
            raise unsupported("an assignment to an entry that is chosen while running", self.span)
        rows, position = list(old.rows()), int(number.data) - 1
        if not 0 <= position < len(rows):
            raise outside_array(position + 1, len(rows), self.span)
        rows[position] = self.put_in(rows[position], path, subscripts[1:])
        return stack(rows, old.shape[1:])

    def put_at(self, old: Value, subscripts: flat.Expressions) -> Value:
        """The array `old` after `old[subscripts] := value`."""
        if not subscripts:
            return self.value
        assert isinstance(old, Tensor)
        first, rest = subscripts[0], subscripts[1:]
        count, size = old.shape[0], math.prod(old.shape[1:])
        if isinstance(first, flat.Slice):
            positions, many = list(range(count)), True
        else:
            at = scalar.subscript(self.scope, first)
            many = isinstance(at, Tensor)
            numbers = exprs(at)
            if not many and not numbers[0].is_const:
                return self._put_somewhere(old, numbers[0], rest)
            if not all(n.is_const for n in numbers):
                what = "an assignment to entries that are chosen while running"
                raise unsupported(what, self.span)
            positions = [int(n.data) - 1 for n in numbers]
        parts = [self] * len(positions)
        if many and isinstance(self.value, Tensor):
            parts = [replace(self, value=row) for row in self.value.rows()]
        if len(parts) != len(positions):
            raise _unlike(len(positions), len(parts), self.span)
        items = list(old.items)
        for position, part in zip(positions, parts, strict=True):
            if not 0 <= position < count:
                raise outside_array(position + 1, count, self.span)
            new = part.put_in_row(old.row(position), rest)
            items[position * size : (position + 1) * size] = elements(new)
        return Tensor(old.shape, tuple(items))

    def put_in_row(self, row: Value, rest: flat.Expressions) -> Value:
        new = self.put_at(row, rest)
        expect_size(f"`{self.span.text}`", shape_of(row), new, self.span)
        return new

    def _put_somewhere(self, old: Tensor, place: Expr, rest: flat.Expressions) -> Value:
        """Each row is the new one where the place, known only while running, is its number."""
        scope = self.scope
        scope.keep_within(place, range(1, old.shape[0] + 1), self.span)
        rows = []
        for number, row in enumerate(old.rows(), start=1):
            here = scope.table.equal(place, scope.table.const(number))
            rows.append(scalar.choose(scope, here, self.put_in_row(row, rest), row, self.span))
        return stack(rows, old.shape[1:])
