"""Functions in the place of external ones: random generators, spectra, texts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planarc.runtime import external
from planarc.runtime.external import random, text

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


# Random generators -----------------------------------------------------------------------------


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


# Spectra ---------------------------------------------------------------------------------------


def test_a_spectrum_tells_amplitudes_and_phases() -> None:
    n = 24
    t = np.arange(n) / n
    u = 3 * np.cos(2 * math.pi * 2 * t + 0.4) + 1.5 * np.sin(2 * math.pi * 5 * t)
    found = external.call_numbers("ModelicaFFT_kiss_fftr", (*u.tolist(), n))
    amplitudes, phases = found[1 : n // 2 + 2], found[n // 2 + 2 :]
    assert found[0] == 0
    wanted = [{2: 3.0, 5: 1.5}.get(k, 0.0) for k in range(n // 2 + 1)]
    assert amplitudes == pytest.approx(wanted, abs=1e-12)
    assert phases[2] == pytest.approx(0.4)
    assert phases[5] == pytest.approx(-math.pi / 2)


def test_an_odd_number_of_samples_is_flagged() -> None:
    assert external.call_numbers("ModelicaFFT_kiss_fftr", (1.0, 2.0, 3.0, 3))[0] == 1


# Texts -----------------------------------------------------------------------------------------


def test_the_hash_function_gives_what_the_standard_library_documents() -> None:
    assert text.hash_string("this is a test") == (1827717433,)
    assert text.hash_string("Controller.noise1") == (-1025762750,)


@pytest.mark.parametrize(
    ("name", "arguments", "wanted"),
    [
        ("length", ("abc",), (3,)),
        ("substring", ("abcdef", 2, 4), ("bcd",)),
        ("substring", ("abc", 2, 1), ("",)),
        ("compare", ("abc", "abd", True), (1,)),
        ("compare", ("ABC", "abc", False), (2,)),
        ("compare", ("b", "a", True), (3,)),
        ("skipWhiteSpace", ("  x", 1), (3,)),
        ("skipWhiteSpace", ("x  ", 2), (4,)),
        ("scanIdentifier", (" a_1+", 1), (5, "a_1")),
        ("scanIdentifier", ("1a", 1), (1, "")),
        ("scanInteger", (" -12 ", 1, False), (5, -12)),
        ("scanInteger", ("-12", 1, True), (1, 0)),
        ("scanInteger", ("1.5", 1, False), (1, 0)),
        ("scanReal", ("x 1.5e-3;", 2, False), (9, 1.5e-3)),
        ("scanReal", ("e5", 1, False), (1, 0.0)),
        ("scanString", (' "a b" ', 1), (7, "a b")),
        ("scanString", ("a", 1), (1, "")),
    ],
)
def test_texts(name: str, arguments: tuple[object, ...], wanted: tuple[object, ...]) -> None:
    assert external.call_texts(f"ModelicaStrings_{name}", arguments) == wanted


def test_a_part_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="is not in a text of 3"):
        external.call_texts("ModelicaStrings_substring", ("abc", 2, 9))
