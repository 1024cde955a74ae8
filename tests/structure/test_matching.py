"""Matching and the singular parts, on literal graphs and against SciPy."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from planarc.structure.matching import Matching, Parts, find_singular_parts, match_equations

COLUMNS = 9
graphs = st.lists(
    st.lists(st.integers(0, COLUMNS - 1), max_size=4, unique=True), min_size=1, max_size=11
)


def test_a_partner_is_moved_along_a_path() -> None:
    assert match_equations([[0, 1], [0], [1, 2]], 3).variable == (1, 0, 2)


def test_given_pairs_stay_matched() -> None:
    start = Matching((1, -1), (-1, 0))
    assert match_equations([[0, 1], [1]], 2, start).variable == (0, 1)


def test_a_long_path_needs_no_recursion() -> None:
    n = 5000  # each equation prefers the unknown that the next one needs alone
    rows = [[i, i + 1] for i in range(n)] + [[0]]
    assert match_equations(rows, n + 1).complete


@given(graphs)
def test_as_many_pairs_as_scipy(rows: list[list[int]]) -> None:
    matching = match_equations(rows, COLUMNS)
    matrix = np.zeros((len(rows), COLUMNS), dtype=bool)
    for e, row in enumerate(rows):
        matrix[e, row] = True
    best = maximum_bipartite_matching(csr_matrix(matrix), perm_type="column")
    assert sum(v >= 0 for v in matching.variable) == np.count_nonzero(best >= 0)
    for e, v in enumerate(matching.variable):
        assert v < 0 or (v in rows[e] and matching.equation[v] == e)


def test_the_parts_of_a_singular_system() -> None:
    rows = [[0], [0], [1, 2], [3]]
    parts = find_singular_parts(rows, 4, match_equations(rows, 4))
    assert parts == Parts((0, 1), (0,), (2,), (1, 2))


def test_an_unknown_in_no_equation_is_a_part_of_its_own() -> None:
    rows: list[list[int]] = [[0]]
    assert find_singular_parts(rows, 2, match_equations(rows, 2)) == Parts((), (), (), (1,))


@given(graphs)
def test_parts_have_surplus_and_lack(rows: list[list[int]]) -> None:
    matching = match_equations(rows, COLUMNS)
    parts = find_singular_parts(rows, COLUMNS, matching)
    assert len(parts.over_equations) - len(parts.over_variables) == len(matching.exposed)
    free = sum(e < 0 for e in matching.equation)
    assert len(parts.under_variables) - len(parts.under_equations) == free
    # The over-determined equations hold no other unknowns, the others none of the lacking part.
    assert {v for e in parts.over_equations for v in rows[e]} == set(parts.over_variables)
    for e, row in enumerate(rows):
        assert e in parts.under_equations or not set(row) & set(parts.under_variables)
