"""Equal statements brought together, so that more of them become loops.

In:   numbers: the kind of each statement, and the statements that it must stand behind
Out:  an order of the statements that keeps all of that

Parts that are equal may be written far from each other, or interleaved. First equal statements that
can be computed at the same time make a pack each; then packs whose members read each other, time by
time, make a group. A group is written time by time, as `rolling` finds it:

    a1 := f(x1)               pack a1 a2         a1 := f(x1)
    b  := h(x1)       ->      pack b       ->    c1 := g(a1)
    a2 := f(x2)               pack c1 c2         a2 := f(x2)
    c1 := g(a1)                                  c2 := g(a2)
    c2 := g(a2)               group a, c         b  := h(x1)

Promises:  each statement stands behind those that it must stand behind. The same numbers give the
           same order.
Reference: S. Larsen, S. Amarasinghe, Exploiting superword level parallelism with multimedia
           instruction sets, PLDI 2000 (packs); here their members may be any number.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from heapq import heapify, heappop, heappush

Before = Sequence[Sequence[int]]


def gather(kinds: Sequence[int], before: Before) -> list[int]:
    """The order, as places in the given one."""
    after = _reversed(before)
    groups = _Groups(_pack(kinds, before, after), before, after)
    groups.merge()
    return groups.in_order()


def _reversed(before: Before) -> list[list[int]]:
    after: list[list[int]] = [[] for _ in before]
    for i, found in enumerate(before):
        for b in found:
            after[b].append(i)
    return after


def _pack(kinds: Sequence[int], before: Before, after: Before) -> list[list[int]]:
    """Equal statements that are due at the same time. Kinds wait until all of them are due, as long
    as another kind has no need to wait."""
    waits = [len(b) for b in before]
    left = Counter(kinds)
    due: dict[int, list[int]] = {}
    for i, n in enumerate(waits):
        if not n:
            due.setdefault(kinds[i], []).append(i)
    packs = []
    while due:
        kind = min(due, key=lambda k: (len(due[k]) < left[k], -len(due[k]), due[k][0]))
        pack = sorted(due.pop(kind))
        left[kind] -= len(pack)
        packs.append(pack)
        for i in pack:
            for a in after[i]:
                waits[a] -= 1
                if not waits[a]:
                    due.setdefault(kinds[a], []).append(a)
    return packs


class _Groups:
    """Packs that are written together; at first each alone. A statement has its `group` and its
    `time`."""

    def __init__(self, packs: Sequence[list[int]], before: Before, after: Before) -> None:
        self._packs, self._before, self._after = packs, before, after
        self._members = [[p] for p in range(len(packs))]  # the packs of each group, in their order
        self._times = [len(pack) for pack in packs]  # of each group, which merging keeps
        self._group, self._time = [0] * len(before), [0] * len(before)
        for p, pack in enumerate(packs):
            for time, i in enumerate(pack):
                self._group[i], self._time[i] = p, time
        group = self._group
        self._behind = [{group[a] for i in pack for a in after[i]} for pack in packs]
        self._ahead = [{group[b] for i in pack for b in before[i]} for pack in packs]

    def merge(self) -> None:
        """Those that read each other, most often first, until none may be merged any more."""
        group, times, changed = self._group, self._times, True
        pairs = [
            (b, i)
            for i, found in enumerate(self._before)
            if (here := times[group[i]]) > 1
            for b in found
            if times[group[b]] == here
        ]
        while changed:
            changed = False
            links = Counter((group[b], group[i]) for b, i in pairs)
            for (g, h), _ in sorted(links.items(), key=lambda link: (-link[1], link[0])):
                changed |= bool(self._members[g] and self._members[h]) and self._merged(g, h)

    def _statements(self, group: int) -> Iterator[int]:
        return (i for p in self._members[group] for i in self._packs[p])

    def _merged(self, g: int, h: int) -> bool:
        """Whether `h`, which stands there as often, became a part of `g`."""
        times = None if g == h else self._fitting(g, h)
        if times is None or self._leads(g, h) or self._leads(h, g):
            return False
        for i in self._statements(h):
            self._group[i], self._time[i] = g, times[self._time[i]]
        for p in self._members[h]:
            self._packs[p].sort(key=self._time.__getitem__)
        self._members[g] = sorted(self._members[g] + self._members[h])
        self._members[h] = []
        for to, back in ((self._behind, self._ahead), (self._ahead, self._behind)):
            for other in to[h]:
                back[other] = back[other] - {h} | {g}
            to[g] = (to[g] | to[h]) - {g, h}
        return True

    def _fitting(self, g: int, h: int) -> list[int] | None:
        """The time in `g` of each time in `h`, where no time reads another one."""
        found: dict[int, int] = {}
        for i in self._statements(h):
            for other in (*self._before[i], *self._after[i]):
                at = self._time[other]
                if self._group[other] == g and found.setdefault(self._time[i], at) != at:
                    return None
        rest = sorted(set(range(self._times[g])).difference(found.values()))
        if len(found) + len(rest) != self._times[g]:
            return None
        unread = iter(rest)
        return [found[t] if t in found else next(unread) for t in range(self._times[h])]

    def _leads(self, first: int, last: int) -> bool:
        """Whether a way of reading goes from one group to another by way of a third one."""
        todo = list(self._behind[first] - {last})
        seen = {first, *todo}
        while todo:
            behind = self._behind[todo.pop()]
            if last in behind:
                return True
            todo += behind - seen
            seen |= behind
        return False

    def in_order(self) -> list[int]:
        """Group by group, each as early as it was written."""
        first = {g: min(self._statements(g)) for g, packs in enumerate(self._members) if packs}
        waits = {g: len(self._ahead[g]) for g in first}
        due = [(first[g], g) for g in first if not waits[g]]
        heapify(due)
        order: list[int] = []
        while due:
            _, g = heappop(due)
            for time in range(self._times[g]):
                order += [self._packs[p][time] for p in self._members[g]]
            for a in self._behind[g]:
                waits[a] -= 1
                if not waits[a]:
                    heappush(due, (first[a], a))
        return order
