"""What a model with a crowd says of itself, in the table `px_touches`, and memory of its steps."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum, auto

from planarc.codegen.native.assembly import INT, POINTER, Code, Value
from planarc.instance.plan import Own
from planarc.ir.program import Program


class Count(IntEnum):
    """Numbers at the begin of the table; behind them is told where each `Part` begins."""

    SENSED = 0  # values that stand in no slot
    TOUCHES = auto()
    PORTS = auto()
    MEMBERS = auto()
    CROWDS = auto()
    COLOURS = auto()
    ROOM = auto()  # impulses that are remembered, at most
    JAM = auto()  # the number of the message of the first touch that begins closed


class Part(IntEnum):
    """Arrays of the table. A value is told by its slot, or, from the size of the workspace on, by
    its place among those that `px_feel` gives."""

    RATES = 0  # values, one a port
    ACCELERATIONS = auto()
    PUSHES = auto()  # slots
    BEFORE = auto()
    STILL = auto()  # 1 where nothing moves it
    COLOUR = auto()
    FELT_STARTS = auto()  # the pushes that each port feels
    FELT = auto()
    STATE_STARTS = auto()  # those that the derivative of each candidate does
    STATE_FELT = auto()
    OF_TOUCHES = auto()  # values: gaps, then restitution, then friction
    LOWS = auto()  # slots of the gaps at which touches would meet at events
    FIRST_MEMBERS = auto()  # of each crowd, and behind the last
    FIRST_KEYS = auto()
    MEMBERS = auto()  # values, as of `Of`
    PORT = auto()  # the first one of each member


class Of(IntEnum):
    """What a member reads: arrays with a value for each."""

    X = 0
    Y = auto()
    PHI = auto()
    FROM_X = auto()
    FROM_Y = auto()
    TO_X = auto()
    TO_Y = auto()
    RADIUS = auto()
    E = auto()
    MU = auto()


class Kept(IntEnum):
    """What is remembered from step to step, in `Own.TOUCHES`."""

    ORIGIN = 0  # times of steps are reckoned from here
    INDEX = auto()  # steps since then
    BEGIN = auto()  # of the last step
    MIDDLE = auto()
    COUNT = auto()  # impulses of its contacts, by keys that rise
    FIRST = auto()  # the keys; then normal impulses, then those along slips


class Area(IntEnum):
    """Arrays, by pointers at `Own.CONTACT`; from `KEY` on they are a step's own, of k contacts."""

    SENSED = 0
    FORCES = auto()  # one a port, as the following
    VELOCITIES = auto()  # at the begin
    AFTER = auto()  # at the end, without contacts
    FREE = auto()  # accelerations without forces
    MOVED = auto()  # with one
    ACTIVE = auto()
    IMPULSE = auto()
    T_STARTS = auto()
    M_STARTS = auto()
    RESPONSE = auto()  # entries of the table's `FELT`
    STATES = auto()  # of its `STATE_FELT`
    IS_PLACE = auto()  # one a state, as the following
    SPEED = auto()  # the state that is the derivative of a place, or -1
    CANDIDATE = auto()
    SLOPES = auto()
    OTHERS = auto()
    WHERE = auto()  # by slots: a candidate's number, then a state's
    GAPS = auto()  # of touches, with restitution and friction
    BODIES = auto()  # of members, as of `Of`
    ENDS = auto()  # x of the begin of its middle line, y, then those of its end
    MIDDLE = auto()  # its middle
    BOUND = auto()  # the radius of a circle about that
    BAR = auto()
    FOUND = auto()  # one meeting (`Met`)
    KEY = auto()
    J_STARTS = auto()
    J_COLUMNS = auto()  # two rows of six a contact: along its normal and its slip
    J_VALUES = auto()
    T_COLUMNS = auto()  # the same by ports
    T_VALUES = auto()
    GAP = auto()
    E = auto()
    MU = auto()
    X = auto()  # impulses; 2k each, as the following
    WAY = auto()  # motion behind them
    U = auto()  # at the begin
    GAINED = auto()  # without contacts, at the end
    REST = auto()
    INVERSE = auto()
    SUMS = auto()
    MARKS = auto()
    LEAST = auto()
    BOUNCES = auto()
    A_STARTS = auto()
    M_COLUMNS = auto()  # in memory of their own, since their sizes follow from the contacts
    M_VALUES = auto()
    A_COLUMNS = auto()
    A_VALUES = auto()


class Met(IntEnum):
    """One meeting of two members."""

    GAP = 0
    X = auto()  # the normal
    Y = auto()
    ARM_X = auto()  # of the first member, then of the second
    ARM_Y = auto()
    OTHER_X = auto()
    OTHER_Y = auto()


#: Words of each array of a step with k contacts.
OF_CONTACTS = {
    Area.KEY: 1, Area.J_STARTS: 2, Area.J_COLUMNS: 12, Area.J_VALUES: 12, Area.T_COLUMNS: 12,
    Area.T_VALUES: 12, Area.GAP: 1, Area.E: 1, Area.MU: 1, Area.X: 2, Area.WAY: 2, Area.U: 2,
    Area.GAINED: 2, Area.REST: 2, Area.INVERSE: 2, Area.SUMS: 2, Area.MARKS: 2, Area.LEAST: 1,
    Area.BOUNCES: 1, Area.A_STARTS: 2,
}  # fmt: skip


def kept_words(table: Sequence[int]) -> int:
    """Words that are remembered, of a model with this table."""
    return int(Kept.FIRST) + 3 * table[Count.ROOM]


def sizes(table: Sequence[int], program: Program) -> dict[int, int]:
    """Words of each array, of a model with this table."""
    counts = {which: table[which] for which in Count}
    members = counts[Count.MEMBERS]
    found = {int(which): 0 for which in Area}
    for which in Area:
        if Area.FORCES <= which <= Area.M_STARTS:
            found[which] = counts[Count.PORTS] + 1
        elif Area.IS_PLACE <= which <= Area.OTHERS:
            found[which] = program.state_count

    def entries(part: Part) -> int:
        first = len(Count) + part
        return table[first + 1] - table[first]

    return found | {
        Area.SENSED: counts[Count.SENSED],
        Area.RESPONSE: entries(Part.FELT),
        Area.STATES: entries(Part.STATE_FELT),
        Area.WHERE: 2 * program.size,
        Area.GAPS: 3 * counts[Count.TOUCHES],
        Area.BODIES: len(Of) * members,
        Area.ENDS: 4 * members,
        Area.MIDDLE: 2 * members,
        Area.BOUND: members,
        Area.BAR: members,
        Area.FOUND: len(Met),
    }


def said(c: Code, which: Count) -> Value:
    """A number of the table."""
    return Value(c, POINTER, "@px_touches").load(INT, which)


def part(c: Code, which: Part) -> Value:
    """An array of the table."""
    table = Value(c, POINTER, "@px_touches")
    return table.at(table.load(INT, len(Count) + which))


def arrays(m: Value, *which: Area) -> list[Value]:
    at = m.load(POINTER, Own.CONTACT)
    return [at.load(POINTER, w) for w in which]


def kept(m: Value) -> Value:
    return m.load(POINTER, Own.TOUCHES)
