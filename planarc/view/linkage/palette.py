"""The colours of the bodies: quiet, told apart by eyes that mix up red and green, and in grey.

Light and dark ones take turns, so that neighbours differ where there is no colour at all; the
first three, of a loop of three bars, are dark, light and darker.
Forces (red) and joints (grey) have colours of their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from planarc.ir.insight import Track

Color: TypeAlias = "tuple[Track, Track, Track]"

BODIES: tuple[tuple[float, float, float], ...] = (
    (104.0, 153.0, 204.0),  # blue
    (228.0, 198.0, 128.0),  # sand
    (72.0, 140.0, 126.0),  # teal
    (176.0, 216.0, 232.0),  # sky
    (122.0, 96.0, 192.0),  # violet
    (200.0, 210.0, 76.0),  # olive
    (140.0, 116.0, 88.0),  # brown
)
JOINT = (70.0, 78.0, 90.0)
FORCE = (192.0, 54.0, 44.0)
#: What stands still: bearings, and curves of the ground.
GROUND, BED = (110.0, 110.0, 110.0), (205.0, 209.0, 215.0)

#: Colours of `Types.Defaults` that leave the choice to the picture: of bodies, rods and curves.
LEFT_OPEN = frozenset(((31.0, 119.0, 180.0), (148.0, 158.0, 170.0), (120.0, 80.0, 170.0)))


def is_open(color: Color) -> bool:
    """True for a colour that nobody chose."""
    return all(isinstance(c, (int, float)) for c in color) and color in LEFT_OPEN


def paint(
    numbers: Iterable[int], neighbours: Mapping[int, set[int]]
) -> dict[int, tuple[float, float, float]]:
    """A colour for each number, in turn, but none that a neighbour has already."""
    chosen: dict[int, int] = {}
    for turn, number in enumerate(numbers):
        taken = {chosen[n] for n in neighbours.get(number, ()) if n in chosen}
        wishes = ((turn + i) % len(BODIES) for i in range(len(BODIES)))
        chosen[number] = next((w for w in wishes if w not in taken), turn % len(BODIES))
    return {number: BODIES[i] for number, i in chosen.items()}
