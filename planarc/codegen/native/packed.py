"""Whole numbers that a file holds in few bytes.

In:   numbers
Out:  words, each of eight bytes, the lowest first

Each number is told by how much it is more than the one before it, seven bits a byte, the highest
first; a byte with its eighth bit set has another one behind it. The lowest bit of a step is set
where it leads down:

    5 7 9 3 403   ->   steps 5 2 2 -6 400   ->   bytes 10 4 4 11 (134 32)

so that tables that grow evenly are the same few bytes again and again, which archives pack well.
"""

from __future__ import annotations

from collections.abc import Iterable


class Rows:
    """Rows of whole numbers one behind the other; equal ones stand there once. A `word` of the
    frame points to those that functions share."""

    def __init__(self, word: int = -1) -> None:
        self.word = word
        self.numbers: list[int] = []
        self._known: dict[tuple[int, ...], int] = {}

    def place(self, row: tuple[int, ...]) -> int:
        """Where it begins."""
        if row not in self._known:
            self._known[row] = len(self.numbers)
            self.numbers += row
        return self._known[row]


def pack(numbers: Iterable[int]) -> list[int]:
    """The numbers in the words of a constant."""
    found, last = bytearray(), 0
    for number in numbers:
        step, last = number - last, number
        found += _bytes(-2 * step - 1 if step < 0 else 2 * step)
    found += bytes(-len(found) % 8)
    parts = (found[i : i + 8] for i in range(0, len(found), 8))
    return [int.from_bytes(part, "little", signed=True) for part in parts]


def _bytes(number: int) -> bytes:
    groups = [number & 0x7F]
    while number := number >> 7:
        groups.append(number & 0x7F | 0x80)
    return bytes(reversed(groups))
