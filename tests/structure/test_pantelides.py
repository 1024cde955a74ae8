"""Index reduction: literal systems with known offsets, and its laws on random ones."""

from __future__ import annotations

from itertools import permutations

from hypothesis import assume, given
from hypothesis import strategies as st

from planarc.structure.matching import match_equations
from planarc.structure.pantelides import reduce_index


def test_a_rigid_shaft_has_index_two() -> None:
    # J1*der(w1) = tau, J2*der(w2) = -tau, w1 = w2; unknowns w1, w2, tau
    offsets = reduce_index([[(0, 1), (2, 0)], [(1, 1), (2, 0)], [(0, 0), (1, 0)]], [0, 0, 0])
    assert offsets.differentiated == (0, 0, 1)
    assert offsets.highest == (1, 1, 0)


def test_the_cartesian_pendulum_has_index_three() -> None:
    # der(der(x)) = -F*x, der(der(y)) = -F*y - g, x*x + y*y = 1
    signature = [[(0, 2), (2, 0)], [(1, 2), (2, 0)], [(0, 0), (1, 0)]]
    offsets = reduce_index(signature, [0, 0, 0])
    assert offsets.differentiated == (0, 0, 2)
    assert offsets.highest == (2, 2, 0)
    assert offsets.active(signature) == [[0, 2], [1, 2], [0, 1]]


def test_the_pendulum_in_first_order_form_is_reduced_likewise() -> None:
    # der(x) = vx, der(y) = vy, der(vx) = -F*x, der(vy) = -F*y - g, x*x + y*y = 1
    signature = [
        [(0, 1), (2, 0)],
        [(1, 1), (3, 0)],
        [(2, 1), (4, 0), (0, 0)],
        [(3, 1), (4, 0), (1, 0)],
        [(0, 0), (1, 0)],
    ]
    offsets = reduce_index(signature, [0] * 5)
    assert offsets.differentiated == (1, 1, 0, 0, 2)
    assert offsets.highest == (2, 2, 1, 1, 0)


def test_a_rolling_constraint_has_index_two() -> None:
    # m*der(der(x)) = F, I*der(der(phi)) = -R*F, der(x) = R*der(phi)
    offsets = reduce_index([[(0, 2), (2, 0)], [(1, 2), (2, 0)], [(0, 1), (1, 1)]], [0, 0, 0])
    assert offsets.differentiated == (0, 0, 1)
    assert offsets.highest == (2, 2, 0)


def test_a_result_that_asks_for_an_acceleration_is_a_reason_to_differentiate() -> None:
    assert reduce_index([[(0, 0)]], [2]).differentiated == (2,)


@st.composite
def _systems(draw: st.DrawFn) -> list[list[tuple[int, int]]]:
    n = draw(st.integers(1, 5))
    row = st.dictionaries(st.integers(0, n - 1), st.integers(0, 2), min_size=1, max_size=3)
    return [list(r.items()) for r in draw(st.lists(row, min_size=n, max_size=n))]


@given(_systems())
def test_offsets_are_feasible_tight_and_smallest(signature: list[list[tuple[int, int]]]) -> None:
    n = len(signature)
    assume(match_equations([[v for v, _ in row] for row in signature], n).complete)
    offsets = reduce_index(signature, [0] * n)
    c, d = offsets.differentiated, offsets.highest
    assert all(d[v] - c[e] >= order for e, row in enumerate(signature) for v, order in row)
    order_in = [dict(row) for row in signature]
    for e, v in enumerate(offsets.matching.variable):
        assert d[v] - c[e] == order_in[e][v]
    # Pryce: the value of the assignment is the number of degrees of freedom, and the smallest
    # offsets are the least fixed point over any best assignment.
    best = max(
        sum(order_in[e][v] for e, v in enumerate(p))
        for p in permutations(range(n))
        if all(v in order_in[e] for e, v in enumerate(p))
    )
    assert sum(d) - sum(c) == best
    low = [0] * n
    while True:
        high = [max(order_in[e].get(v, -9) + low[e] for e in range(n)) for v in range(n)]
        new = [high[v] - order_in[e][v] for e, v in enumerate(offsets.matching.variable)]
        if new == low:
            break
        low = new
    assert (tuple(low), tuple(high)) == (c, d)
