"""Values known while compiling, and their way back to expressions."""

from __future__ import annotations

from typing import TypeAlias

from planarc.core.source import Span
from planarc.ir import flat

Value: TypeAlias = "float | int | bool | str | list[Value] | dict[str, Value]"
#: The variables of a function, None before they have a value.
Frame: TypeAlias = "dict[str, Value | None]"


class NotConstant(Exception):
    """An expression has no value before the run; caught where the evaluator was asked."""

    def __init__(self, reason: str, span: Span | None = None, variable: str = "") -> None:
        super().__init__(reason)
        self.reason = reason
        self.span = span
        self.variable = variable  # that stands in the place of a value


def to_expression(value: Value, type_: flat.Type, span: Span) -> flat.Expression:
    """A value as literals of a type."""
    if isinstance(value, list):
        element = type_.element() if type_.dims else type_
        items = tuple([to_expression(v, element, span) for v in value])
        if items:
            element = items[0].type.with_dims(items[0].type.dims)
        return flat.Array(element.with_dims((len(items), *element.dims)), span, items)
    if isinstance(value, dict):
        fields = dict(type_.fields)
        items = tuple([to_expression(v, fields[n], span) for n, v in value.items()])
        return flat.Record(type_.with_dims(()), span, items)
    if type_.base is flat.Base.REAL and isinstance(value, int):
        value = float(value)
    return flat.Literal(type_.with_dims(()), span, value)
