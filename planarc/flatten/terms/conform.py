"""Types of values: their text in messages, and which value may stand where.

Reference: Modelica Language Specification 3.6, sections 6.6, 6.7 and 10.6.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from math import prod

from msgspec.structs import replace

from planarc.core.diagnostic import Once, PlanarcError, error
from planarc.core.mend import Each
from planarc.core.prose import counted, listed, shortened
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.flatwalk import nodes_of

NUMERIC = (flat.Base.REAL, flat.Base.INTEGER)


def type_text(type_: flat.Type) -> str:
    """`Real[2, 3]`, as a message shows a type."""
    name = type_.name or type_.base.value
    if not type_.dims:
        return name
    return f"{name}[{', '.join(':' if d is None else str(d) for d in type_.dims)}]"


def base_conforms(expected: flat.Type, actual: flat.Type) -> bool:
    """True for types that conform but for their dimensions: an Integer may stand for a Real,
    records are compared by their fields."""
    if expected.base is flat.Base.REAL:
        return actual.base in NUMERIC
    if expected.base is not actual.base:
        return False
    if expected.base is flat.Base.ENUMERATION:
        return expected.name == actual.name or expected.literals == actual.literals
    if expected.base is flat.Base.RECORD:
        have = dict(actual.fields)
        return len(have) == len(expected.fields) and all(
            n in have and conforms(t, have[n]) for n, t in expected.fields
        )
    return True


def dims_conform(expected: flat.Dims, actual: flat.Dims) -> bool:
    """Equal sizes; a size known only when run fits any."""
    return expected == actual or (
        len(expected) == len(actual)
        and all(e is None or a is None or e == a for e, a in zip(expected, actual, strict=True))
    )


def unlike_dims(left: flat.Type, right: flat.Type) -> tuple[flat.Dims, flat.Dims] | None:
    """The first dimensions in which two types differ, their own or those of a field."""
    if not dims_conform(left.dims, right.dims):
        return left.dims, right.dims
    pairs = zip(left.fields, right.fields, strict=False)
    return next((u for (_, a), (_, b) in pairs if (u := unlike_dims(a, b))), None)


def conforms(expected: flat.Type, actual: flat.Type) -> bool:
    return base_conforms(expected, actual) and dims_conform(expected.dims, actual.dims)


def expect(
    expected: flat.Type,
    value: flat.Expression,
    what: str,
    span: Span | None = None,
    single: bool = False,
) -> None:
    """Refuse a value that does not have the expected type; `single`: of what there is but one."""
    if not conforms(expected, value.type):
        found = mismatch(expected, value.type, what, span or value.span, single)
        if expected.dims and (hint := product_hint(value)):
            raise PlanarcError(replace(found.diagnostics[0], hint=hint, mend=None))
        raise found


def product_hint(value: flat.Expression) -> str | None:
    """What a user means whose product of vectors is a number."""
    if value.type.dims or not any(
        isinstance(e, flat.Binary) and e.op == "*" and e.left.type.dims and not e.type.dims
        for e in nodes_of([value])
    ):
        return None
    return "`*` of two vectors is a number; write `.*` to multiply them entry by entry"


#: What stands before a value that all members of an array get.
_EACH = r"\beach\s+[\w.]+\s*=\s*\Z"


def shape_hint(expected: flat.Type, actual: flat.Type, span: Span) -> str | None:
    """What a user means who gives a number or a vector of another length."""
    size = expected.dims[0] if len(expected.dims) == 1 else None
    short = size is not None and 0 < size < 5  # a size may be anything that a user writes
    vector = f"`{{{', '.join(['1', '0', '0', '0'][:size])}}}`" if short else ""
    if expected.dims and not actual.dims:
        if size == _PLANE:  # a place or a direction, whose entries are hardly equal
            given = span.text if _is_short(span) and actual.base in NUMERIC else "1"
            return f"write {size} values in braces, such as `{{{given}, 0}}`"
        example = f"{size} values in braces, such as {vector}; " if short else ""
        return f"write {example}`each` in a modifier, or `fill(...)` in an equation"
    if not expected.dims and len(actual.dims) == 1:
        if re.search(_EACH, span.source.text[: span.start]):
            return "remove `each`, if every member is to get its own value; else give one number"
        return "give one number, not a vector"
    matrices = len(expected.dims) == len(actual.dims) == 2
    lies = matrices and expected.dims[0] not in (1, None) and actual.dims == (1, expected.dims[0])
    if lies and _is_short(span) and "," in span.text:
        return f"rows are parted by `;`: write the column `{span.text.replace(',', ';')}`"
    if matrices and expected.dims[1] != actual.dims[1]:
        rows, columns = expected.dims
        hint = f"write rows of {counted(columns, 'value')}" if columns else None
        if columns and (rewritten := in_rows(span, columns)):
            return f"`;` ends a row: write `{rewritten}`"
        turned = columns == actual.dims[0] and rows in (None, *actual.dims)
        return (
            f"{hint}, or `transpose({span.text})`" if hint and turned and _is_short(span) else hint
        )
    if size and actual.dims == (1, size) and _is_short(span):  # `[0, -1]`
        return f"brackets make a matrix: write `{{{span.text.strip('[] ')}}}`"
    if not size or len(actual.dims) != 1:
        return None
    values = f"write {size} values, such as {vector}" if short else None
    mixed = re.search(r",\S", span.text) and re.search(r",\s", span.text)  # `0,5, 0`
    if size == 2 and actual.dims == (3,) and re.search(_THIRD_ZERO, span.text) and not mixed:
        written = re.sub(_THIRD_ZERO, "}", span.text)
        return f"vectors of the plane have no third entry: write `{written}`"
    return decimal_comma(span, (actual.dims[0] or 0) - size) or values


def in_rows(span: Span, columns: int) -> str | None:
    """A matrix that was written as one row, in rows of so many numbers."""
    numbers = _entries(span)
    rows = len(numbers) // columns
    if not _is_short(span) or rows < 2 or rows * columns != len(numbers) or ";" in span.text:
        return None
    if any(c in span.text for c in "{("):
        return None
    cut = (numbers[i : i + columns] for i in range(0, len(numbers), columns))
    return f"[{'; '.join(', '.join(row) for row in cut)}]"


def _entries(span: Span) -> list[str]:
    return [n.strip() for n in span.text.strip("[] \n").split(",")]


def numbers_of(span: Span) -> list[float]:
    """The entries of a matrix that is written as one row of numbers; none for others."""
    try:
        return [float(n) for n in _entries(span)]
    except ValueError:
        return []


#: The entries of a vector of the plane.
_PLANE = 2
#: The end of a vector of space that lies in the plane.
_THIRD_ZERO = r",\s*0(\.0*)?\s*\}\s*\Z"


def decimal_comma(span: Span, surplus: int) -> str | None:
    """What a user means who writes `0,5` among numbers, which are so many too many."""
    commas = list(re.finditer(r"\b(\d+),(\d+)\b", span.text))
    if not 0 < surplus <= len(commas):
        return None
    comma = commas[0]
    return f"write a decimal point, `{comma[1]}.{comma[2]}`, if `{comma[0]}` is one number"


def _is_short(span: Span) -> bool:
    """True for what a hint can repeat."""
    return len(span.text) < 50 and "\n" not in span.text


def mismatch(
    expected: flat.Type, actual: flat.Type, what: str, span: Span, single: bool = False
) -> PlanarcError:
    hint = shape_hint(expected, actual, span) if base_conforms(expected, actual) else None
    if expected.dims == (_PLANE,) and not actual.dims and what.startswith("the attribute"):
        hint = f"write `each` before it, for all entries; or {(hint or '').removeprefix('write ')}"
    several = re.fullmatch(r"the value of `(\w+)\.(\w+)`", what)
    if (
        hint
        and several
        and not single
        and not expected.dims
        and len(actual.dims) == 1
        and actual.dims[0]
    ):
        part, name = several.groups()
        hint += f", or declare {actual.dims[0]} of them: `{part}[{actual.dims[0]}]({name}=...)`"
    member = re.fullmatch(r"the value of `\w+\[\d+\]\.\w+`", what)
    if member and expected.dims and actual.dims[1:] == expected.dims:
        hint = "leave `each` out: the value has an entry for each member"
    if (expected.base, actual.base) == (flat.Base.INTEGER, flat.Base.REAL):
        hint = f"write `integer({span.text})`, which rounds down, or declare it Real"
    if expected.base is flat.Base.BOOLEAN and actual.base in NUMERIC:
        hint = "write `true` or `false`"
    if expected.base in NUMERIC and re.search(r'"\s*[-+]?[\d.]+(e[-+]?\d+)?\s*"', span.text):
        hint = "write numbers without quotes"
    if expected.base is flat.Base.ENUMERATION and span.text.strip('"') in expected.literals:
        hint = f"write `{type_text(expected)}.{span.text.strip(chr(34))}`"
    elif expected.literals and actual.base in NUMERIC:
        hint = literals_hint(expected)
    message = f"{what} must be of type {type_text(expected)}, but is {type_text(actual)}"
    mend = Each() if expected.dims and not actual.dims else None
    return error("F270", message, span, hint=hint, mend=mend)


def literals_hint(type_: flat.Type) -> str:
    """What a value of an enumeration may be."""
    names = [f"`{type_.name}.{name}`" for name in type_.literals]
    few = len(names) <= _MOST_LITERALS
    return f"write {listed(names, 'or') if few else shortened(names, _MOST_LITERALS)}"


_MOST_LITERALS = 6  # that a hint names


def no_scalar(code: str, message: str, span: Span) -> PlanarcError:
    """The error of a vector where one number is wanted; all sizes of a `size(x)` are a vector."""
    sizes = re.fullmatch(r"size\((\w+)\)", span.text)
    if sizes is None:
        return error(code, message, span)
    hint = f"write `size({sizes[1]}, 1)`: without a number, it gives the sizes of all dimensions"
    return PlanarcError(Once(code, message, span, hint=hint, kind=f"size {sizes[1]}"))


def expect_scalar(
    value: flat.Expression, bases: tuple[flat.Base, ...], what: str
) -> flat.Expression:
    if value.type.base not in bases or value.type.dims:
        wanted = " or ".join(b.value for b in bases)
        message = f"{what} must be of type {wanted}, but is {type_text(value.type)}"
        hint, number = None, value.type.base in (flat.Base.REAL, flat.Base.INTEGER)
        if bases == (flat.Base.BOOLEAN,) and number and not value.type.dims:
            hint = f"compare it with a number, as in `{_in_line(value.span)} > 0`"
        raise error("F270", message, value.span, hint=hint)
    return value


def _in_line(span: Span) -> str:
    return " ".join(span.text.split())


def unify_dims(left: flat.Dims, right: flat.Dims) -> flat.Dims:
    """The dimensions of two arrays of one shape, with what either of them knows."""
    return tuple(a if a is not None else b for a, b in zip(left, right, strict=True))


def unify(left: flat.Type, right: flat.Type, dims: bool = True) -> flat.Type | None:
    """The type that both values have, or None."""
    if dims and not dims_conform(left.dims, right.dims):
        return None
    if base_conforms(left, right):
        found = left
    elif base_conforms(right, left):
        found = right
    else:
        return None
    return found.with_dims(unify_dims(left.dims, right.dims)) if dims else found


def common_type(
    found: flat.Type,
    values: Iterable[flat.Expression],
    refuse: Callable[[flat.Type, flat.Expression], PlanarcError],
    dims: bool = True,
) -> flat.Type:
    """The type of all values, beginning with one that is known; `refuse` makes the error."""
    for value in values:
        common = unify(found, value.type, dims)
        if common is None:
            raise refuse(found, value)
        found = common
    return found


def scalar_count(type_: flat.Type) -> int:
    """The number of scalars that a value of a type holds."""
    count = prod(size or 0 for size in type_.dims)
    if type_.base is flat.Base.RECORD:
        count *= sum(scalar_count(t) for _, t in type_.fields)
    return count
