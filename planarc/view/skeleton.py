"""The picture of a mechanism that draws nothing itself: its links and joints.

In:   Result with its mechanism, and its rigid groups
Out:  items: a plate through the frames of a link, a pin at each joint

Used only where no component has a visual of its own, as in a library without pictures or with
`enableAnimation=false`.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.ir.result import Result
from planarc.view.item import Item, Kind
from planarc.view.linkage.groups import Groups
from planarc.view.linkage.palette import JOINT
from planarc.view.linkage.plates import plate

_PIN, _LUMP = 0.62, 2.0  # in units


def skeleton(result: Result, groups: Groups | None) -> list[Item]:
    """Links and joints; none where the result holds no positions of frames."""
    if groups is None:
        return []
    unit = groups.unit(groups.size)
    plates = [
        plate(g, (), unit * (1.0 if len(g.points) > 1 else _LUMP), g.color, ())
        for g in groups.all.values()
    ]
    return sorted([*plates, *_joints(result, groups, _PIN * unit)], key=lambda item: item.height)


def _joints(result: Result, groups: Groups, width: float) -> Iterator[Item]:
    mechanism = result.program.mechanism
    for joint in mechanism.joints if mechanism else ():
        for x, y, depth in groups.places(joint.frames):
            yield Item(
                joint.name, Kind.SHAPE, x, y, 0.0, 0.0, width, JOINT, depth + 0.5,
                shape="pin", upright=True,
            )  # fmt: skip
