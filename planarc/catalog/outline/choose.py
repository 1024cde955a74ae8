"""The outline that is meant, of all in a drawing."""

from __future__ import annotations

from planarc.catalog.outline.corners import extent
from planarc.catalog.outline.piece import Drawing, Outline
from planarc.core.diagnostic import usage_error
from planarc.core.nearest import nearest
from planarc.core.prose import either, shortened

#: So many outlines are named in a message.
MOST = 8


def choose(drawing: Drawing, file: str, wanted: str | None) -> Outline:
    """The outline of this name or number, or the only one. Raises UsageError C172, C173."""
    found = dict(enumerate(drawing.outlines, 1))
    if not found:
        hint = "draw a path in an SVG, a polyline or a circle in a DXF"
        raise usage_error("C172", f"`{file}` holds no outline", hint=hint)
    if wanted is not None:
        named = {n: o for n, o in found.items() if o.name == wanted}
        if not named and wanted.isdecimal() and int(wanted) in found:
            return found[int(wanted)]
        if not named:
            names = [o.name for o in drawing.outlines if o.name]
            near = nearest(wanted, names)
            told = f"did you mean {either(near)}?" if near else f"give a number up to {len(found)}"
            raise usage_error("C173", f"`{file}` has no outline `{wanted}`", hint=told)
        found = named
    if len(found) == 1:
        return next(iter(found.values()))
    told = shortened([f"{n}{_told(o)}" for n, o in found.items()], MOST)
    number, first = next(iter(found.items()))
    names = [o.name for o in found.values()]
    short = first.name if first.name and names.count(first.name) == 1 else number
    hint = f"choose one, such as `--id {short}`"
    raise usage_error("C173", f"`{file}` holds {len(found)} outlines: {told}", hint=hint)


def _told(outline: Outline) -> str:
    named = f"`{outline.name}`, " if outline.name else ""
    return f" ({named}{extent(outline):.4g} units)"
