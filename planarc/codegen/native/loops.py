"""Where a loop finds what differs from time to time.

    workspace, w    all that has a slot
    memory          temporaries that loops set, or read where others set them

The places of a column are a first one and the distances from it. Distances that grow evenly are
computed, others stand in the constant `pc_..._rows`, as numbers that differ do; columns of equal
distances share a pointer:

    p := w + distance[t];   p[17] := p[3]*p[250]
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value
from planarc.codegen.native.rolling import Column
from planarc.ir.expr import Expr

#: Numbers of a function's memory: 128 kB, half of the stack of a page's module.
MOST = 1 << 14


class Loops:
    """The loops of one function, their memory and their constant."""

    def __init__(self, code: Code, name: str) -> None:
        self._code, self._name = code, f"@{name}_rows"
        self.memory = Value(code, POINTER, "%memory")
        self.places: dict[Expr, int] = {}  # in the memory
        self._rows: dict[tuple[int, ...], int] = {}  # distances or numbers, and where they begin
        self._length = 0
        self._pointers: dict[tuple[str, tuple[int, ...]], Value] = {}

    def has_room(self, columns: Sequence[Column]) -> bool:
        return len(self.places) + sum(map(len, columns)) <= MOST

    def hold(self, temporaries: Iterable[Expr]) -> None:
        """Make room for them."""
        for e in temporaries:
            self.places.setdefault(e, len(self.places))

    @contextmanager
    def run(self, times: int) -> Iterator[None]:
        """What stands inside, with `at` by the time."""
        with self._code.loop(times) as self.time:
            self._pointers = {}
            yield

    def at(self, memory: Value, places: Sequence[int]) -> tuple[Value, int]:
        """A pointer and the index behind it of the place that is due."""
        first = places[0]
        distances = tuple([p - first for p in places])
        known = self._pointers.get((memory.text, distances))
        if known is None:
            known = self._pointers[memory.text, distances] = memory.at(self._distance(distances))
        return known, first

    def word(self, words: Sequence[int]) -> Value:
        """The whole number that is due."""
        return self._row(tuple(words)).load(INT, self.time)

    def number(self, values: Sequence[float]) -> Value:
        """The number that is due."""
        bits = tuple([struct.unpack("<q", struct.pack("<d", v))[0] for v in values])
        return self._row(bits).load(REAL, self.time)

    def _distance(self, distances: tuple[int, ...]) -> Value:
        step = distances[1]
        if distances == tuple(range(0, step * len(distances), step or 1)):
            return self.time * step
        return self.word(distances)

    def _row(self, words: tuple[int, ...]) -> Value:
        """Where these begin in the constant."""
        if words not in self._rows:
            self._rows[words] = self._length
            self._length += len(words)
        return Value(self._code, POINTER, self._name).at(self._rows[words])

    def text(self) -> str:
        """The constant, where there is one; the function's memory has its size from here on."""
        if self.places:
            self._code.place(REAL, len(self.places), self.memory.text)
        if not self._rows:
            return ""
        row = ", ".join(f"i64 {n}" for distances in self._rows for n in distances)
        return f"{self._name} = constant [{self._length} x i64] [{row}]\n"
