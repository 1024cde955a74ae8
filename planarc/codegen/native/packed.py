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
#: Most bytes of a number: 64 bits.
_GROUPS = 10


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
    turned = (steps << 1 ^ steps >> 63).view(np.uint64)
    begins = np.arange(backs.size) * CHUNK
    return [*map(int, _in_bytes(np.insert(turned, begins, backs.astype(np.uint64))))]


def _in_bytes(numbers: NDArray[np.uint64]) -> Numbers:
    """Seven bits a byte, the highest first, in words."""
    import numpy as np

    groups = [numbers >> np.uint64(7 * k) for k in range(_GROUPS)]
    lengths = 1 + sum((group != 0).astype(np.int64) for group in groups[1:])
    lasts = np.cumsum(lengths) - 1
    size = int(lasts[-1]) + 1 if lasts.size else 0
    found = np.zeros(-(-size // 8) * 8, np.uint8)
    for k, group in enumerate(groups):
        there = lengths > k
        more = np.uint64(0x80 if k else 0)
        found[lasts[there] - k] = group[there] & np.uint64(0x7F) | more
    return found.view("<i8")


def _backs(listed: Numbers) -> Numbers:
    """For each chunk how far back most of its numbers find others that grow evenly."""
    import numpy as np

    chunks = -(-listed.size // CHUNK)
    if not chunks:
        return listed
    most = 2 * _FARTHEST
    led = np.zeros(most + chunks * CHUNK, np.int64)
    led[most : most + listed.size] = listed
    twice, there = 2 * led, np.arange(chunks * CHUNK) < listed.size

    def even(back: int) -> Any:
        """How many of each chunk are as much more than one as that is than the one before."""
        before, further = (led.size - k * back for k in (1, 2))
        is_even = led[most:] + led[most - 2 * back : further] == twice[most - back : before]
        return (is_even & there).view(np.uint8).reshape(chunks, CHUNK).sum(axis=1, dtype=np.uint8)

    found = np.array([even(back) for back in range(1, _FARTHEST + 1)], dtype=np.int64)
    best = found.argmax(axis=0)
    pays = found[best, range(chunks)] > found[0] + _PAYS
    return np.where(pays, best + 1, 1)
