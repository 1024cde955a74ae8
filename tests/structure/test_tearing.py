"""Tearing and the grouping of what is torn, on literal graphs and by law."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from planarc.structure.steps import Plan, plan_steps
from planarc.structure.tearing import Torn, tear_system
from planarc.structure.thinning import thin_tears


def _rows(*rows: str) -> list[list[tuple[int, bool]]]:
    """`ab.c`: unknowns a and b can be solved for, c cannot."""
    made = []
    for row in rows:
        plain, _, curved = row.partition(".")
        made.append([(ord(x) - 97, True) for x in plain] + [(ord(x) - 97, False) for x in curved])
    return made


def test_the_example_of_the_docstring() -> None:
    torn = tear_system(_rows("ab", "ab", "ac"), [0, 0, 0])
    assert torn == Torn((0,), ((1, 0), (2, 2)), (1,))


def test_a_chain_needs_no_tear() -> None:
    torn = tear_system(_rows("bc", "a", "ab"), [0, 0, 0])
    assert torn.tears == ()
    assert torn.assignments == ((0, 1), (1, 2), (2, 0))


def test_an_equation_that_cannot_be_solved_is_a_residual() -> None:
    assert tear_system(_rows(".a"), [0]) == Torn((0,), (), (0,))


def test_rank_goes_before_score() -> None:
    rows = _rows("ab", "ac", "bc.d")
    assert tear_system(rows, [1, 1, 1, 0]).tears[0] == 3
    assert tear_system(rows, [0, 0, 0, 0]).tears[0] == 0


def test_the_unknown_that_makes_most_equations_solvable_is_torn() -> None:
    assert tear_system(_rows("ab", "bc", "bd", "cd"), [0] * 4).tears == (1,)


def test_a_loop_of_n_equations_needs_one_tear() -> None:
    n = 3000
    rows = [[(i, True), ((i + 1) % n, True)] for i in range(n)]
    torn = tear_system(rows, [0] * n)
    assert len(torn.tears) == len(torn.residuals) == 1


@st.composite
def _systems(draw: st.DrawFn) -> tuple[list[list[tuple[int, bool]]], list[int]]:
    n = draw(st.integers(1, 8))
    row = st.dictionaries(st.integers(0, n - 1), st.booleans(), max_size=4)
    rows = draw(st.lists(row, max_size=n + 2))
    return [list(r.items()) for r in rows], draw(
        st.lists(st.integers(0, 2), min_size=n, max_size=n)
    )


@given(_systems())
def test_laws_of_tearing(system: tuple[list[list[tuple[int, bool]]], list[int]]) -> None:
    rows, rank = system
    torn = tear_system(rows, rank)
    known = set(torn.tears)
    for v, e in torn.assignments:
        assert v not in known
        assert dict(rows[e])[v]
        assert all(u in known for u, _ in rows[e] if u != v)
        known.add(v)
    assert known == set(range(len(rank)))
    assert sorted([e for _, e in torn.assignments] + list(torn.residuals)) == list(range(len(rows)))
    assert len(torn.tears) - len(torn.residuals) == len(rank) - len(rows)


@given(_systems())
def test_laws_of_grouping(system: tuple[list[list[tuple[int, bool]]], list[int]]) -> None:
    rows, rank = system
    torn = tear_system(rows, rank)
    names = [[v for v, _ in row] for row in rows]
    plan = plan_steps(names, torn)
    inner = [i for _, chosen, _ in plan.blocks for i in chosen]
    assert sorted([*plan.before, *inner, *plan.after]) == list(range(len(torn.assignments)))
    assert sorted(v for tears, _, _ in plan.blocks for v in tears) == sorted(torn.tears)
    assert sorted(e for _, _, zero in plan.blocks for e in zero) == list(torn.residuals)
    start = {torn.assignments[i][0] for i in plan.before}
    for tears, chosen, residuals in plan.blocks:  # each block needs nothing of the others
        known = start | set(tears)
        for i in chosen:
            v, e = torn.assignments[i]
            assert known.issuperset(set(names[e]) - {v})
            known.add(v)
        assert all(known.issuperset(names[e]) for e in residuals)


def test_independent_loops_are_separate_blocks() -> None:
    # Two loops a-b and c-d, and a free tear e that f follows.
    torn = tear_system(_rows(".ab", ".cd", "fe"), [0, 0, 0, 0, 0, 1])
    plan = plan_steps([[0, 1], [2, 3], [5, 4]], torn)
    assert plan == Plan((), (((0, 1), (), (0,)), ((2, 3), (), (1,)), ((4,), (), ())), (0,))


def test_a_tear_that_others_give_is_left_out() -> None:
    # t := f(q) and s := t + f(q); t and s are torn first by their rank, then q.
    rows = _rows("b.a", "cb.a")
    torn = tear_system(rows, [2, 1, 1])
    assert (torn.tears, torn.residuals) == ((1, 2, 0), (0, 1))
    assert thin_tears(rows, torn, [1, 2]) == Torn((0,), ((1, 0), (2, 1)), ())
    assert thin_tears(rows, torn, []) == torn


@given(_systems())
def test_laws_of_thinning(system: tuple[list[list[tuple[int, bool]]], list[int]]) -> None:
    rows, rank = system
    torn = tear_system(rows, rank)
    thin = thin_tears(rows, torn, sorted(torn.tears, key=lambda v: -rank[v]))
    assert set(thin.tears) <= set(torn.tears)
    assert len(thin.tears) - len(thin.residuals) == len(torn.tears) - len(torn.residuals)
    known = set(thin.tears)
    for v, e in thin.assignments:
        assert v not in known
        assert dict(rows[e])[v]
        assert all(u in known for u, _ in rows[e] if u != v)
        known.add(v)
    assert known == set(range(len(rank)))
    assert sorted([e for _, e in thin.assignments] + list(thin.residuals)) == list(range(len(rows)))
