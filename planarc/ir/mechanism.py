"""The mechanism behind a model: links, and the joints that hold them together.

Given by `insight`, kept with the program, shown by `cli` and `view`.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.ir.once import once

#: The number of the link that does not move.
GROUND = 0
#: Names of joints' coordinates, and of their derivatives.
POSITIONS, SPEEDS = ("phi", "s"), ("w", "v")


class Link(Data):
    """A part of the mechanism that moves as one piece. `frames` are full names of connectors.

    `free` is what it could do alone: 3, or 2 for a point whose angle nothing asks for; 0 is
    the ground.
    """

    name: str
    frames: tuple[str, ...]
    free: int = 3


class Joint(Data):
    """A component that holds links together, by so many conditions on their positions.

    `count` is the number of elementary joints that it stands for, more than 1 for an assembly.
    """

    name: str
    conditions: int
    count: int
    links: tuple[int, ...]  # without repetition, ascending
    frames: tuple[str, ...]


class Mechanism(Data):
    """`links[0]` is the ground, present or not. Links that nothing holds are listed, too.

    `locked` is what to say if it turns out that nothing moves; None where by count something does.
    `copied` is a connection that may have been copied, to be told where something is wrong.
    `bridged` are joints whose frames other parts hold together; `passive` are those with flanges
    that nothing drives. `inside` are components that hold nothing, between two frames of one link;
    `standing` are frames that their own components hold, as that of the world; `spare` are
    components of such, to which nothing is connected.
    """

    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    locked: Diagnostic | None = None
    bridged: tuple[str, ...] = ()
    passive: tuple[str, ...] = ()
    inside: tuple[str, ...] = ()
    standing: tuple[str, ...] = ()
    spare: tuple[str, ...] = ()
    copied: Diagnostic | None = None

    def with_copied(self, found: Diagnostic) -> Diagnostic:
        """A message about joints, with the connection that may be why."""
        if self.copied is None:
            return found
        note = Related(self.copied.message, self.copied.span)
        related = (note, *self.copied.related, *found.related)
        return replace(found, hint=self.copied.hint, related=related)

    @property
    def bodies(self) -> int:
        return len(self.links) - 1

    @property
    def pairs(self) -> int:
        """The number of elementary joints."""
        return sum(joint.count for joint in self.joints)

    @property
    def mobility(self) -> int:
        """The mobility by count, after Gruebler: motions of all links, less all conditions."""
        free = sum(link.free for link in self.links)
        return free - sum(joint.conditions for joint in self.joints)

    def joints_at(self, components: Collection[str]) -> list[str]:
        """The joints of the moving links that have frames in some components."""
        own = {
            i
            for i, link in enumerate(self.links)
            if i != GROUND and any(f.rpartition(".")[0] in components for f in link.frames)
        }
        return [joint.name for joint in self.joints if not own.isdisjoint(joint.links)]

    def shortest_loop(
        self, joint: Joint, most: float = math.inf, paired: bool = False
    ) -> tuple[Joint, ...]:
        """A joint and the fewest others, in all so many at most, that lead from one of its links
        to the other; none where it is in no such loop. `paired`: by joints of two links alone,
        and not by gears, say, whose third link carries them."""
        if len(joint.links) != 2:
            return ()
        on_link = _on_links(self)
        first, last = joint.links
        ways: dict[int, tuple[Joint, ...]] = {first: (joint,)}
        front = [first]
        for at in front:
            if last in ways or len(ways[at]) >= most:
                break
            for other in on_link[at]:
                if other is not joint and (len(other.links) == 2 or not paired):
                    for link in other.links:
                        if link not in ways:
                            ways[link] = (*ways[at], other)
                            front.append(link)
        return ways.get(last, ())

    @property
    def loops(self) -> int:
        """Independent loops: the cycles of the graph of links and joints (Euler)."""
        from planarc.core.disjoint import DisjointSets

        joined = DisjointSets(range(len(self.links)))
        merged = sum(joined.join(j.links[0], other) for j in self.joints for other in j.links[1:])
        return self.pairs - merged


@once
def _on_links(mechanism: Mechanism) -> dict[int, list[Joint]]:
    """The joints of each link."""
    found: dict[int, list[Joint]] = {}
    for joint in mechanism.joints:
        for link in dict.fromkeys(joint.links):
            found.setdefault(link, []).append(joint)
    return found


class Mobility(Data):
    """`dependent` conditions follow from others at the start; `redundant` names their joints
    where they do so in every position."""

    count: int
    dependent: int
    redundant: Diagnostic | None = None

    @property
    def rank(self) -> int:
        """Degrees of freedom by the rank of the Jacobian."""
        return self.count + self.dependent
