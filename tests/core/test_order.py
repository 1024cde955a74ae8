"""Names stand behind what they need, else as given; a circle is told in its order."""

from __future__ import annotations

import pytest

from planarc.core.order import Circle, in_order


def test_each_name_after_its_needs() -> None:
    needs = {"a": "c", "b": "", "c": "b", "d": "ab"}
    assert in_order("dabc", needs.__getitem__) == ["b", "c", "a", "d"]
    assert in_order("abc", lambda name: "") == ["a", "b", "c"]


def test_long_chains_do_not_recurse() -> None:
    names = [str(n) for n in range(50_000)]
    found = in_order(names, lambda name: [str(int(name) + 1)] if int(name) < 49_999 else [])
    assert found == names[::-1]


def test_a_circle_is_told_from_where_it_was_entered() -> None:
    with pytest.raises(Circle) as caught:
        in_order("xab", {"x": "a", "a": "b", "b": "a"}.__getitem__)
    assert caught.value.names == ["a", "b"]
