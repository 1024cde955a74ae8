"""Connections that were copied, of which not all was changed.

In:   Dae
Out:  a warning S323, at the connection; also a note where something else tells of it

Two parts of a class are connected to the same frame of a third one, by the same frame of theirs;
another part of that one's class has no such part at that frame, and its name goes with that of one
of the two: `bore2` with `piston2`. By itself this is told where it shows that something lacks: the
frame of the other part is open, or the two are springs between the same two points.

So it is with signals: two controllers read `encoder1.phi`, and nothing reads `encoder2.phi`.

Example: `connect(bore2.frame_b, piston1.frame_a)`, where `piston2` was meant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, takewhile

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.prose import both
from planarc.insight.connectors import owner
from planarc.ir.dae import Dae
from planarc.ir.expr import symbols
from planarc.ir.flat import Connect
from planarc.ir.places import declared_part, is_own

#: Letters that two names must have in common at their beginning to go together.
_STEM = 4
#: Parts of a class at one frame, at most, of which one may be too many there.
_FEW = 4


class _Twice(Data):
    """Two connections to one frame, of which the second was to lead to `meant`."""

    first: Connect
    second: Connect
    ends: tuple[str, str]  # of the two parts
    there: str
    meant: str


def find_copied(dae: Dae) -> Diagnostic | None:
    """What is told of the first such connection, where anything is wrong."""
    found = next(_all(dae), None)
    return None if found is None else _told(found)


def copied_connections(dae: Dae) -> Iterator[Diagnostic]:
    """The warnings of those that lack something for certain."""
    joined = {n for names in dae.connections if len(names) > 1 for n in names}
    joined |= {n for c in dae.signals for n in (c.left, c.right)}
    together = {n: k for k, names in enumerate(dae.connections) for n in names}
    for found in _all(dae):
        beside = [_other_ends(dae, end) for end in found.ends]
        parallel = any(
            a in together and together[a] == together.get(b) for a in beside[0] for b in beside[1]
        )
        if parallel or (found.meant not in joined and not _is_read(dae, found.meant)):
            yield _told(found)


def _is_read(dae: Dae, name: str) -> bool:
    """Whether an equation of the user's reads a signal."""
    own = (e for e in dae.equations if not e.generated and is_own(dae, e.span))
    return any(symbol.name == name for e in own for symbol in symbols(e.left, e.right))


def _told(found: _Twice) -> Diagnostic:
    end = found.ends[1]
    return Diagnostic(
        "S323",
        f"{both(found.ends)} are connected to `{found.there}`, and no such part to `{found.meant}`",
        found.second.span,
        Severity.WARNING,
        hint=f"write `connect({end}, {found.meant});`, if that is meant",
        related=(Related("the other one", found.first.span),),
    )


def _all(dae: Dae) -> Iterator[_Twice]:
    classes = {p.name: p.class_name for p in dae.parts}
    at: dict[str, list[tuple[str, Connect]]] = {}
    pairs = set[frozenset[str]]()
    for connect in (*dae.connects, *dae.signals):
        if is_own(dae, connect.span):
            at.setdefault(connect.left, []).append((connect.right, connect))
            at.setdefault(connect.right, []).append((connect.left, connect))
            pairs.add(frozenset((owner(connect.left), owner(connect.right))))
    alike: dict[str, list[str]] = {}
    for name, kind in classes.items():
        alike.setdefault(kind, []).append(name)
    for there, others in at.items():
        part, _, frame = there.rpartition(".")
        pairs_there = [*_of_one_kind(others, classes)]
        siblings = alike.get(classes.get(part, ""), ()) if pairs_there else ()
        # What is inside of a part of the library is connected there.
        siblings = [s for s in siblings if s != part and declared_part(dae, s)]
        for one, two in pairs_there:
            for kept, moved in ((one, two), (two, one)):
                for sibling in siblings:
                    meant = f"{sibling}.{frame}"
                    kinds = [_kind(name, classes) for name, _ in at.get(meant, ())]
                    apart = frozenset((sibling, owner(moved[0]))) not in pairs
                    names = (owner(kept[0]), owner(moved[0]), part, sibling)
                    if apart and _kind(moved[0], classes) not in kinds and _match(*names):
                        ends = (kept[0], moved[0])
                        yield _Twice(kept[1], moved[1], ends, there, meant)


def _of_one_kind(
    others: Sequence[tuple[str, Connect]], classes: Mapping[str, str]
) -> Iterator[tuple[tuple[str, Connect], tuple[str, Connect]]]:
    """Each two of few frames that are of one name, and of parts of one class."""
    kinds: dict[tuple[str, str], list[tuple[str, Connect]]] = {}
    for name, connect in others:
        kinds.setdefault(_kind(name, classes), []).append((name, connect))
    for found in kinds.values():
        for one, two in combinations(found, 2) if len(found) <= _FEW else ():
            if owner(one[0]) != owner(two[0]):
                yield one, two


def _kind(end: str, classes: Mapping[str, str]) -> tuple[str, str]:
    return classes.get(owner(end), ""), end.rpartition(".")[2]


def _match(kept: str, moved: str, part: str, sibling: str) -> bool:
    """Whether the names of two parts go with those of what they are to be connected to: by what
    tells them apart, as in `bore2` and `piston2`, or by how they begin, in letters of any size:
    `rearHub` goes with `toRear`."""
    kept, moved, part, sibling = (name.lower() for name in (kept, moved, part, sibling))
    one, two = _ways_apart(kept, moved)
    here, there = _ways_apart(part, sibling)
    if two and there and _begins(two, there) and _begins(one, here):
        return True
    stem = _common(moved, sibling)
    return stem >= _STEM and stem > _common(moved, part)


def _ways_apart(one: str, two: str) -> tuple[str, str]:
    """What is left of two names without the beginning that they have in common."""
    stem = _common(one, two)
    return one[stem:], two[stem:]


def _common(one: str, two: str) -> int:
    """The letters with which both begin."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, two, strict=False)))


def _begins(one: str, two: str) -> bool:
    return one.startswith(two) or two.startswith(one)


def _other_ends(dae: Dae, end: str) -> list[str]:
    """The other frames of a part of which one is given."""
    part = owner(end)
    return list(
        dict.fromkeys(
            n for names in dae.connections for n in names if owner(n) == part and n != end
        )
    )
