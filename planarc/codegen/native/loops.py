"""Where a loop finds what differs from time to time.

    workspace, w    all that has a slot
    memory          temporaries that loops set, or read where others set them

The places of a column are a first one and the distances from it. Distances that grow evenly are
computed, others stand in the constant `pc_..._rows`, or among rows that the module's functions
share and find in memory (`packed`); numbers that differ stand in `pc_..._numbers`. Columns of
equal distances share a pointer:

    p := w + distance[t];   p[17] := p[3]*p[250]
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value, table
from planarc.codegen.native.packed import Rows
from planarc.codegen.native.rolling import Column
from planarc.ir.expr import Expr

#: Numbers of a function's memory: 128 kB, half of the stack of a page's module.
MOST = 1 << 14


class Loops:
    """The loops of one function, whose first argument is the frame, their memory and their
    constants; `shared` are rows that have none here, `memory` is one that has its size elsewhere.
    """

    def __init__(
        self, code: Code, name: str, shared: Rows | None = None, memory: Value | None = None
    ) -> None:
        self._code, self._name = code, name
        self.memory = memory or Value(code, POINTER, "%memory")
        self._is_own = memory is None
        self.places: dict[Expr, int] = {}  # in the memory
        self._homes: dict[Expr, int] = {}  # the same, of sums only the first
        self.kept: dict[Expr, Expr] = {}  # sums that stand in the place of another one (`summing`)
        self._own = self._rows = Rows()
        self._begin = Value(code, POINTER, f"@{name}_rows")
        if shared is not None:
            self._rows, self._begin = shared, code.arguments[0].load(POINTER, shared.word)
        self._numbers = Rows()  # by their bits
        self._most = 0  # numbers of the memory in use at once
        self.time = code.constant(0, INT)  # how often the loop has run
        self._pointers: dict[tuple[str, tuple[int, ...]], Value] = {}

    def has_room(self, columns: Sequence[Column]) -> bool:
        return self.has_free(sum(map(len, columns)))

    def has_free(self, count: int) -> bool:
        return len(self._homes) + count <= MOST

    def hold(self, temporaries: Iterable[Expr]) -> None:
        """Make room for them."""
        for e in temporaries:
            first = self.kept.get(e, e)
            if first not in self._homes:
                self._homes[first] = len(self._homes)
            self.places[e] = self._homes[first]

    def free(self, count: int) -> Value:
        """Room for numbers that nothing reads any more when another one is held."""
        self._most = max(self._most, self.first_free + count)
        return self.memory.at(self.first_free)

    @property
    def first_free(self) -> int:
        return len(self._homes)

    @property
    def room(self) -> int:
        """Numbers of the memory in use at once."""
        return max(self._most, len(self._homes))

    @contextmanager
    def run(self, times: int) -> Iterator[None]:
        """What stands inside, with `at` by the time; of loops in loops, of the inner one."""
        around = self.time, self._pointers
        with self._code.loop(times) as self.time:
            self._pointers = {}
            yield
        self.time, self._pointers = around

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
        return self.row(words).load(INT, self.time)

    def row(self, words: Sequence[int]) -> Value:
        """Where whole numbers begin."""
        return self._begin.at(self._rows.place(tuple(words)))

    def told(self) -> Value:
        """The number that the rows begin with."""
        return self._begin.load(INT)

    def rows(self, rows: Sequence[Sequence[int]]) -> Value:
        """Where the whole numbers begin that are due."""
        return self._begin.at(self.word([self._rows.place(tuple(row)) for row in rows]))

    def number(self, values: Sequence[float]) -> Value:
        """The number that is due."""
        bits = tuple([struct.unpack("<q", struct.pack("<d", v))[0] for v in values])
        row = Value(self._code, POINTER, f"@{self._name}_numbers").at(self._numbers.place(bits))
        return row.load(REAL, self.time)

    def _distance(self, distances: tuple[int, ...]) -> Value:
        step = distances[1] if len(distances) > 1 else 0
        if distances == tuple(range(0, step * len(distances), step or 1)):
            return self.time * step
        return self.word(distances)

    def text(self) -> str:
        """The constants, where there are some; the function's memory has its size from here on."""
        if self.room and self._is_own:
            self._code.place(REAL, self.room, self.memory.text)
        own = {"rows": self._own, "numbers": self._numbers}
        return "".join(
            table(f"{self._name}_{kind}", rows.numbers)
            for kind, rows in own.items()
            if rows.numbers
        )
