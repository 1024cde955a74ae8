"""What a start in machine code is given, and what it tells (`codegen.native.begin`).

The *plan* is a row of int64 numbers: the head below, and behind it the lists that it points to.

    candidates   for each the slots of its start value and of its derivative, its class as a state,
                 the number of the candidate that is its derivative (-1: none), and its weight as a
                 guide (the bits of a float64)
    asking       for each that asks to be held its number, -1 where it is no candidate
    blocks       those below the top, as `Below` says
    wanted       the slots of the start values of fixed variables that are no candidates: their rows
                 stand behind those of the blocks
    levels       for each how many numbers it has, blocks, fixed variables, guides besides, written
                 ones of these; then the numbers of the blocks, the rows of the fixed, and of each
                 guide the slot of its value, that of its start value, and its weight

The *room* has these numbers of all candidates first: 1 where the start value is held, 1 where the
states determine it, the size of its column, its start value, and the value that it has at the
start; behind them whatever the start needs.
"""

from __future__ import annotations

from typing import Final

from planarc.ir.flat import StateSelect


class Plan:
    """Numbers of the head: the others are where lists begin."""

    ASKED: Final = 0  # how many ask to be held
    FIXED: Final = 1  # the first of these must be
    FREE: Final = 2  # 1 where there are no conditions: all candidates are held
    BLOCKS: Final = 3  # how many
    LEVELS: Final = 4
    TOGETHER: Final = 5  # 1 where all conditions are looked at once more
    OWN: Final = 6
    ASKING: Final = 7
    BELOW: Final = 8
    WANTED: Final = 9
    LEVEL: Final = 10
    HEAD: Final = 11


class Own:
    """The numbers of a candidate."""

    START: Final = 0
    RATE: Final = 1
    KIND: Final = 2
    DERIVATIVE: Final = 3
    WEIGHT: Final = 4
    COUNT: Final = 5


class Below:
    """The numbers of a block."""

    ROW: Final = 0  # the first of its rows
    ROWS: Final = 1
    FIRST: Final = 2  # the first of its candidates
    TEARS: Final = 3
    LINEAR: Final = 4
    JACOBIAN: Final = 5  # the place in `area`
    JUDGED: Final = 6  # 1 where its rows must be independent of each other
    CHOOSES: Final = 7  # 1 where it chooses its states itself
    COUNT: Final = 8


#: Numbers of a guide that is no candidate, and of a level before its blocks.
GUIDE: Final = 3
LEVEL: Final = 5
#: Numbers for each candidate at the beginning of the room.
TOLD: Final = 5


#: Candidates up to which motions are found sooner by machine code than by LAPACK.
LARGEST: Final = 32
#: Weights of start values as guides: written, of a joint, of others.
WRITTEN: Final = 1.0
JOINT: Final = 1e-3
OTHER: Final = 1e-6
#: A candidate that moves less than this part of a free motion is not held against it.
INDEPENDENT: Final = 1e-3
#: Singular values of conditions below this part of the largest leave a motion free.
CLOSED: Final = 1e-5
#: Distance (radians, metres) up to which an assembly is the one that was meant.
NEAR: Final = 0.5
#: Of a start value, what Newton's method may leave as rounding.
ROUNDING: Final = 1e-14
#: Length (m) or angle (rad) by which a loop may be open.
OPEN: Final = 1e-6
#: Singular values below this part of the largest may tell that rows are dependent.
SUSPECT: Final = 1e-5
#: The class of candidates that must be states, above four times that of any `StateSelect`.
MUST_STAY: Final = 4 * StateSelect.ALWAYS
#: Of two candidates, a pivot of a better class may be smaller by this factor.
GIVE_WAY: Final = 0.2
#: Equal but for rounding counts as equal: the order decides, not the machine.
EQUAL: Final = 1e-9


def room(candidates: int, rows: int) -> int:
    """How many numbers a start needs; of rows there are no more than of candidates."""
    n = candidates
    return (TOLD + 14) * n + 3 * n * n + (1 + n) * rows + 5
