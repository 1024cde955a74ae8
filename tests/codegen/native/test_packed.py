"""Whole numbers in few bytes."""

from __future__ import annotations

import random
import zlib

from planarc.codegen.native.packed import CHUNK, Rows, pack


def test_steps_are_bytes() -> None:
    words = pack([5, 7, 9, 3, 403])
    assert b"".join(w.to_bytes(8, "little", signed=True) for w in words) == bytes(
        [1, 10, 4, 4, 11, 0x80 | 6, 32, 0]
    )


def unpacked(words: list[int], count: int) -> list[int]:
    numbers: list[int] = []
    read = iter(b"".join(w.to_bytes(8, "little", signed=True) for w in words))

    def number() -> int:
        step = 0
        for byte in read:
            step = step << 7 | byte & 127
            if byte < 128:
                break
        return step

    while len(numbers) < count:
        back = number()
        for _ in range(min(CHUNK, count - len(numbers))):
            step = number()
            before = numbers[-back] if back <= len(numbers) else 0
            numbers.append(before + (step // 2 if step % 2 == 0 else -(step + 1) // 2))
    return numbers


def test_any_numbers_come_back() -> None:
    r = random.Random(1)
    numbers = [
        r.randrange(-(10 ** r.randrange(1, 16)), 10 ** r.randrange(1, 16)) for _ in range(500)
    ]
    numbers += [0, -1, 63, 64, -64, -65, 2**40]
    assert unpacked(pack(numbers), len(numbers)) == numbers


def test_tables_that_grow_evenly_are_a_byte_each() -> None:
    assert len(pack(range(0, 24_000, 3))) == 1000 + 1000 // CHUNK + 1
    assert pack([]) == []


def test_groups_that_repeat_themselves_grow_evenly() -> None:
    """Links whose numbers count on by 17 and by 16: bytes that are the same in each."""
    numbers = [n for k in range(60) for n in (7 + 17 * k, 900 + 16 * k, 3 + 17 * k, 5, 40 * k)]
    words = pack(numbers)
    assert unpacked(words, len(numbers)) == numbers
    data = b"".join(w.to_bytes(8, "little", signed=True) for w in words)
    assert data[66] == 5 and len(zlib.compress(data)) < 70


def test_steps_of_all_sizes_come_back() -> None:
    """A step may need all 64 bits; sums wrap."""
    numbers = [0, 2**62, -(2**62), 2**63 - 1, -(2**63), 0]
    wrapped = [n + 2**63 & 2**64 - 1 for n in unpacked(pack(numbers), len(numbers))]
    assert [n - 2**63 for n in wrapped] == numbers


def test_equal_rows_stand_there_once() -> None:
    rows = Rows()
    assert [rows.place(r) for r in ((1, 2), (3,), (1, 2))] == [0, 2, 0]
    assert rows.numbers == [1, 2, 3]
