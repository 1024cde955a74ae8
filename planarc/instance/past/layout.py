"""Where the past of delayed signals stands in an instance.

`Frame.PAST` points to words as of `runtime.history.Memory`, so that the kernel's `pc_past` reads
there, and behind them the pointers of `Shelf`. The arrays are part of the state, but for the
work space; the image leaves them out, since a start begins the past anew.

`px_past` is a table of the model: numbers as of `Told`, a row for each delay, slots of inputs.
"""

from __future__ import annotations

from enum import IntEnum, auto

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value
from planarc.instance.block import constant, plan, whole
from planarc.instance.plan import Shelf, Table, Told
from planarc.ir.frame import Frame
from planarc.runtime.history import TERMS, Memory


class Head(IntEnum):
    PIECES = 0  # how many, with the first one and that behind the last step
    UNTIL = auto()  # where the last step ends
    RESUMED = auto()  # signals are smooth from here on
    LIMIT = auto()  # the longest step
    LONGEST = auto()  # the longest delay
    KINKS = auto()  # how many there were
    ROUNDS = auto()  # of the search for a start


class Each(IntEnum):
    """Arrays with a number for each delay."""

    INTERVAL = 0  # not a number where it changes
    MOST = auto()
    LAST = auto()  # the signal where the past ends
    ONE = auto()  # of the search for a start; what comes back from before an event
    TWO = auto()  # of the search for a start; the signal before an event
    LARGEST = auto()  # size of the signal
    CROSSED = auto()  # a whole number: kinks that have come back


class Row(IntEnum):
    """A delay in `px_past`."""

    SLOT = 0
    SIGN = auto()
    INTERVAL = auto()  # its slot where it changes, or -1


#: Points of a step at which signals are taken, the last one only to compare.
POINTS = TERMS + 1


def sizes(delays: int, pieces: int, kinks: int, inputs: int, states: int) -> dict[int, int]:
    """Sizes of the arrays by the words that point to them; those of the state."""
    return {
        Shelf.HEAD: len(Head),
        Shelf.ROWS: len(Each) * delays,
        Shelf.KINKS: 2 * kinks,
        Shelf.MARK: 2 * states + inputs,
        Memory.BOUNDS: 2 * delays,
        Memory.BEGINS: pieces,
        Memory.SCALES: pieces,
        Memory.TERMS: pieces * delays * TERMS,
    }


def work_size(delays: int, inputs: int, states: int) -> int:
    return 2 * TERMS + (POINTS + TERMS) * delays + inputs + 9 * states


class Past:
    """The arrays of an instance, while a function is written."""

    def __init__(self, c: Code, m: Value) -> None:
        self._c = c
        self.memory = memory = m.load(POINTER, Frame.PAST)
        self.head = memory.load(POINTER, Shelf.HEAD)
        self.begins, self.scales, self.terms, self.bounds, self._rows, self.kinks, self._mark = (
            memory.load(POINTER, k)
            for k in (Memory.BEGINS, Memory.SCALES, Memory.TERMS, Memory.BOUNDS, Shelf.ROWS,
                      Shelf.KINKS, Shelf.MARK)
        )  # fmt: skip
        self.table = constant(c, "px_past")
        self.count, self.room, self.inputs = (
            self.table.load(INT, k) for k in (Told.DELAYS, Told.PIECES, Told.INPUTS)
        )
        self.states = n = plan(c, Table.STATES)
        self.times = memory.load(POINTER, Shelf.WORK)
        self.parts = self.times.at(TERMS)  # the times as parts of a piece
        self.values = self.parts.at(TERMS)
        self.found = self.values.at(self.count * POINTS)  # terms of a new piece
        self.ends = self.found.at(self.count * TERMS)  # inputs at the end of a step
        self._vectors = self.ends.at(self.inputs)
        self._n = n

    def each(self, which: Each) -> Value:
        return self._rows.at(self.count * int(which))

    def generations(self) -> Value:
        return self.kinks.at(self.table.load(INT, Told.KINKS))

    def mark(self, place: int) -> Value:
        """States, derivatives, inputs where the past ends."""
        return self._mark.at(self._n * place)

    def vector(self, place: int) -> Value:
        """Room for numbers of all states: at the end of a step states and derivatives, a trial and
        its derivatives, at two points; how the way there bends, twice, and as it was before."""
        return self._vectors.at(self._n * place)

    def told(self, delay: Value, which: Row) -> Value:
        return self.table.load(INT, delay * len(Row) + int(Told.ROWS) + int(which))

    def input(self, i: Value) -> Value:
        """The slot of one."""
        return self.table.load(INT, self.count * len(Row) + int(Told.ROWS) + i)

    def is_fixed(self, delay: Value) -> Value:
        return self.told(delay, Row.INTERVAL) < 0

    def message(self, delay: Value | int, which: int = 0) -> Value:
        """The number of a delay's message, or behind all of them that of the whole past."""
        first = self.table.load(INT, Told.MESSAGES)
        place = whole(self._c, delay) if isinstance(delay, int) else delay
        return first + place * 2 + which

    def pieces(self) -> Value:
        return self.head.load(INT, Head.PIECES)

    def first_term(self, piece: Value, delay: Value) -> Value:
        return self.terms.at((piece * self.count + delay) * TERMS)

    def real(self, which: Head) -> Value:
        return self.head.load(REAL, int(which))
