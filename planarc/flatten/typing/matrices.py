"""Matrices written out: `[a, b; c, d]`, blocks side by side, then one below the other.

Reference: Modelica Language Specification 3.6, section 10.4.2.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.prose import counted
from planarc.core.source import Span
from planarc.flatten.terms.conform import common_type, decimal_comma, type_text
from planarc.flatten.terms.select import array, element_at, opened
from planarc.flatten.typing import arrays
from planarc.ir import flat


def matrix(rows: list[list[flat.Expression]], span: Span) -> flat.Expression:
    """`[a, b; c, d]`: blocks side by side, then one below the other (10.4.2)."""
    depth = max(2, *(len(e.type.dims) for row in rows for e in row))
    if depth > 2:
        return _joined_blocks(rows, depth, span)
    if any(None in e.type.dims for row in rows for e in row):
        return _joined_matrix(rows, span)
    lines: list[list[flat.Expression]] = []
    for row in rows:
        lines += _beside([_as_block(e) for e in row], span)
    _check_widths(lines, span)
    entries = [entry for line in lines for entry in line]
    type_ = common_type(rows[0][0].type.with_dims(()), entries, _unlike)
    width = len(lines[0]) if lines else 0
    return array([array(line, type_, span) for line in lines], type_.with_dims((width,)), span)


def _check_widths(lines: list[list[flat.Expression]], span: Span) -> None:
    """Report the first row that is longer or shorter than most."""
    widths = [len(line) for line in lines]
    usual = max(widths, key=widths.count, default=0)
    for row, width in enumerate(widths, 1):
        if width != usual:
            has = f"row {row} has {counted(width, 'value')}"
            message = f"the rows of the matrix have different lengths: {has}"
            message += f", the others have {usual}" if widths.count(usual) > 1 else f", not {usual}"
            whole = [e.span for e in lines[row - 1] if e.span.source is span.source] or [span]
            place = whole[0]._replace(end=whole[-1].end)
            raise error("F276", message, place, hint=decimal_comma(place, width - usual))


def _unlike(type_: flat.Type, entry: flat.Expression) -> PlanarcError:
    texts = f"{type_text(type_)} and {type_text(entry.type)}"
    return error("F276", f"the entries of the matrix have different types: {texts}", entry.span)


def _unlike_blocks(_: flat.Type, block: flat.Expression) -> PlanarcError:
    return error("F276", "the entries of the matrix have different types", block.span)


def _joined_blocks(rows: list[list[flat.Expression]], depth: int, span: Span) -> flat.Expression:
    """Blocks of more than two dimensions: joined along the second, then along the first."""
    if any(None in e.type.dims for row in rows for e in row):
        raise error("F276", "blocks of three and more dimensions need known sizes", span)
    lines = [arrays.join(2, [_promoted(e, depth) for e in row], span) for row in rows]
    return arrays.join(1, lines, span)


def _promoted(e: flat.Expression, depth: int) -> flat.Expression:
    """A value with dimensions of size 1 added behind its own."""
    if e.type.dims:
        items = [_promoted(x, depth - 1) for x in opened(e)]
        element = items[0].type if items else e.type.element().with_dims((1,) * (depth - 1))
        return array(items, element, e.span)
    for _ in range(depth):
        e = array([e], e.type, e.span)
    return e


def _joined_matrix(rows: list[list[flat.Expression]], span: Span) -> flat.Expression:
    """Blocks of sizes that are known only when run: calls of `cat`."""
    blocks = [e for row in rows for e in row]
    element = common_type(blocks[0].type, blocks, _unlike_blocks, dims=False).with_dims(())
    whole = element.with_dims((None, None))

    def cat(along: int, parts: list[flat.Expression]) -> flat.Expression:
        if len(parts) == 1:
            return parts[0]
        dimension = flat.Literal(flat.INTEGER, span, along)
        return flat.Builtin(whole, span, "cat", (dimension, *parts))

    def block(value: flat.Expression) -> flat.Expression:
        if len(value.type.dims) == 2:
            return value
        dims = (*value.type.dims, 1, 1)[:2]
        return flat.Builtin(element.with_dims(dims), span, "matrix", (value,))

    return cat(1, [cat(2, [block(e) for e in row]) for row in rows])


def _as_block(value: flat.Expression) -> list[list[flat.Expression]]:
    """A scalar is 1 x 1, a vector a column."""
    dims = value.type.dims
    if any(d is None for d in dims):
        raise error("F276", "the size of this block of a matrix is not known", value.span)
    if not dims:
        return [[value]]
    rows = [element_at(value, i) for i in range(1, (dims[0] or 0) + 1)]
    if len(dims) == 1:
        return [[row] for row in rows]
    return [[element_at(row, j) for j in range(1, (dims[1] or 0) + 1)] for row in rows]


def _beside(blocks: list[list[list[flat.Expression]]], span: Span) -> list[list[flat.Expression]]:
    heights = {len(b) for b in blocks}
    if len(heights) > 1:
        raise error("F276", "the blocks of a row of the matrix have different heights", span)
    return [[e for block in blocks for e in block[i]] for i in range(heights.pop())]
