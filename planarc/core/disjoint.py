"""Disjoint sets (union-find) that keep the order in which their members came."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)


class DisjointSets(Generic[Key]):
    def __init__(self, keys: Iterable[Key] = ()) -> None:
        self._parent = {key: key for key in keys}

    def __contains__(self, key: Key) -> bool:
        return key in self._parent

    def add(self, key: Key) -> bool:
        """Add a key; true when it is new."""
        if key in self._parent:
            return False
        self._parent[key] = key
        return True

    def find(self, key: Key) -> Key:
        """The member that stands for the set of a key."""
        root = key
        while self._parent[root] != root:
            root = self._parent[root]
        while self._parent[key] != root:
            self._parent[key], key = root, self._parent[key]
        return root

    def join(self, a: Key, b: Key) -> bool:
        """Join the sets of two keys; true when they were two. The member for `a` stays that."""
        self.add(a)
        self.add(b)
        first, second = self.find(a), self.find(b)
        self._parent[second] = first
        return first != second

    def sets(self) -> list[list[Key]]:
        """All sets; sets and members in the order in which they came."""
        found: dict[Key, list[Key]] = {}
        for key in self._parent:
            found.setdefault(self.find(key), []).append(key)
        return list(found.values())
