"""Derivatives: what generated code and its loader agree on.

The *tape* tells as whole numbers in which order derivatives are passed on. `codegen.slopes`
writes it, beside code for the coefficients, and the kernels of both back ends read it: a
tuple of numbers in Python text, a constant in native code. A *node* is a value that
moves when states or parameters do, a *row* ties the motion of its target to those of
its sources, a *group* is a run of rows, with what is solved for in it:

    head      see `Head`; the last entries are where the lists below begin
    starts    of each row the first of its entries, and behind them how many there are
    targets   of each row
    sources   of each entry
    owners    of each node the group that solves for it or depends on what it solves for
    slots     of each node in the workspace (-1: none)
    groups    see `Group`; behind them their tears and residuals, as nodes
    pairs     of each candidate the nodes of itself and of its derivative (-1: it does
              not move)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import Enum, IntEnum


class Scope(Enum):
    """The derivatives that are asked for: those of the states' derivatives and the blocks'
    residuals by states and tears, or of all values, by parameters and inputs too."""

    RATES = "rates"
    ALL = "all"


class Head(IntEnum):
    LENGTH = 0  # of the whole tape
    NODES = 1
    ROWS = 2
    ENTRIES = 3
    GROUPS = 4
    LARGEST = 5  # unknowns of a group
    CANDIDATES = 6
    STARTS = 7
    TARGETS = 8
    SOURCES = 9
    OWNERS = 10
    SLOTS = 11
    TABLE = 12
    PAIRS = 13


class Group(IntEnum):
    FIRST = 0  # row
    INNER = 1  # behind the last row that is not only for the residuals
    STOP = 2
    TEARS = 3  # how many
    RESIDUALS = 4
    LIST = 5  # where its tears, then its residuals stand in the tape
    BLOCK = 6


#: Number of columns that are summed in registers at a time.
CHUNK = 8


class Passing(IntEnum):
    """The memory in which derivatives are passed on along a tape."""

    FRAME = 0
    TAPE = 1
    COEFFICIENTS = 2  # the function that computes them
    VALUES = 3  # the coefficients
    COLUMNS = 4  # int64, of each node: its column where it moves as told, else -1
    MOTIONS = 5  # of each node a row: `WIDTH` columns
    RANGES = 6  # int64, of each node: where its columns that are not zero begin and end
    LOCAL = 7  # of each node a row: its motions with the tears of its group
    SCRATCH = 8  # matrix, right sides and sizes of rows of one group
    WIDTH = 9  # how many columns, a multiple of `CHUNK`
    STRIDE = 10  # how long a row of `LOCAL` is, likewise
    RATES = 11  # int64, of each state the node of its derivative, or -1
    STATE_COLUMNS = 12  # int64
    MOVED = 13  # room for states


class Tape:
    """The numbers by name."""

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = numbers
        self.nodes, self.rows = numbers[Head.NODES], numbers[Head.ROWS]
        self.entries = numbers[Head.ENTRIES]
        self.largest = numbers[Head.LARGEST]
        self.starts = self._list(Head.STARTS, self.rows + 1)
        self.targets = self._list(Head.TARGETS, self.rows)
        self.sources = self._list(Head.SOURCES, self.entries)
        self.slots = self._list(Head.SLOTS, self.nodes)
        pairs = self._list(Head.PAIRS, 2 * numbers[Head.CANDIDATES])
        self.candidates = list(zip(pairs[::2], pairs[1::2], strict=True))
        self.node_of = {slot: node for node, slot in enumerate(self.slots) if slot >= 0}

    def _list(self, head: Head, count: int) -> Sequence[int]:
        begin = self._numbers[head]
        return self._numbers[begin : begin + count]

    def blocks(self) -> Iterator[tuple[int, Sequence[int], Sequence[int]]]:
        """The block, the tears and the residuals of each group that solves."""
        numbers = self._numbers
        for i in range(numbers[Head.GROUPS]):
            at = numbers[Head.TABLE] + i * len(Group)
            record = numbers[at : at + len(Group)]
            begin, tears = record[Group.LIST], record[Group.TEARS]
            middle = begin + tears
            if record[Group.RESIDUALS]:
                found = numbers[begin:middle], numbers[middle : middle + record[Group.RESIDUALS]]
                yield record[Group.BLOCK], *found
