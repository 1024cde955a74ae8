"""Memory of contacts that is no state: it lies behind the states of an instance."""

from __future__ import annotations

from enum import IntEnum, auto

from planarc.instance.plan import Touch
from planarc.solve.contact.touches import TOLD


class Area(IntEnum):
    """Arrays, by pointers at `Own.CONTACT`; k of n touches are closed at an instant."""

    NOW = 0  # what touches read, one array of n behind the other (`Reads`)
    BEFORE = auto()  # the same before anything changes, and `Touch`
    HELD = auto()  # those that were, where `BEFORE` has none that a speed has freed
    FREE = auto()  # motion without forces
    HERE = auto()  # the touches that are closed
    RATES = auto()  # of the states by forces; each state has a row of 2k
    FREE_RATES = auto()
    RESPONSE = auto()  # motion by forces, 2k rows of 2k
    SPEEDS = auto()
    STILL = auto()  # speeds up to this are none
    LOOSE = auto()
    RESTS = auto()
    TIMES = auto()  # for how long one that begins to rest bounces; -1: it does not
    MODES = auto()  # what is found: closed or not, and the way
    IMPULSES = auto()
    FASTEST = auto()
    FREE_HERE = auto()
    MATRIX = auto()  # a problem: motion = matrix*forces + given
    GIVEN = auto()
    MU = auto()
    WAY = auto()
    FLOOR = auto()
    SLACK = auto()  # 1 where one is at the end of its sticking
    RESTITUTION = auto()
    LIST = auto()  # the touches of a problem, among those that are closed
    FORCES = auto()  # a solution, with its cases
    MOTION = auto()
    CASES = auto()
    BEST_FORCES = auto()
    BEST_MOTION = auto()
    BEST_CASES = auto()
    ROWS = auto()  # equations of one case
    SYSTEM = auto()
    RIGHT = auto()
    ORDER = auto()
    PRESSED = auto()  # both phases of a blow
    PRESSED_SPEEDS = auto()
    STRUCK_SPEEDS = auto()
    SUM = auto()
    BEST_SUM = auto()
    TABLE = auto()  # Lemke's method
    BASIS = auto()
    SPARSE = auto()
    COVERED = auto()
    COVER = auto()
    BASIC = auto()
    RUBBING = auto()  # those that may stick or slide
    PRESSES = auto()
    LIMITS = auto()  # joints that rub: limits and errors of the last rounds
    ERRORS = auto()
    STEPS = auto()
    CHANGES = auto()
    JOINTS = auto()
    LOG = auto()  # of each strike at an instant: `LOGGED` before and after, where a run asks


class Reads(IntEnum):
    """What a touch reads, as in `ir.impact`."""

    GAP = 0
    V = auto()
    A = auto()
    SLIP = auto()
    A_SLIP = auto()
    F_N = auto()
    F_T = auto()
    E = auto()
    MU = auto()


class Kept(IntEnum):
    """What is remembered of touches, in `Own.TOUCHES`: arrays of n; then numbers behind them."""

    FIRST = 0  # greatest speeds of impacts
    FALLS = 1  # accelerations after the last ones
    FORCE = 2  # that shows what a force does, 2n
    NUMBERS = 4


class Seen(IntEnum):
    """The numbers behind the arrays of `Kept`."""

    FASTEST = 0
    STRONGEST = auto()
    MOST = auto()
    BEGINS = auto()
    STRIKES = auto()  # of an instant, and how low bounces are, where a run asks
    SHARP = auto()


def kept_words(n: int) -> int:
    """Words that are remembered of n touches."""
    return int(Kept.NUMBERS) * n + len(Seen) if n else 0


#: What of a touch tells what happens to it, and so many strikes of an instant that are told.
LOGGED, STRIKES = tuple(Touch[name.upper()] for name in TOLD), 32


def sizes(n: int, states: int, asks: bool = False) -> dict[int, int]:
    """Words of each array; none where there are no touches."""
    found = {int(which): 2 * n for which in Area}
    lemke = 4 * n
    found |= {
        Area.NOW: len(Reads) * n,
        Area.BEFORE: (len(Reads) + len(Touch)) * n,
        Area.RATES: 2 * n * states,
        Area.FREE_RATES: states,
        Area.TABLE: lemke * (2 * lemke + 2),
        Area.SPARSE: lemke * lemke,
        **dict.fromkeys((Area.RESPONSE, Area.MATRIX, Area.SYSTEM), 4 * n * n),
        **dict.fromkeys((Area.BASIS, Area.COVERED, Area.COVER, Area.BASIC), lemke),
        **dict.fromkeys((Area.LIMITS, Area.ERRORS, Area.STEPS, Area.CHANGES), n * (n + 1)),
        Area.LOG: 2 * len(LOGGED) * STRIKES * n if asks else 0,
    }
    return found if n else {}
