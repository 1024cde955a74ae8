"""A polygon as a class of the language, for a file or to be pasted into one."""

from __future__ import annotations

import re

from planarc.catalog.outline.corners import Polygon


def class_name(drawing: str, written: str | None = None) -> str:
    """The name of a class from that of its drawing, or that of its own file where it can be one."""
    if written and written.isascii() and written.isidentifier():
        return written
    stem = written or drawing
    words = re.sub(r"\W", "_", stem, flags=re.ASCII)
    return words[:1].upper() + words[1:] if words[:1].isalpha() else f"Outline_{words}"


def class_text(name: str, description: str, shape: Polygon) -> str:
    """A package whose constant `vertices` is a row a corner, in m."""
    width, height = shape.size
    x, y = shape.centre
    told = description.replace("\\", "\\\\").replace('"', '\\"')
    rows = ";\n".join(f"    {_number(x)}, {_number(y)}" for x, y in shape.corners.tolist())
    return (
        f'package {name} "{told}"\n'
        f"  // {width:.6g} m by {height:.6g} m, counter-clockwise; "
        f"curves to {shape.tolerance:.3g} m.\n"
        f"  // Area {shape.area:.6g} m2, its centre at {{{x:.6g}, {y:.6g}}} m.\n"
        f"  constant Modelica.Units.SI.Position vertices[{len(shape.corners)},2]=[\n{rows}]\n"
        '    "Corners of the outline";\n'
        f"end {name};\n"
    )


def _number(value: float) -> str:
    return f"{value:.9g}"
