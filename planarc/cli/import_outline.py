"""`planarc import outline`: a path of a drawing as the corners of a contour."""

from __future__ import annotations

from enum import StrEnum
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.files import check_writable
from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import refused, usage_error

if TYPE_CHECKING:
    from planarc.catalog.outline.piece import Drawing

#: Units that drawings have, and models have not.
_OTHERS = {"in": 0.0254, "ft": 0.3048}


class What(StrEnum):
    """What can be imported."""

    OUTLINE = "outline"


def length(text: str) -> float:
    """The number of m of `0.001` and of `1mm`. Raises ValueError."""
    from planarc.core.quantity import in_unit

    try:
        found = float(text)
    except ValueError:
        found = in_unit("--tolerance", text, "m") or 0.0
    if not (isfinite(found) and found > 0):
        raise ValueError(f"`{text}` is no length above 0")
    return found


def import_outline(
    what: Annotated[What, Argument(metavar="outline", help="What is imported.")],
    file: Annotated[Path, Argument(metavar="FILE", help="An SVG or a DXF.")],
    name: Annotated[
        str | None,
        Option("--id", metavar="NAME|NUMBER", help="Which outline, where there are several."),
    ] = None,
    unit: Annotated[
        str | None,
        Option(help="The unit of the drawing: mm, in ...; else what the file says."),
    ] = None,
    tolerance: Annotated[
        float | None,
        Option(
            metavar="LENGTH",
            parser=length,
            help="How far straight sides may be from curves, in m or as 0.1mm; else a thousandth "
            "of the larger side.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="FILE.pmo", help="Write it there, not here."),
    ] = None,
) -> int:
    """Turn a drawn outline into a contour.

    An SVG has paths and shapes, a DXF polylines and circles; this needs planarc[cad]. The corners
    are in metres, counter-clockwise, for Contacts.Polygon contour1(vertices=NAME.vertices).
    """
    from planarc.catalog.outline.choose import choose
    from planarc.catalog.outline.corners import hollow, polygon
    from planarc.catalog.outline.text import class_name, class_text

    size = None if unit is None else _size(unit)
    if output is not None:
        from planarc.view.storage import with_ending

        output = with_ending(output, ".pmo")
        check_writable(output, "--output")
    drawing = _read(file)
    outline = choose(drawing, str(file), name)
    metre = size or drawing.metre
    if metre is None:
        hint = "give its unit: `--unit mm`"
        raise usage_error("C177", f"`{file}` does not say how long its unit is", hint=hint)
    shape = polygon(outline, metre, tolerance)
    found = hollow(shape, outline)
    console.complain([found] if found else ())
    told = f"Outline {outline.name} of {file.name}" if outline.name else f"Outline of {file.name}"
    text = class_text(class_name(file.stem, output.stem if output else None), told, shape)
    if output is None:
        console.say(text.rstrip("\n"))
    else:
        from planarc.view.storage import write_text

        write_text(output, text)
        console.say(f"wrote {output}")
    return 0


def _read(file: Path) -> Drawing:
    from planarc.catalog.outline.dxf import read_dxf
    from planarc.catalog.outline.svg import read_svg

    readers = {".svg": read_svg, ".dxf": read_dxf}
    reader = readers.get(file.suffix.lower())
    if file.is_dir():
        raise usage_error("C102", f"`{file}` is a folder", hint="give an SVG or a DXF in it")
    if not file.exists():
        raise usage_error("C101", f"there is no file `{file}`", hint="check the path")
    if reader is None:
        hint = "save the drawing as `.svg` or `.dxf`"
        raise usage_error("C171", f"`{file}` is neither an SVG nor a DXF", hint=hint)
    try:
        return reader(file)
    except OSError as problem:
        raise refused("C108", f"cannot read `{file}`", problem) from None


def _size(unit: str) -> float:
    from planarc.core.quantity import in_unit

    found = _OTHERS.get(unit) or in_unit("--unit", f"1 {unit}", "m")
    if not found:
        raise usage_error("C115", f"`--unit {unit}` is no unit", hint="use `mm`, `cm`, `m` or `in`")
    return found
