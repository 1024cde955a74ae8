"""Whole numbers that a file holds in few bytes.

In:   numbers
Out:  words, each of eight bytes, the lowest first

Each number is told by how much it is more than one before it, seven bits a byte, the highest
first; a byte with its eighth bit set has another one behind it. The lowest bit of a step is set
where it leads down. Each `CHUNK` of numbers begins with how far back that other one stands:

    5 7 9 3 403   ->   1 back, steps 5 2 2 -6 400   ->   bytes 1 10 4 4 11 (134 32)

so that tables that grow evenly, also those of groups that repeat themselves (17 numbers of one link
of a chain, then those of the next), are the same few bytes again and again, which archives pack
well.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.int64]

#: Numbers that look equally far back.
CHUNK = 64
#: Farthest back, in one byte; it pays where so many more numbers of a chunk grow evenly.
_FARTHEST, _PAYS = 127, 8


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
    import numpy as np

    listed = np.fromiter(numbers, dtype=np.int64)
    backs = _backs(listed)
    places = np.arange(listed.size) - np.repeat(backs, CHUNK)[: listed.size]
    steps = listed - np.where(places < 0, 0, listed[np.maximum(places, 0)])
    turned = (steps << 1 ^ steps >> 63).view(np.uint64).tolist()
    found = bytearray()
    for i, chunk_back in enumerate(backs.tolist()):
        found.append(chunk_back)
        for number in turned[i * CHUNK : (i + 1) * CHUNK]:
            found += _BYTES[number] if number < 128 else _bytes(number)
    found += bytes(-len(found) % 8)
    return [*map(int, np.frombuffer(bytes(found), dtype="<i8"))]


def _backs(listed: Numbers) -> Numbers:
    """For each chunk how far back most of its numbers find others that grow evenly."""
    import numpy as np

    begins = np.arange(0, listed.size, CHUNK)
    if not begins.size:
        return begins
    most = 2 * _FARTHEST
    led = np.concatenate((np.zeros(most, np.int64), listed))

    def even(back: int) -> Any:
        before, twice = (led[most - k * back : led.size - k * back] for k in (1, 2))
        return np.add.reduceat(listed - before == before - twice, begins, dtype=np.int64)

    found = np.array([even(back) for back in range(1, _FARTHEST + 1)])
    best = found.argmax(axis=0)
    pays = found[best, range(begins.size)] > found[0] + _PAYS
    return np.where(pays, best + 1, 1)


_BYTES = [bytes((n,)) for n in range(128)]


def _bytes(number: int) -> bytes:
    groups = [number & 0x7F]
    while number := number >> 7:
        groups.append(number & 0x7F | 0x80)
    return bytes(reversed(groups))
