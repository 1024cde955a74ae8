"""What a metric is, as a text that is the same in another process and differs for another metric.

Of a function count its code, what that reads (defaults, closures, globals), and the same of the
functions that it calls by name; of an object its attributes. What may change while it is used,
as a list that collects, and what has no such text, as an array, count by their type.
"""

from __future__ import annotations

from functools import partial
from inspect import getattr_static
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

from msgspec import Struct
from msgspec.structs import asdict

_PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))


def identity(item: Any) -> str:
    """The text of a metric, of a part of one, or of what a function reads."""
    return _text(item, set())


def _text(item: Any, seen: set[int]) -> str:
    if isinstance(item, _PLAIN):
        return repr(item)
    if id(item) in seen:  # it calls itself
        return "again"
    seen.add(id(item))
    parts = [_text(part, seen) for part in _parts(item)]
    if isinstance(item, frozenset):
        parts.sort()
    seen.discard(id(item))
    return f"{type(item).__qualname__}({', '.join(parts)})"


def _parts(item: Any) -> list[Any]:
    match item:
        case tuple() | frozenset():
            return list(item)
        case FunctionType():
            code = item.__code__
            cells = [_content(cell) for cell in item.__closure__ or ()]
            reads = [item.__globals__.get(name) for name in code.co_names]
            return [code, item.__defaults__, _pairs(item.__kwdefaults__), *cells, *reads]
        case CodeType():
            return [item.co_code, item.co_names, item.co_consts]
        case MethodType():
            return [item.__func__, item.__self__]
        case partial():
            return [item.func, item.args, _pairs(item.keywords)]
        case type() | ModuleType() | BuiltinFunctionType():
            return [item.__name__]
        case Struct():
            return [_pairs(asdict(item))]
    call = getattr_static(type(item), "__call__", None)
    if not isinstance(call, FunctionType):
        return []
    return [call, _pairs(getattr(item, "__dict__", None))]


def _pairs(named: dict[str, Any] | None) -> tuple[Any, ...]:
    return tuple((named or {}).items())


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # not filled yet
        return None
