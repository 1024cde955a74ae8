"""Random generators in the place of external ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planarc.runtime import external
from planarc.runtime.external import random

GENERATORS = {
    "ModelicaRandom_xorshift64star": 2,
    "ModelicaRandom_xorshift128plus": 4,
    "ModelicaRandom_xorshift1024star": 33,
}


def draws(name: str, count: int, seed: int = 1) -> list[float]:
    state = tuple(float(seed + 7919 * i) for i in range(GENERATORS[name]))
    found = []
    for _ in range(count):
        *after, number = external.call_numbers(name, state)
        state = tuple(after)
        found.append(number)
    return found


def word(low: float, high: float) -> int:
    return (int(low) % 2**32) + (int(high) % 2**32) * 2**32


def test_one_step_of_xorshift64star_by_hand() -> None:
    """x = 1 is shifted to 2^25 + 1, then multiplied."""
    low, high, number = random.xorshift64star([1, 0])
    wanted = (2**25 + 1) * 2685821657736338717 % 2**64
    assert word(low, high) == wanted
    signed = wanted - 2**64 if wanted >= 2**63 else wanted
    assert number == signed / 2**64 + 0.5


def test_two_steps_of_xorshift128plus_by_hand() -> None:
    """The words (1, 0): 1 becomes 2^23 + 1, shifted by 17 it gives 64 more."""
    first = random.xorshift128plus([1, 0, 0, 0])
    s = (2**23 + 1) ^ ((2**23 + 1) >> 17)
    assert (word(*first[:2]), word(*first[2:4])) == (0, s)
    second = random.xorshift128plus(first[:4])
    assert (word(*second[:2]), word(*second[2:4])) == (s, (s ^ (s >> 26)) + s)


def test_xorshift1024star_goes_round_its_sixteen_words() -> None:
    state = [float(i + 1) for i in range(32)] + [0.0]
    for turn in range(1, 40):
        *after, _ = random.xorshift1024star(state)
        changed = [i for i in range(16) if after[2 * i : 2 * i + 2] != state[2 * i : 2 * i + 2]]
        assert after[32] == turn % 16
        assert changed == [turn % 16]
        state = after


@pytest.mark.parametrize("name", GENERATORS)
def test_numbers_are_uniform_and_independent(name: str) -> None:
    numbers = np.array(draws(name, 20_200)[200:])
    n = len(numbers)
    assert numbers.min() > 0 and numbers.max() <= 1
    assert abs(numbers.mean() - 0.5) < 4 * math.sqrt(1 / 12 / n)
    expected = n / 16
    counts, _ = np.histogram(numbers, bins=16, range=(0, 1))
    assert ((counts - expected) ** 2 / expected).sum() < 37.7  # 99.9 % of chi-square, 15
    centred = numbers - numbers.mean()
    for lag in (1, 2, 7):
        correlation = (centred[lag:] * centred[:-lag]).mean() / centred.var()
        assert abs(correlation) < 4 / math.sqrt(n)


def test_fresh_numbers_differ_by_time_place_and_seed_and_are_uniform() -> None:
    name = "ModelicaRandom_impureRandom_xorshift1024star"
    assert external.number(name, 0, (1, 2, 0.5)) == external.number(name, 0, (1, 2, 0.5))
    numbers = [
        external.number(name, 0, (seed, place, 0.01 * k))
        for seed in (1, 2)
        for place in (1, 2)
        for k in range(2_000)
    ]
    assert len(set(numbers)) == len(numbers)
    assert min(numbers) > 0 and max(numbers) <= 1
    assert abs(np.mean(numbers) - 0.5) < 4 * math.sqrt(1 / 12 / len(numbers))


def test_places_draw_from_one_row_that_begins_anew_with_a_run() -> None:
    name = "ModelicaRandom_impureRandom_xorshift1024star"
    external.begin_run()
    two = [external.number(name, 0, (7, place, t)) for t in (0.0, 0.1) for place in (1, 2)]
    assert external.number(name, 0, (7, 1, 0.1)) == two[2]  # while an event is iterated
    external.begin_run()
    assert [external.number(name, 0, (7, 1, 0.3 * k)) for k in range(4)] == two
