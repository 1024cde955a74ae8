"""Equal statements brought together: in an order that is allowed, and in the groups they make."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from planarc.codegen.native.gathering import gather


def is_allowed(order: Sequence[int], before: Sequence[Sequence[int]]) -> bool:
    place = {i: at for at, i in enumerate(order)}
    ordered = all(place[b] < place[i] for i, found in enumerate(before) for b in found)
    return ordered and sorted(order) == list(range(len(before)))


def test_parts_that_are_interleaved() -> None:
    """a1 := f(x1), b := h(x1), a2 := f(x2), c1 := g(a1), c2 := g(a2)."""
    assert gather([0, 1, 0, 2, 2], [(), (), (), (0,), (2,)]) == [0, 3, 2, 4, 1]


def test_readers_follow_the_order_of_what_they_read() -> None:
    """c1 := g(a2) is written before c2 := g(a1)."""
    assert gather([0, 0, 2, 2], [(), (), (1,), (0,)]) == [0, 3, 1, 2]


def test_what_reads_all_times_ends_a_group() -> None:
    """a1 := f(x1), a2 := f(x2), s := a1 + a2, c1 := g(a1, s), c2 := g(a2, s)."""
    assert gather([0, 0, 1, 2, 2], [(), (), (0, 1), (0, 2), (1, 2)]) == [0, 1, 2, 3, 4]


def test_what_reads_its_neighbour_is_no_part_of_a_group() -> None:
    """c1 := g(a1, a2), c2 := g(a2, a1)."""
    assert gather([0, 0, 1, 1], [(), (), (0, 1), (1, 0)]) == [0, 1, 2, 3]


def test_equal_statements_in_a_row_stay_in_it() -> None:
    before = [(), (0,), (1,), (2,)]
    assert gather([5, 5, 5, 5], before) == [0, 1, 2, 3]


@given(st.data())
def test_each_stands_behind_what_it_needs(data: st.DataObject) -> None:
    count = data.draw(st.integers(0, 30))
    kinds = [data.draw(st.integers(0, 4)) for _ in range(count)]
    before = [
        data.draw(st.lists(st.integers(0, i - 1), max_size=3, unique=True)) if i else []
        for i in range(count)
    ]
    order = gather(kinds, before)
    assert is_allowed(order, before)
    assert order == gather(kinds, before)
