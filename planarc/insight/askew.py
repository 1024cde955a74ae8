"""Slides between the same two parts whose directions differ: together they hold these in place.

In:   Dae, Mechanism
Out:  a message about two such slides, with the angle between their directions

A slide keeps the angle between what it joins, so that `n` has one meaning at both its ends. Where a
part around the slides has an `angle`, by which it may turn axes as a `FixedRotation` does, nothing
is said.

Example: two rails with n={1, 0} and n={1, 0.05} differ by 2.86 degrees.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import atan2, degrees, pi

from planarc.core.options import ACCEPTING
from planarc.core.prose import both
from planarc.core.source import Span
from planarc.evaluate.declared import DeclaredValues
from planarc.insight.connectors import owner
from planarc.ir.dae import Dae
from planarc.ir.mechanism import Joint, Mechanism
from planarc.ir.places import own_names, own_part

#: Radians below which two directions are one.
_PARALLEL = 1e-6


def find_askew(dae: Dae, mechanism: Mechanism) -> tuple[str, Span | None, str] | None:
    """A sentence about the first slides that hold the same two parts and are not parallel, the
    place of the second one, and what to do."""
    directions = dict(_directions(dae, mechanism))
    for first, second in combinations(directions, 2):
        turned = abs(directions[first] - directions[second]) % pi
        angle = min(turned, pi - turned)
        if first.links == second.links and angle > _PARALLEL:
            names = own_names(dae, (first.name, second.name))
            part = own_part(dae, second.name)
            return (
                f"the directions of {both(names)} differ by {degrees(angle):.3g} degrees, so that "
                "what they join cannot move",
                part.span if part else None,
                f"leave one out, or give them one direction, which is accepted with {ACCEPTING}",
            )
    return None


def _directions(dae: Dae, mechanism: Mechanism) -> Iterator[tuple[Joint, float]]:
    """The slides between two links that turn no axes, with the angles of their directions."""
    values, table = DeclaredValues(dae), dae.table
    known, moved = {p.name for p in dae.parameters}, {v.name for v in dae.variables}
    turning = {owner(name) for name in known if name.endswith(".angle")}
    for joint in mechanism.joints:
        names = [f"{joint.name}.n[{i}]" for i in (1, 2)]
        around = (owner(f) for i in joint.links for f in mechanism.links[i].frames)
        if len(joint.links) != 2 or f"{joint.name}.s" not in moved or not known.issuperset(names):
            continue
        if turning.isdisjoint(around):
            try:
                x, y = (values(table.symbol(name)) for name in names)
            except (KeyError, ArithmeticError, ValueError):
                continue
            yield joint, atan2(y, x)
