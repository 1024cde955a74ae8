"""Disjoint sets keep the order of their members, and say what a join did."""

from __future__ import annotations

from planarc.core.disjoint import DisjointSets


def test_sets_come_in_the_order_of_their_first_members() -> None:
    sets = DisjointSets(range(6))
    assert [sets.join(4, 1), sets.join(3, 0), sets.join(1, 5), sets.join(5, 4)] == [
        True,
        True,
        True,
        False,
    ]
    assert sets.sets() == [[0, 3], [1, 4, 5], [2]]


def test_the_first_of_a_join_stands_for_the_set() -> None:
    sets: DisjointSets[str] = DisjointSets()
    sets.join("ground", "a")
    sets.join("a", "b")
    assert {sets.find(k) for k in ("a", "b", "ground")} == {"ground"}
    assert "b" in sets and "c" not in sets
    assert sets.add("c") and not sets.add("c")
