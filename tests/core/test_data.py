"""A while without the search for cycles: what is made in it is old behind it."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from weakref import ref

import pytest

from planarc.core.data import EVERY, MANY, Data, without_collection


class Leaf(Data):
    """Something that the search looks through."""

    items: list[int]


@pytest.fixture(autouse=True)
def searching() -> Iterator[None]:
    """Python's search, as it was before the test."""
    was = gc.isenabled()
    gc.enable()
    yield
    (gc.enable if was else gc.disable)()


def test_what_stays_is_old_and_is_not_looked_through_at_once() -> None:
    with without_collection():
        assert not gc.isenabled()
        made = [Leaf([i]) for i in range(MANY)]
    assert gc.isenabled()
    assert gc.get_count()[0] < len(made)
    young = {id(o) for generation in (0, 1) for o in gc.get_objects(generation)}
    assert young.isdisjoint(map(id, made))


@pytest.mark.parametrize("count", [100, MANY])
def test_cycles_of_the_while_are_found_later(count: int) -> None:
    """Or at once, where it is this one's turn to search through everything."""

    class Knot:
        def __init__(self) -> None:
            self.end = self

    with without_collection():
        knots = [ref(Knot()) for _ in range(count)]
    gc.collect()
    assert all(knot() is None for knot in knots)


def test_once_in_a_while_everything_is_searched() -> None:
    class Knot:
        def __init__(self) -> None:
            self.end = self

    knots = []
    for _ in range(EVERY):
        with without_collection():
            made = [Leaf([i]) for i in range(MANY)]
            knots.append(ref(Knot()))
        del made
    assert any(knot() is None for knot in knots)


def test_little_is_looked_through_soon() -> None:
    gc.collect()
    with without_collection():
        made = [Leaf([i]) for i in range(1000)]
    old = {id(o) for o in gc.get_objects(2)}
    assert old.isdisjoint(map(id, made))


def test_a_caller_that_waits_goes_on_waiting() -> None:
    gc.disable()
    with without_collection():
        pass
    assert not gc.isenabled()


def test_what_a_caller_has_frozen_stays_frozen() -> None:
    kept = [Leaf([1])]
    gc.freeze()
    try:
        count = gc.get_freeze_count()
        with without_collection():
            kept.append(Leaf([2]))
        assert gc.get_freeze_count() == count
    finally:
        gc.unfreeze()
