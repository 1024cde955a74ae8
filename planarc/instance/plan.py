"""The memory of one instance: a block of words of 8 bytes, the same wherever it runs.

    words of `Own`    pointers into the block, the host's callbacks; then numbers
    arrays            states, their derivatives, steps of an integrator, ...
    the kernel's      workspace, numbers, accepted, area (`planarc.ir.frame`)

The block begins with the kernel's frame, so that its address is the frame's, too. What lies
behind the pointers (from `Own.PHASE` on) is the whole state of an instance: to save it is to
copy it.

`Table` are the numbers of a model that its functions read, a constant `px_plan` in the code.

The file is long because it names each word of the memory.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from enum import IntEnum, auto
from itertools import accumulate

from planarc.core.data import Data
from planarc.ir.dae import INITIAL, TERMINAL, Impact, Kind
from planarc.ir.derivatives import CHUNK, Head, Passing
from planarc.ir.frame import Frame, place
from planarc.ir.program import ParameterSlot, Program
from planarc.runtime.history import Memory
from planarc.solve.events.instants import by_way_of_variables, lines_of_time


class Own(IntEnum):
    """Words behind the frame's."""

    Y = len(Frame)  # pointers to arrays
    RATES = auto()
    SCALES = auto()
    GIVEN = auto()  # of each start the reference by which it was set, and 1; 0: it was not
    STARTS = auto()
    STAGES = auto()
    WARNED = auto()  # 1 of each assertion that only warns and was told
    NEAR = auto()  # the states at the accepted point, where loops are closed from there
    RELATIONS = auto()  # numbers of each relation (`Relation`)
    SNAPSHOTS = auto()  # truths and discrete values, three times
    SEEN = auto()  # of the snapshots that an iteration went through
    BRANCHES = auto()  # which branch of each `when` acts: 0 none, 1 the first
    SAMPLES = auto()  # numbers of each `sample` (`Sample`)
    TOUCHES = auto()  # what is remembered of touches (`Kept` of `instance.contact`, or `.crowd`)
    CONTACT = auto()  # pointers to what is no state of contacts (`Area` there)
    PASSING = auto()  # where derivatives are passed on (`ir.derivatives.Passing`): no state
    NODES = auto()  # of each slot, in the tape of derivatives: the first of what is unpacked
    RULES = auto()  # what may be set in each slot (`rules`)
    DISCRETES = auto()  # slots of each discrete variable
    CONSTANTS = auto()  # numbers of statements that are carried out, the first one last
    OPERATIONS = auto()  # those of statements that are carried out: no state
    LOOKS = auto()  # zero functions at some times within a step (`Look`): no state
    ROUTE = auto()  # room for a way that is gone in parts (`reaching`): no state
    ROWS = auto()  # places that loops over equal statements read and set
    SLOPE_ROWS = auto()  # those of the derivatives, behind the first of their operations
    BLOCKS = auto()  # tables that the file of the model's numbers holds, where it has one
    OF_RELATIONS = auto()
    OF_TOUCHES = auto()
    SYSTEM = auto()
    NOMINALS = auto()
    QUIET = auto()
    MESSAGES = auto()  # its texts
    STORED = auto()  # what the file of the model's numbers holds, where it has one
    PACKED = auto()  # its part to unpack
    TEXT = auto()  # a message with its values, which stand behind it: no state
    HOST = auto()  # what the host wants to be told with each message
    LOGGER = auto()
    LOGGING = auto()
    BEGUN = auto()  # the phase behind initialization
    EVENTS = auto()  # 1 where the host handles events of co-simulation
    EARLY = auto()  # 1 where its steps may end early
    UPDATE = auto()  # what of the host is called within them
    PHASE = auto()  # from here on the state
    STALE = auto()  # see `Stale`
    TOLERANCE = auto()
    BOUND = auto()  # of the sensitivity at which other states are taken
    STEP = auto()  # the integrator's next one
    WAITING = auto()  # 1 where other states are to be taken at the next event
    STOP = auto()  # the time behind which no step may go
    EXACT = auto()  # 1 where the present point lies on the last step
    REACH = auto()  # the time at which that ended
    SPAN = auto()  # its length
    AHEAD = auto()  # how far it is looked ahead at an event
    TOUCHED = auto()  # 1 where an input was set since the last event
    RESET = auto()  # 1 where an event set a state anew
    MOVED = auto()  # 1 where an impact did
    ENDED = auto()  # the message with which an event ended the run, 0: none
    OVER = auto()  # 1 where the run was terminated
    CROWDED = auto()  # crossings in a row, each right behind the one before
    LATEST = auto()  # when the last one was
    NODE = auto()  # the first part of a step at which a relation has crossed; 2: none
    CROSSED = auto()  # 1 where the step ends behind a crossing
    CALLED = auto()  # 1 where the host is to handle an event
    STIFF = auto()  # 1.0 where steps are those of `stiff`; with a crowd the length of its steps
    DOUBT = auto()  # 1 where a run in Python is to decide what happens here
    MARGIN = auto()  # what is left until other states are to be taken
    FIRST = auto()


class Relation(IntEnum):
    """What is known of relations, in arrays with a number for each."""

    NOW = 0  # their zero functions, where they were evaluated last
    LARGEST = auto()  # the greatest sizes seen
    WIDTH = auto()  # how far beyond zero they cross
    SHOWN = auto()  # what a host sees
    BEFORE = auto()  # zero functions as integration left them
    HELD_AT = auto()
    BOUND = auto()
    RISES = auto()
    TRIAL = auto()
    INSTANT = auto()  # when a relation of time alone switches
    AFTER = auto()  # its truth from then on
    CROSSING = auto()  # whole numbers from here: 1 where one crosses here
    HELD = auto()
    LATE = auto()
    TURNED = auto()
    RESTLESS = auto()
    BEYOND = auto()  # 1 where an event left it beyond zero, since neither truth agreed


class Row(IntEnum):
    """What the table `px_relations` says of a relation."""

    SLOT = 0
    STRICT = auto()
    OF_TIME = auto()
    TIMED = auto()  # its instant is known
    SWINGS = auto()  # a `Swing`: what it hangs on, where it may switch often within a step
    TOUCH = auto()  # it belongs to a touch, whose operator sets what it compares


class Swing(IntEnum):
    """What relations hang on that may switch any number of times within a step."""

    NOTHING = 0  # there is none
    TIME = auto()  # time alone
    STATES = auto()


class Look(IntEnum):
    """Times within a step at which zero functions are kept, where any swings."""

    EARLIEST = 0  # of its stages
    EARLIER = auto()
    LATER = auto()
    LATEST = auto()
    HERE = auto()  # where it was looked at last
    MANY = auto()  # of so many as `LOOKS` the first one


class Touch(IntEnum):
    """What the table `px_touches` says of a touch: slots, as of `ir.impact.KEPT`."""

    HELD = 0
    WAY = auto()
    REST = auto()
    IMPULSE = auto()
    LOW = auto()
    PUSH_N = auto()
    PUSH_T = auto()
    JOINT = auto()  # 1 where it is a joint that rubs, which neither parts nor meets


class Jam(IntEnum):
    """Why a run ends at a touch; each has messages for all of these."""

    OVERLAP = 0
    ONE_BODY = auto()
    NO_IMPACT = auto()
    NO_FORCES = auto()
    UNSOLVED = auto()


class Sample(IntEnum):
    """Arrays with a number for each `sample`."""

    START = 0
    INTERVAL = auto()
    TICKS = auto()  # that have passed
    FIRED = auto()  # a whole number: 1 where it fires here


class Phase(IntEnum):
    """The states of the standard's machine. `PAUSE` is the event mode of co-simulation, `MEANWHILE`
    a step's while the host looks."""

    INSTANTIATED = 0
    INITIALIZATION = 1
    EVENT = 2
    CONTINUOUS = 3
    STEP = 4
    PAUSE = 5
    MEANWHILE = 6
    TERMINATED = 7
    FAILED = 8


class Stale(IntEnum):
    """What of the workspace does not fit the time and states."""

    NOTHING = 0
    REST = 1  # what only results need
    ALL = 2
    START = 3  # the start itself


class Table(IntEnum):
    """Places in `px_plan`."""

    WORDS = 0  # of a block that are saved with its state
    STATES = 1
    SIZE = 2  # of the workspace
    OPEN = 3  # blocks with a choice of states
    GIVEN = 4  # start values that may be set
    HELD = 5  # rows of the start system that hold a value
    MOVED = 6  # its unknowns
    WIDTH = 7  # its rows
    NOMINALS = 8
    WORKSPACE = 9  # where it begins in the image
    MARGIN = 10  # the word of the margin, reckoned from the workspace
    ROOM = 11  # words of a block, with those that are no state
    RELATIONS = 12
    INDICATORS = 13  # relations that a host sees
    DISCRETES = 14
    SAMPLES = 15
    QUIET = 16  # unknowns beside which numbers are small
    INITIAL = 17  # the slots of `initial()` and `terminal()`, of the start time; or -1
    TERMINAL = 18
    BEGIN = 19
    NONLINEAR = 20  # blocks that are not linear
    TOUCHES = 21
    JAMS = 22  # the number of the first message of touches (`Jam`)
    PACKED = 23  # whole numbers to unpack
    SLOPES = 24  # 1 where the model can be differentiated
    STORED = 25  # words of the file of numbers, 0: there is none
    LOOPS = 26  # blocks that Newton's method solves from a point near by
    SWINGS = 27  # a `Swing`
    POINTERS = 28  # where arrays begin, for the words `Frame.W` ... and `Own.Y` ...


class Shelf(IntEnum):
    """Pointers of the past of delayed signals (`instance.past`), behind those of `Memory`."""

    HEAD = len(Memory)
    ROWS = auto()
    KINKS = auto()  # times, then generations
    MARK = auto()  # states, their derivatives and inputs, where the past ends
    WORK = auto()  # no state


class Told(IntEnum):
    """Numbers in the table `px_past`."""

    DELAYS = 0
    PIECES = auto()  # room for so many
    KINKS = auto()
    INPUTS = auto()
    IMAGE = auto()  # words of a new state
    MESSAGES = auto()  # the number of the first message of delays
    ROWS = auto()


#: Snapshots that an iteration compares, and passes of one before it is called endless.
SNAPSHOTS, PASSES = 3, 100
#: Stages of a step of the integrator, and vectors that it needs besides.
STAGES = 10
#: Looks within a step that are kept at once.
LOOKS = 10

#: Room for a message with its values put in.
LETTERS = 512

#: Values that `rules` gives a slot.
NEVER, PARAMETER, WHOLE_PARAMETER, TUNABLE, INPUT, FIRST_GIVEN = 0, 1, 2, 3, 4, 16


class Lags(Data):
    """The room for the past: sizes of arrays that are state, by the words that point to them, and
    of the work space."""

    pieces: int
    state: dict[int, int]
    work: int


class Plan(Data):
    """`homes` are pairs (word of the pointer, word at which the array begins)."""

    words: int
    room: int
    image: int  # words of a new state: what follows a start makes
    homes: tuple[tuple[int, int], ...]
    given: tuple[tuple[int, int], ...]  # slots of held values, with those of their starts


def make_plan(
    program: Program,
    given: tuple[tuple[int, int], ...],
    scales: int,
    tape: Sequence[int],
    rows: tuple[int, int],
    kept: int,
    area: Mapping[int, int],
    values: int,
    lags: Lags | None = None,
    memory: int = 0,
    constants: int = 0,
    operations: int = 0,
    tables: Mapping[int, Sequence[int]] | None = None,
    packed: int = 0,
    letters: int = 0,
) -> Plan:
    """`given`: the values held at the start; `scales`: tears of the blocks with a choice; `tape`:
    that of the derivatives; `rows`: numbers that loops share, and those that derivatives have;
    `kept`: words that are remembered of touches; `area`: sizes of what is no state of them;
    `values`: most values of a message; `lags`: those of the past of delayed signals; `memory`:
    numbers of that of statements, before the workspace so many `constants`, and words of their
    `operations`; where there is a file of numbers, `tables` that it holds by the words that point
    to them, `packed` words besides the image, and those of its `letters`."""
    placed, n = place(program), program.state_count
    loops = count_loops(program)
    sizes: dict[int, int] = {
        Own.Y: n,
        Own.RATES: n,
        Own.SCALES: scales,
        Own.GIVEN: len(given),
        Own.STARTS: len(given),
        Own.STAGES: STAGES * n,
        Own.WARNED: sum(a.warning for a in program.assertions),
        Own.NEAR: n if loops else 0,
        **event_sizes(program, passes(program) if is_eventful(program) else 0),
        Own.TOUCHES: kept,
        Own.CONSTANTS: constants,
        Frame.W: program.size,
        Frame.NUMBERS: placed.numbers,
        Frame.ACCEPTED: placed.accepted,
        Frame.AREA: placed.area,
    }
    starts = list(accumulate(sizes.values(), initial=int(Own.FIRST)))
    homes = list(zip(map(int, sizes), starts, strict=False))
    image = passing = starts[-1]
    past: dict[int, int] = {}
    if lags is not None:
        starts = list(accumulate(lags.state.values(), initial=passing))
        past, passing = dict(zip(lags.state, starts, strict=False)), starts[-1]
    words, passing = passing, passing + memory
    rooms = _passing(tape, n)
    begins = list(accumulate(rooms.values(), initial=passing + len(Passing)))
    homes += [(int(Own.PASSING), passing)]
    homes += [(passing + k, at) for k, at in zip(rooms, begins, strict=False)]
    contact, room = begins[-1], begins[-1]
    if area:
        begins = list(accumulate(area.values(), initial=contact + len(area)))
        homes += [(int(Own.CONTACT), contact)]
        homes += [(contact + k, at) for k, at in zip(area, begins, strict=False)]
        room = begins[-1]
    if lags is not None:
        past[Shelf.WORK] = room + len(Memory) + len(Shelf)
        homes += [(int(Frame.PAST), room), *((room + k, at) for k, at in past.items())]
        room = past[Shelf.WORK] + lags.work
    unpacked = {Own.NODES: program.size + 1, Own.RULES: program.size + 1,
                Own.DISCRETES: 3 * len(program.discretes), Own.ROWS: rows[0],
                Own.SLOPE_ROWS: rows[1], passing + Passing.TAPE: tape[Head.LENGTH]}  # fmt: skip
    unpacked |= {word: len(numbers) for word, numbers in (tables or {}).items()}
    begins = list(accumulate(unpacked.values(), initial=room))
    homes += [(int(k), at) for k, at in zip(unpacked, begins, strict=False)]
    room = begins[-1]
    looks = (Look.MANY + LOOKS) * len(program.relations) if swinging(program) else 0
    homes += [(int(Own.OPERATIONS), room), (int(Own.LOOKS), room + operations)]
    homes += [(int(Own.ROUTE), room + operations + looks)]
    room += operations + looks + (n + placed.accepted if loops else 0)
    homes += [(int(Own.TEXT), room)]
    room += LETTERS // 8 + values
    if packed:
        behind = room + 1 + image - Own.PHASE
        homes += [(int(Own.STORED), room), (int(Own.PACKED), behind)]
        homes += [(int(Own.MESSAGES), behind + packed)]
        room = behind + packed + letters
    return Plan(words, room, image, tuple(homes), given)


def count_loops(program: Program) -> int:
    """The blocks that Newton's method solves from a point near by."""
    return sum(bool(b.residuals) and not b.linear for b in program.blocks)


def swinging(program: Program, timed: Collection[int] = ()) -> dict[int, Swing]:
    """The relations that may switch any number of times within a step, and what they hang on: all
    that follow from time, but as lines over it, and where a sine of states may."""
    by_way, lines = by_way_of_variables(program), lines_of_time(program)
    found = {i: Swing.STATES for i, r in enumerate(program.relations) if r.waves}
    found |= {i: Swing.TIME for i, r in enumerate(program.relations) if r.time_only or i in by_way}
    return {i: swing for i, swing in found.items() if i not in lines and i not in timed}


def swings(program: Program, timed: Collection[int] = ()) -> Swing:
    """What these hang on."""
    found = swinging(program, timed)
    if not found:
        return Swing.NOTHING
    alone = all(program.relations[i].time_only for i in found)  # by itself, not by way of others
    return Swing.TIME if alone else Swing.STATES


def event_sizes(program: Program, seen: int) -> dict[int, int]:
    """Sizes of the arrays in which events are iterated, of so many passes that are remembered."""
    relations = len(program.relations)
    return {
        Own.RELATIONS: len(Relation) * relations,
        Own.SNAPSHOTS: SNAPSHOTS * (relations + len(program.discretes)),
        Own.SEEN: seen,
        Own.BRANCHES: len(program.whens),
        Own.SAMPLES: len(Sample) * len(program.samplers),
    }


def distances(program: Program, lags: Lags | None) -> tuple[int, int]:
    """How far behind the workspace the memory of statements begins, and the kernel's area."""
    placed = place(program)
    area = program.size + placed.numbers + placed.accepted
    past = 0 if lags is None else sum(lags.state.values())
    return area + placed.area + past, area


def passes(program: Program) -> int:
    """Passes of an iteration: each discrete variable may wait for the one before it."""
    return PASSES + len(program.discretes)


def _passing(tape: Sequence[int], states: int) -> dict[int, int]:
    """Sizes of the arrays in which derivatives are passed on, all states' at once."""
    nodes, largest = tape[Head.NODES], tape[Head.LARGEST]
    width, stride = (-(-max(n, 1) // CHUNK) * CHUNK for n in (states, largest))
    return {
        Passing.VALUES: tape[Head.ENTRIES],
        Passing.COLUMNS: nodes,
        Passing.MOTIONS: nodes * width,
        Passing.RANGES: 2 * nodes,
        Passing.LOCAL: nodes * stride,
        Passing.SCRATCH: largest * (largest + width + 1),
        Passing.MOVED: 2 * states * states + 4 * states,  # of `instance.stiff`
    }


def rules(
    program: Program, given: Sequence[tuple[int, int]], tunable: Collection[str]
) -> list[int]:
    """What may be set in each slot, and behind them in what is none; `tunable` are names of
    parameters that may be at any time."""
    found = [NEVER] * (program.size + 1)
    for k, (slot, _) in enumerate(given):
        found[slot] = FIRST_GIVEN + k
    for p in program.parameter_slots:
        if is_settable(p):
            found[p.slot] = PARAMETER if p.kind is Kind.REAL else WHOLE_PARAMETER
            if p.name in tunable:
                found[p.slot] = TUNABLE
    for name in program.inputs:
        found[program.slots[name]] = INPUT
    return found


def is_eventful(program: Program) -> bool:
    """Whether anything happens at instants behind the start."""
    return program.switches or bool(program.delays) or program.table.knows(TERMINAL)


def crowd_names(program: Program) -> tuple[str, ...]:
    """The crowds of a model, which steps of one length follow."""
    branches = (b for when in program.whens for b in when.branches)
    actions = (a for *_, found in branches for a in found)
    return tuple(dict.fromkeys(a.component for a in actions if isinstance(a, Impact) and a.crowd))


def starts_anew(program: Program) -> bool:
    """Whether the start itself is an event: an instance begins with it."""
    return is_eventful(program) or INITIAL in program.slots


def is_settable(p: ParameterSlot) -> bool:
    """Whether a host may set a parameter."""
    return p.settable and not p.structural and not p.final and p.kind is not Kind.STRING
