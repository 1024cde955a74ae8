"""Icons, read from annotations.

In:   the arguments of a class annotation, or of a component's
Out:  Graphic, Placement

Only numbers, names and strings are understood; a primitive that is computed
(`DynamicSelect`, a condition) is drawn as far as its parts are constant.

Reference: Modelica Language Specification 3.6, section 18.6.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

from planarc.catalog.handbook.pages import Color, Graphic, Icon, Placed, Point
from planarc.flatten.tree.annotation import binding_of, find_argument, inside
from planarc.ir import syntax

Arguments: TypeAlias = tuple[syntax.Argument, ...]
Constant: TypeAlias = "float | str | bool | tuple[Constant, ...] | None"

_SHAPES = {
    "Line": "line",
    "Polygon": "polygon",
    "Rectangle": "rectangle",
    "Ellipse": "ellipse",
    "Text": "text",
}


def graphics_of(annotation: Arguments) -> tuple[Graphic, ...]:
    """The primitives of `Icon(graphics={...})`, but for texts about an instance (`%name`)."""
    value = binding_of(find_argument(inside(find_argument(annotation, "Icon")), "graphics"))
    if not isinstance(value, syntax.Array):
        return ()
    return tuple(
        graphic
        for item in value.items
        if isinstance(item, syntax.Call)
        for graphic in _graphic(item)
    )


def placed(annotation: Arguments, icon: Icon) -> Placed | None:
    """A connector's icon at the place that its declaration gives."""
    placement = inside(find_argument(annotation, "Placement"))
    shift = inside(find_argument(placement, "iconTransformation")) or inside(
        find_argument(placement, "transformation")
    )
    extent = _points(constant(binding_of(find_argument(shift, "extent"))))
    if len(extent) != 2:
        return None
    origin = _points((constant(binding_of(find_argument(shift, "origin"))),))
    rotation = constant(binding_of(find_argument(shift, "rotation")))
    return Placed(
        icon.graphics,
        (extent[0], extent[1]),
        origin[0] if origin else (0.0, 0.0),
        rotation if isinstance(rotation, float) else 0.0,
    )


def _graphic(call: syntax.Call) -> Iterator[Graphic]:
    shape = _SHAPES.get(str(call.function))
    given = {n.name: constant(n.value) for n in call.named}
    text = given.get("textString")
    if shape is None or (isinstance(text, str) and "%" in text):
        return
    points = _points(given.get("points" if shape in ("line", "polygon") else "extent"))
    origin = _points((given.get("origin"),))
    x, y = origin[0] if origin else (0.0, 0.0)
    line = _color(given, "color" if shape == "line" else "lineColor") or (0, 0, 0)
    if shape == "text":
        line = _color(given, "textColor") or line
    fill = _color(given, "fillColor") or (0, 0, 0)
    pattern = given.get("fillPattern", "None")
    width = given.get("thickness", given.get("lineThickness"))
    radius = given.get("radius")
    yield Graphic(
        shape,
        tuple((px + x, py + y) for px, py in points),
        line,
        None if pattern == "None" else fill,
        width if isinstance(width, float) else 0.25,
        given.get("pattern") in ("Dash", "Dot", "DashDot", "DashDotDot"),
        radius if isinstance(radius, float) else 0.0,
        text if isinstance(text, str) else "",
        given.get("smooth") == "Bezier",
        _arrows(given.get("arrow")),
    )


def _arrows(value: Constant) -> tuple[bool, bool]:
    if not isinstance(value, tuple) or len(value) != 2:
        return False, False
    first, last = (v not in (None, "None") for v in value)
    return first, last


def constant(expression: syntax.Expression | None) -> Constant:
    """The value of a literal; a dotted name gives its last part; None for all else."""
    match expression:
        case syntax.Boolean() | syntax.String():
            return expression.value
        case syntax.Integer() | syntax.Real():
            return float(expression.value)
        case syntax.Unary(op="-"):
            value = constant(expression.operand)
            return -value if isinstance(value, float) else None
        case syntax.Array():
            return tuple(constant(item) for item in expression.items)
        case syntax.Ref():
            return expression.names[-1]
    return None


def _points(value: Constant) -> tuple[Point, ...]:
    if not isinstance(value, tuple):
        return ()
    found = []
    for pair in value:
        if isinstance(pair, tuple) and len(pair) == 2:
            x, y = pair
            if isinstance(x, float) and isinstance(y, float):
                found.append((x, y))
    return tuple(found)


def _color(given: Mapping[str, Constant], name: str) -> Color | None:
    value = given.get(name)
    if not isinstance(value, tuple) or len(value) != 3:
        return None
    r, g, b = (int(c) if isinstance(c, float) else 0 for c in value)
    return r, g, b
