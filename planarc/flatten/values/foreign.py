"""External functions run while compiling, when all their arguments are constants.

In:   flat.Function with an external call, the values of what it is called with
Out:  the values of its outputs
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.flatten.library.resources import resource_path
from planarc.flatten.terms.constant import NotConstant, Value
from planarc.flatten.tree.nodes import Session
from planarc.flatten.values import compute
from planarc.ir import flat
from planarc.runtime import external

#: The function that `loadResource` of a standard library stands for (18.8.2).
LOAD_RESOURCE = "planarc_loadResource"


def external_values(
    function: flat.Function,
    given: list[Value],
    empty: dict[str, Value],
    session: Session,
    span: Span,
) -> dict[str, Value]:
    """The outputs by name. `empty` are values of their types and sizes."""
    name = function.external
    assert name is not None
    if name in external.SILENT:
        return empty
    if name == LOAD_RESOURCE:
        return {function.results[0]: resource_path(str(given[0]), session.library, span)}
    if not external.is_pure(name):
        raise NotConstant(f"`{function.name}` has another value in each run", span)
    try:
        if external.is_of_texts(name):
            if external.is_of_files(name):
                session.library.looked.names.add(str(given[0]))
            if external.is_of_contents(name):
                session.library.looked.contents.add(str(given[0]))
            found = external.call_texts(name, given)
            return {**empty, **dict(zip(function.results, found, strict=False))}
        numbers = tuple(float(x) for x in compute.flat_values(given))
        row = iter(external.call_numbers(name, numbers))
        integers = {v.name for v in function.outputs if v.type.base is flat.Base.INTEGER}
        return {**empty, **{n: _next(empty[n], row, n in integers) for n in function.results}}
    except ValueError as problem:
        reason = "" if external.is_of_contents(name) else f"`{function.name}` has no value: "
        raise error("F283", f"{reason}{problem}", span) from None
    except StopIteration:
        message = f"`{function.name}` has more results than `{name}` gives"
        raise error("F283", message, span) from None


def _next(shape: Value, row: Iterator[float], integer: bool) -> Value:
    """The next numbers of a row, in the shape of a value."""
    if isinstance(shape, list):
        return [_next(inner, row, integer) for inner in shape]
    return int(next(row)) if integer else next(row)
