"""Strongly connected components against SciPy, and their order."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from planarc.core.blocks import sort_blocks


def test_the_example_of_the_docstring() -> None:
    assert sort_blocks([[1], [2], [1], []]) == [[1, 2], [0], [3]]


def test_a_deep_chain_needs_no_recursion() -> None:
    n = 20000
    blocks = sort_blocks([[i + 1] for i in range(n - 1)] + [[]])
    assert blocks == [[i] for i in reversed(range(n))]


@given(st.lists(st.lists(st.integers(0, 11), max_size=3), min_size=12, max_size=12))
def test_same_components_as_scipy_in_an_order_of_evaluation(graph: list[list[int]]) -> None:
    blocks = sort_blocks(graph)
    place = {node: i for i, block in enumerate(blocks) for node in block}
    assert sorted(place) == list(range(12))
    assert all(place[b] <= place[a] for a, followers in enumerate(graph) for b in followers)
    matrix = np.zeros((12, 12), dtype=bool)
    for a, followers in enumerate(graph):
        matrix[a, followers] = True
    count, label = connected_components(csr_matrix(matrix), connection="strong")
    assert len(blocks) == count
    assert all(len({label[n] for n in block}) == 1 for block in blocks)
