"""The small complementarity problem of contacts: both ways to solve it, against its definition."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc.solve.contact import problem
from planarc.solve.contact.lemke import lemke
from planarc.solve.contact.problem import IDLE, Spot, solve_contacts
from planarc.solve.contact.strike import STILL, strike


def a_mechanism(rng: Any, touches: int) -> Any:
    """J*M^-1*J' of random directions in a space large enough that none depends on others."""
    j = rng.normal(size=(2 * touches, 2 * touches + 2))
    return j @ np.diag(rng.uniform(0.2, 3, 2 * touches + 2)) @ j.T


def keeps_the_law(found: Any, spots: list[Spot]) -> bool:
    k = len(spots)
    for i, spot in enumerate(spots):
        n, t, u, s = found.x[i], found.x[k + i], found.u[i], found.u[k + i]
        if n < -1e-8 or u < -1e-8 or abs(n * u) > 1e-8:
            return False
        if abs(t) > spot.mu * n + 1e-8 or (abs(s) > 1e-8 and s * t > 1e-8):
            return False
        if abs(s) > 1e-8 and abs(abs(t) - spot.mu * n) > 1e-8:
            return False
    return True


@pytest.mark.parametrize("tried", [3, 0], ids=["cases", "Lemke"])
def test_forces_obey_the_law(tried: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(problem, "MOST_TRIED", tried)
    rng = np.random.default_rng(17)
    for _ in range(200):
        k = int(rng.integers(1, 4))
        a, b = a_mechanism(rng, k), rng.normal(size=2 * k)
        spots = [Spot(float(mu), None) for mu in rng.uniform(0.05, 0.3, k)]
        found = solve_contacts(a, b, spots)
        assert found is not None
        assert keeps_the_law(found, spots)


@pytest.mark.parametrize("size", [1.0, 1e-9])
def test_touches_that_depend_on_each_other(size: float) -> None:
    """As the corners of few bodies do; speeds that are small against 1 are speeds all the same."""
    rng = np.random.default_rng(17)
    for _ in range(60):
        k = int(rng.integers(4, 8))
        j = rng.normal(size=(2 * k, 6))
        j[1], j[k + 1] = j[0], j[k]  # two touches at one place
        a, b = j @ j.T, size * (j @ rng.normal(size=6))
        spots = [Spot(float(mu), None) for mu in rng.uniform(0.05, 0.3, k)]
        found = solve_contacts(a, b, spots)
        assert found is not None
        assert keeps_the_law(found, spots)


def test_many_touches_without_friction() -> None:
    rng = np.random.default_rng(17)
    for _ in range(30):
        a, b = a_mechanism(rng, 12), rng.normal(size=24)
        spots = [Spot(0.0, IDLE)] * 12
        found = solve_contacts(a, b, spots)
        assert found is not None
        assert keeps_the_law(found, [Spot(0.0, IDLE)] * 12) or not found.x[12:].any()
        assert (found.x[:12] >= -1e-9).all() and (found.u[:12] >= -1e-8).all()
        assert abs(found.x[:12] @ found.u[:12]) < 1e-8


def test_lemke_finds_what_its_example_says_and_owns_up_where_it_finds_nothing() -> None:
    assert lemke(np.array([[2.0]]), np.array([-1.0])) == {0}
    assert lemke(np.array([[2.0]]), np.array([1.0])) == set()
    assert lemke(np.array([[-1.0]]), np.array([-1.0])) is None


def test_of_two_that_say_the_same_one_idles() -> None:
    """Two corners of one body that stick: their slips are one."""
    j = np.array([[0.0, 1, -1], [0, 1, 1], [1, 0, 1], [1, 0, 1]])
    a = j @ j.T
    found = solve_contacts(a, j @ [1.0, -9.81, 0], [Spot(1.0, None)] * 2)
    assert found is not None
    assert sorted(way for _, way in found.cases) == [0, IDLE]
    np.testing.assert_allclose(found.u, 0, atol=1e-12)


def test_no_friction_keeps_a_rod_that_jams() -> None:
    """Painleve: a rod that slides with its tip ahead and so much friction that no force fits."""
    a = np.array([[1.0, -2.0], [-2.0, 5.0]])
    assert solve_contacts(a, np.array([-1.0, 0.0]), [Spot(1.0, -1)]) is None


def test_a_blow_never_gains_energy_and_ends_all_approach() -> None:
    rng = np.random.default_rng(17)
    for _ in range(300):
        k = int(rng.integers(1, 4))
        a, u = a_mechanism(rng, k), rng.normal(size=2 * k)
        e, mu = rng.uniform(0, 1, k), rng.uniform(0, 0.8, k)
        blow = strike(a, u, e, mu, STILL * np.abs(u).max() * np.ones(k))
        assert blow is not None
        assert (blow.u[:k] >= -1e-9).all()
        assert blow.x @ (u + blow.u) <= 1e-9
        np.testing.assert_allclose(blow.u, u + a @ blow.x, atol=1e-12)
        assert (np.abs(blow.x[k:]) <= mu * blow.x[:k] + 1e-9).all()


def test_a_row_of_balls_passes_a_blow_on() -> None:
    j = np.array([[-1.0, 1, 0, 0], [0, -1, 1, 0], [0, 0, -1, 1]])
    a = np.block([[j @ j.T, np.zeros((3, 3))], [np.zeros((3, 3)), np.eye(3)]])
    blow = strike(a, np.array([-1.0, 0, 0, 0, 0, 0]), np.ones(3), np.zeros(3), np.full(3, STILL))
    assert blow is not None
    np.testing.assert_allclose(j.T @ blow.x[:3] + [1, 0, 0, 0], [0, 0, 0, 1], atol=1e-12)


def test_what_rests_without_restitution_bears_a_blow() -> None:
    """A ball falls on a ball that lies on the floor: all comes to rest at once."""
    j = np.array([[1.0, 0], [-1, 1]])
    a = np.block([[j @ j.T, np.zeros((2, 2))], [np.zeros((2, 2)), np.eye(2)]])
    blow = strike(a, np.array([0.0, -1, 0, 0]), np.zeros(2), np.zeros(2), np.full(2, STILL))
    assert blow is not None
    np.testing.assert_allclose(blow.u[:2], 0, atol=1e-12)
