"""The outlines of a DXF: polylines, with their arcs, and circles of its model space."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from planarc.catalog.outline.piece import Drawing, Outline, arc
from planarc.core.diagnostic import usage_error
from planarc.core.extras import need
from planarc.core.files import open_plain


def read_dxf(path: Path) -> Drawing:
    """Raises OSError; UsageError C171 for what is no DXF, C221 without `ezdxf`."""
    ezdxf = need("ezdxf", "cad")
    units = need("ezdxf.units", "cad")
    open_plain(path).close()
    try:
        document = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError, ValueError) as problem:
        said = str(problem).partition("\n")[0]
        hint = "save it as a DXF of R2000 or later"
        raise usage_error("C171", f"`{path}` is no DXF: {said}", hint=hint) from None
    found = tuple(o for e in document.modelspace() for o in _outlines(e))
    unit = document.header.get("$INSUNITS", 0)
    return Drawing(found, float(units.conversion_factor(unit, 6)) if unit else None)


def _outlines(entity: Any) -> tuple[Outline, ...]:
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        corners = [(complex(x, y), b) for x, y, b in entity.get_points("xyb")]
        closed = bool(entity.closed)
    elif kind == "POLYLINE" and entity.is_2d_polyline:
        places = [(v.dxf.location, v.dxf.get("bulge", 0.0)) for v in entity.vertices]
        corners = [(complex(p.x, p.y), b) for p, b in places]
        closed = bool(entity.is_closed)
    elif kind == "CIRCLE":
        centre, radius = complex(entity.dxf.center.x, entity.dxf.center.y), entity.dxf.radius
        corners, closed = [(centre - radius, 1.0), (centre + radius, 1.0)], True
    else:
        return ()
    if entity.dxf.extrusion.z < 0:  # it is seen from behind
        corners = [(-z.conjugate(), -b) for z, b in corners]
    ends = corners[1:] + corners[:1]
    if not closed:
        size = max((abs(z - corners[0][0]) for z, _ in corners), default=0.0)
        closed = len(corners) > 2 and abs(corners[-1][0] - corners[0][0]) <= 1e-9 * size
        ends = ends[:-1]
    pieces = tuple(arc(a, b, bulge) for (a, bulge), (b, _) in zip(corners, ends, strict=False))
    return (Outline(str(entity.dxf.handle), pieces, closed),) if pieces else ()
