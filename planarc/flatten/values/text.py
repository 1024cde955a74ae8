"""`String(...)` of values known while compiling.

Reference: Modelica Language Specification 3.6, section 3.7.1.
"""

from __future__ import annotations

from planarc.flatten.terms.constant import NotConstant, Value
from planarc.ir import flat


def string_of(values: list[Value], call: flat.Builtin) -> Value:
    """The text of a value; formats other than the plain one are left to the run."""
    if len(values) == 2:
        raise NotConstant("`String` with a format has no value before the run", call.span)
    if len(values) == 4:
        plain = _plain(values[0], call, values[1])
        length, left = values[2], values[3]
        assert isinstance(length, int)
        return plain.ljust(length) if left else plain.rjust(length)
    return _plain(values[0], call, 6)


def _plain(value: Value, call: flat.Builtin, digits: Value) -> str:
    type_ = call.arguments[0].type
    if type_.literals and isinstance(value, int):
        return type_.literals[value - 1]
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, int | str):
        return str(value)
    raise NotConstant("`String` of an array", call.span)
