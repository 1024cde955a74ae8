"""The outlines of an SVG: its paths, rectangles, circles, ellipses, polygons and polylines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

from planarc.catalog.outline.piece import Drawing, Outline, Piece, line
from planarc.core.diagnostic import usage_error
from planarc.core.extras import need
from planarc.core.files import read_plain
from planarc.core.source import Source, Span, decode

#: Lengths in m of what an SVG measures its own size in.
_SIZES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6}
_SIZE = re.compile(r"\s*([\d.eE+-]+)\s*(m|cm|mm|in|pt|pc)\s*")


def read_svg(path: Path) -> Drawing:
    """Raises OSError; UsageError C171 for what is no SVG, C221 without `svgelements`."""
    svg = need("svgelements", "cad")
    data = read_plain(path)
    try:
        root = svg.SVG.parse(BytesIO(data), reify=True)
        back = ~svg.Matrix(root.viewbox_transform or "")
        source = Source(str(path), decode(data))
        found = tuple(o for e in root.elements() for o in _outlines(e, svg, back, source))
    except (SyntaxError, ValueError, AttributeError, IndexError, TypeError) as problem:
        said = str(problem).partition("\n")[0]
        hint = "save it as a plain SVG"
        raise usage_error("C171", f"`{path}` is no SVG: {said}", hint=hint) from None
    return Drawing(found, _metre(root))


def _metre(root: Any) -> float | None:
    """The length of a unit, where the drawing gives its size in units of length."""
    given = root.values.get("attributes", {})
    box = root.viewbox
    sizes = []
    for side in ("width", "height"):
        found = _SIZE.fullmatch(str(given.get(side, "")))
        if found is None:
            continue
        if box is None:  # then a unit is a pixel
            return _SIZES["in"] / 96
        if (units := float(getattr(box, side) or 0.0)) > 0:
            sizes.append(float(found[1]) * _SIZES[found[2]] / units)
    return min(sizes, default=None)


def _outlines(element: Any, svg: Any, back: Any, source: Source) -> Iterator[Outline]:
    if not isinstance(element, svg.Shape):
        return
    path = svg.Path(element) * back
    path.reify()
    name = element.id or ""
    span = _span(name, source)
    for part in path.as_subpaths():
        segments = [s for s in svg.Path(part) if not isinstance(s, svg.Move)]
        if not segments:
            continue
        pieces = tuple(_piece(s, svg) for s in segments)
        first, last = pieces[0].at(0.0), pieces[-1].at(1.0)
        size = max(abs(p.at(t) - first) for p in pieces for t in (0.5, 1.0))
        closed = isinstance(segments[-1], svg.Close) or abs(last - first) <= 1e-9 * size
        yield Outline(name, pieces, closed, span)


def _piece(segment: Any, svg: Any) -> Piece:
    """A segment with y upwards."""

    def at(t: float) -> complex:
        point = segment.point(t)
        return complex(point.x, -point.y)

    if isinstance(segment, svg.Arc):
        return Piece(at, max(segment.rx, segment.ry) * segment.sweep**2)
    if isinstance(segment, svg.QuadraticBezier):
        a, b, c = (complex(p) for p in (segment.start, segment.control, segment.end))
        return Piece(at, 2 * abs(a - 2 * b + c))
    if isinstance(segment, svg.CubicBezier):
        controls = (segment.start, segment.control1, segment.control2, segment.end)
        a, b, c, d = (complex(p) for p in controls)
        return Piece(at, 6 * max(abs(a - 2 * b + c), abs(b - 2 * c + d)))
    a, b = (complex(p.x, -p.y) for p in (segment.start, segment.end))
    return line(a, b)


def _span(name: str, source: Source) -> Span | None:
    """The place of an element's name in the text."""
    found = re.search(rf"""\bid\s*=\s*(["']){re.escape(name)}\1""", source.text) if name else None
    return Span(source, found.start(), found.end()) if found else None
