"""Whole numbers in few bytes."""

from __future__ import annotations

import random
from itertools import accumulate

from planarc.codegen.native.packed import Rows, pack


def test_steps_are_bytes() -> None:
    words = pack([5, 7, 9, 3, 403])
    assert b"".join(w.to_bytes(8, "little", signed=True) for w in words) == bytes(
        [10, 4, 4, 11, 0x80 | 6, 32, 0, 0]
    )


def unpacked(words: list[int]) -> list[int]:
    """All numbers, and a few more: the rest of the last word is steps of 0."""
    steps, step = [], 0
    for byte in b"".join(w.to_bytes(8, "little", signed=True) for w in words):
        step = step << 7 | byte & 127
        if byte < 128:
            steps.append(step // 2 if step % 2 == 0 else -(step + 1) // 2)
            step = 0
    return list(accumulate(steps))


def test_any_numbers_come_back() -> None:
    r = random.Random(1)
    numbers = [
        r.randrange(-(10 ** r.randrange(1, 16)), 10 ** r.randrange(1, 16)) for _ in range(500)
    ]
    numbers += [0, -1, 63, 64, -64, -65, 2**40]
    assert unpacked(pack(numbers))[: len(numbers)] == numbers


def test_tables_that_grow_evenly_are_a_byte_each() -> None:
    assert len(pack(range(0, 24_000, 3))) == 1000
    assert pack([]) == []


def test_equal_rows_stand_there_once() -> None:
    rows = Rows()
    assert [rows.place(r) for r in ((1, 2), (3,), (1, 2))] == [0, 2, 0]
    assert rows.numbers == [1, 2, 3]
