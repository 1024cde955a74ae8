"""One flat shape for a rigid group: a disc, a bar with round ends, or a rounded plate.

In:   Group, more points of it (centres of mass, travel of slides)
Out:  Item   of shape `plate`: the corners of the convex hull, in the axes of the group

Example: three joints at (0, 0), (1, 0), (0.5, 0.4) and a centre of mass between them give a
triangle with round corners.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from planarc.view.item import Item, Kind
from planarc.view.linkage.groups import Group, Place, reach
from planarc.view.linkage.palette import Color


def plate(
    group: Group, more: Iterable[Place], width: float, color: Color, parts: tuple[str, ...]
) -> Item:
    """The shape of a group, `width` wide where it is a bar."""
    corners = hull((*group.points, *more), 0.02 * width)
    return Item(
        group.name, Kind.SHAPE, group.x, group.y, group.angle, reach(corners), width, color,
        float(group.depth), shape="plate", upright=True, points=corners, parts=parts,
    )  # fmt: skip


def hull(points: Iterable[Place], slack: float = 0.0) -> tuple[Place, ...]:
    """The corners of the convex hull, counter-clockwise; those within `slack` of an edge are
    left out.

    Reference: A. M. Andrew, Information Processing Letters 9(5), 1979, 216-219.
    """
    places = {(float(x), float(y)): (x, y) for x, y in points}
    ordered = [places[place] for place in sorted(places)]
    if reach(ordered) <= slack:
        return tuple(ordered[:1])
    if len(ordered) < 3:
        return tuple(ordered)
    corners = [*_chain(ordered, slack), *_chain(ordered[::-1], slack)]
    return tuple(dict.fromkeys(corners))


def _chain(points: Iterable[Place], slack: float) -> list[Place]:
    """The lower side of the hull of points from left to right."""
    chain: list[Place] = []
    for point in points:
        while len(chain) > 1 and not _turns_left(chain[-2], chain[-1], point, slack):
            chain.pop()
        chain.append(point)
    return chain


def _turns_left(a: Place, b: Place, c: Place, slack: float) -> bool:
    """True if b lies more than `slack` to the right of the way from a to c."""
    dx, dy = c[0] - a[0], c[1] - a[1]
    across = dx * (b[1] - a[1]) - dy * (b[0] - a[0])
    return -across > slack * max(math.hypot(dx, dy), 1e-300)
