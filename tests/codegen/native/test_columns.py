"""Columns of a Jacobian that are computed together."""

from __future__ import annotations

from planarc.codegen.native.columns import grouped


def test_columns_without_a_common_row_go_together() -> None:
    band = [frozenset({i, i + 1}) for i in range(5)]
    groups = grouped(band, 6)
    assert groups.of == (0, 1, 0, 1, 0, 1)
    assert groups.columns == ((0, 1), (2, 1), (2, 3), (4, 3), (4, 5))


def test_a_full_row_keeps_all_apart() -> None:
    groups = grouped([frozenset(range(3)), frozenset({2})], 3)
    assert groups.of == (0, 1, 2)
    assert groups.columns == ((0, 1, 2), (0, 1, 2))


def test_a_row_without_a_column_of_a_group_gives_zero_for_its_first() -> None:
    groups = grouped([frozenset({0}), frozenset({1}), frozenset({0, 2})], 3)
    assert groups.of == (0, 0, 1)
    assert groups.columns == ((0, 2), (1, 2), (0, 2))
