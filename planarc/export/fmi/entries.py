"""Functions of the standard, in LLVM: what is the same for each of them.

Every function looks at its instance first: that there is one, and that it is in a phase in
which the function may be called. What goes wrong is told to the host's logger in words, and by
the standard's status; nothing else happens then.

Derivatives stand in `derivatives`. The file is long because the standard has many functions; each
takes a few lines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, SELDOM, Code, Value
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import (
    BYTE,
    constant,
    is_null,
    larger,
    load_narrow,
    load_signed,
    nominal_of,
    plan,
    store_narrow,
    whole,
)
from planarc.instance.ends import CROWDED
from planarc.instance.plan import Own, Phase, Relation, Row, Stale, Table
from planarc.instance.relations import numbers_of, told
from planarc.instance.said import MARK
from planarc.instance.settling import ACTED, DENSE, ENDLESS, UNSOLVED
from planarc.instance.text import text_constant
from planarc.ir.frame import Frame, Number

#: Categories of messages, by the standard's names: of warnings, of all others.
CATEGORIES = ("logStatusWarning", "logStatusError")
OK, WARNING, DISCARD, ERROR, FATAL = range(5)
#: Where ticks cannot be told apart (`DENSE`).
DENSELY = "a `sample` becomes true at more instants than a run can tell apart"
#: What messages are filled with.
_NOW, _SUBJECT = f"at t = {MARK}t6 s", f"{MARK}w0"
NUMBER, INTEGER, TRUTH = 0, 1, 2  # kinds of references
#: The largest integer of 32 bits. Of planarc's own the largest one has 53.
_MOST = 2.0**31 - 1
ALWAYS = tuple(p for p in Phase if p is not Phase.MEANWHILE)
ANYWHERE = tuple(p for p in ALWAYS if p is not Phase.FAILED)
RUNNING = (Phase.EVENT, Phase.CONTINUOUS, Phase.STEP, Phase.PAUSE)
SETTING = (Phase.INSTANTIATED, Phase.INITIALIZATION, *RUNNING)
EVALUABLE = (Phase.INITIALIZATION, *RUNNING, Phase.TERMINATED)


class Entries:
    """The functions of one version while they are written. `log` writes how its logger is called:
    (code, instance, status, category, message); `plain` makes a text one that a logger shows as it
    is; `delayed`: the model has a past, which steps of the host become part of; `by_uri`: the
    folder of resources is told so, and not by its path; `crowded`: it takes steps of one length,
    and is not for model exchange; `warns`: what assertions only warn of is told, too."""

    def __init__(
        self,
        log: Callable[[Code, Value, Value, Value, Value], None],
        plain: Callable[[str], str] = str,
        delayed: bool = False,
        by_uri: bool = False,
        crowded: bool = False,
        warns: bool = False,
    ) -> None:
        self.crowded, self.warns = crowded, warns
        self.as_shown, self._delayed, self.by_uri = plain, delayed, by_uri
        self.tells = False  # whether `px_notice` of the module is told of events
        self.names: list[str] = []
        self._texts: list[str] = []
        self._helpers: dict[str, str] = {}
        self._strings: dict[str, str] = {}
        c = Code("px_log", "void", ((POINTER, "m"), (FLAG, "status"), (POINTER, "message")))
        m, status, message = c.arguments
        given = c.emit("i1", f"icmp ne ptr {m.load(POINTER, Own.LOGGER).text}, null")
        with c.when(given):
            text = c.call(POINTER, "px_fill", m, message)
            kinds = (constant(c, self.string(kind)) for kind in CATEGORIES)
            log(c, m, status, c.select(status.equals(WARNING), *kinds), text)
        c.give()
        self._texts.append(c.text(SELDOM))
        if warns:
            self._texts.append(_warn())
        self._texts.append(_may())

    def text(self) -> str:
        """The functions and their messages."""
        strings = (text_constant(name, text) for text, name in self._strings.items())
        return "\n".join((*strings, *self._helpers.values(), *self._texts))

    def also(self, text: str) -> None:
        """Put something else into the module."""
        self._texts.append(text)

    def string(self, text: str) -> str:
        return self._strings.setdefault(text, f"px_text_{len(self._strings)}")

    def _ask(
        self, c: Code, name: str, arguments: str, write: Callable[..., None], *given: Value
    ) -> None:
        """Call what many functions of the standard call; where it gives another status than that
        all is well, it is what the function gives."""
        if name not in self._helpers:
            helper = Code(name, FLAG, _pairs(arguments))
            write(helper, *helper.arguments)
            self._helpers[name] = helper.text(SELDOM)
        _unless_well(c, c.call(FLAG, name, *given))

    @contextmanager
    def entry(
        self, name: str, arguments: str, phases: Iterable[Phase] = ANYWHERE
    ) -> Iterator[tuple[Code, list[Value]]]:
        """A function of an instance; it succeeds when nothing else is given."""
        with self.plain(name, f"ptr m, {arguments}".rstrip(", ")) as (c, given):
            refused = self._may(
                c,
                given[0],
                phases,
                f"{name} cannot be called now: see the standard's state machine",
            )
            _unless_well(c, refused)
            yield c, given
            c.give(OK)

    @contextmanager
    def plain(
        self, name: str, arguments: str, result: str = FLAG
    ) -> Iterator[tuple[Code, list[Value]]]:
        """A function without an instance, or one that gives something else."""
        c = Code(name, result, _pairs(arguments))
        yield c, c.arguments
        self._texts.append(c.text(SELDOM))
        self.names.append(name)

    def refused(self, names: Iterable[str]) -> None:
        """Functions that a model of planarc does not have."""
        for name in names:
            with self.plain(name, "ptr m") as (c, (m,)):
                c.give(self._may(c, m, (), f"{name} is not offered by this model"))

    def _may(self, c: Code, m: Value, phases: Iterable[Phase], message: str) -> Value:
        """0 where the instance is in one of these phases, else what the function gives."""
        allowed = whole(c, sum(1 << p for p in phases))
        text = constant(c, self.string(self.as_shown(message)))
        return c.call(FLAG, "px_may", m, allowed, text)

    def fail(self, c: Code, m: Value, message: str, status: int = ERROR) -> None:
        self.tell(c, m, message, status)
        c.give(status)

    def tell(self, c: Code, m: Value, message: str, status: int = ERROR) -> None:
        text = constant(c, self.string(self.as_shown(message)))
        c.run("px_log", m, c.constant(status, FLAG), text)

    # What both versions do

    def enter(self, c: Code, m: Value, phase: Phase) -> None:
        m.store(whole(c, phase), Own.PHASE)

    def refresh(self, c: Code, m: Value, least: Stale) -> None:
        """Evaluate, or say that there is no value here."""
        self._ask(c, "px_fresh", "ptr m, i64 least", self._fresh, m, whole(c, least))

    def _fresh(self, c: Code, m: Value, wanted: Value) -> None:
        flag = c.call(FLAG, "px_refresh", m, wanted)
        with c.when(flag.equals(0), leaves=True):
            c.give(OK)
        starting = m.load(INT, Own.STALE).equals(Stale.START)
        with c.when(starting & flag.equals(ACTED), leaves=True):
            text = c.call(POINTER, "px_message", m, c.flag(m.load(INT, Own.ENDED)))
            c.run("px_log", m, c.constant(ERROR, FLAG), text)
            c.give(ERROR)
        with c.when(starting & flag.equals(DENSE), leaves=True):
            self.fail(c, m, DENSELY)
        with c.when(starting, leaves=True):
            self.fail(
                c,
                m,
                "with these parameters and start values no start is found from the assembly "
                "that the model was exported with: a loop does not close, or the way there "
                f"is too far; {_SUBJECT}",
            )
        self.fail(c, m, f"{_NOW} {_SUBJECT}", DISCARD)

    def check(self, c: Code, m: Value) -> None:
        """The assertions of the model, at a point that was evaluated to the end."""
        self._ask(c, "px_checked", "ptr m", self._checked, m)

    def _checked(self, c: Code, m: Value) -> None:
        w, _, _, _ = open_frame(m)
        found = c.call(FLAG, "px_asserts", m, w.load(REAL))
        with c.when(found > 0, leaves=True):
            self.enter(c, m, Phase.FAILED)
            c.run("px_values", m, c.emit(INT, f"sext i32 {found.text} to i64"))
            text = c.call(POINTER, "px_message", m, found)
            c.run("px_log", m, c.constant(ERROR, FLAG), text)
            c.give(ERROR)
        c.give(OK)

    def getter(
        self, name: str, kind: int, type: str, counted: bool, large: bool = False
    ) -> None:  # fmt: skip
        """`counted`: the number of values stands behind them, too; `large`: one may need more than
        32 bits."""
        arguments = "ptr references, i64 count, ptr values" + ", i64 length" * counted
        phases = (*EVALUABLE, Phase.MEANWHILE)
        with self.entry(name, arguments, phases) as (c, (m, references, count, values, *_)):
            self.refresh(c, m, Stale.NOTHING)
            with c.loop(count) as i:
                reference = load_narrow(c, "i32", references, i)
                place = c.call(POINTER, "px_place", m, reference, whole(c, kind))
                none = c.emit("i1", f"icmp eq ptr {place.text}, null")
                with c.when(none, leaves=True):
                    self.fail(c, m, f"{name}: there is no such variable")
                value = place.load(REAL)
                odd = (reference - reference / 2 * 2).equals(1)
                value = c.select(odd, c.constant(0.0, REAL) - value, value)
                if large and kind == INTEGER and type != INT:
                    with c.when(c.absolute(value) > _MOST, leaves=True):
                        self.fail(c, m, f"{name}: the value needs more than 32 bits", DISCARD)
                if kind == NUMBER:
                    values.store(value, i)
                elif type == INT:
                    values.store(c.whole(value), i)
                else:
                    store_narrow(c, type, values, c.whole(value), i)

    def setter(self, name: str, kind: int, type: str, counted: bool) -> None:
        arguments = "ptr references, i64 count, ptr values" + ", i64 length" * counted
        with self.entry(name, arguments, SETTING) as (c, given):
            m, references, count, values = given[:4]
            with c.loop(count) as i:
                reference = load_narrow(c, "i32", references, i)
                if kind == NUMBER:
                    value = values.load(REAL, i)
                elif kind == INTEGER:
                    number = values.load(INT, i) if type == INT else load_signed(c, values, i)
                    value = c.real(number)
                else:
                    bit = load_narrow(c, type, values, i)
                    value = c.select(bit.equals(0), c.constant(0.0, REAL), 1.0)
                flag = c.call(FLAG, "px_set", m, reference, whole(c, kind), value)
                for wrong, reason in (
                    (1, "this variable cannot be set now: parameters and start values are set "
                        "before the end of initialization"),
                    (2, "there is no such variable"),
                    (3, "the value is not finite" + ", or no length" * self.crowded),
                ):  # fmt: skip
                    with c.when(flag.equals(wrong), leaves=True):
                        self.fail(c, m, f"{name}: {reason}")

    def vector(self, name: str, fill: Callable[[Code, Value, Value, Value], None]) -> None:
        """A function that gives a number for each state."""
        with self.entry(name, "ptr values, i64 count", EVALUABLE) as (c, (m, values, count)):
            with c.when(~count.equals(plan(c, Table.STATES)), leaves=True):
                self.fail(c, m, f"{name}: the model has another number of states")
            self.refresh(c, m, Stale.REST)
            with c.loop(count) as i:
                fill(c, m, values, i)

    def indicators(self, name: str) -> None:
        """The margin, where states are chosen, and what is seen of relations."""
        with self.entry(name, "ptr values, i64 count", EVALUABLE) as (c, (m, values, count)):
            with c.when(~count.equals(indicator_count(c)), leaves=True):
                self.fail(c, m, f"{name}: the model has another number of event indicators")
            self.refresh(c, m, Stale.REST)
            to = c.variable(0, INT)
            with c.when(plan(c, Table.OPEN) > 0):
                c.run("px_measure", m)
                values.store(m.load(REAL, Own.MARGIN))
                to.set(whole(c, 1))
            with c.when(~c.call(FLAG, "px_indicate", m).equals(0), leaves=True):
                self.fail(c, m, f"{name}: a relation has no value at this point", DISCARD)
            shown = numbers_of(c, m, Relation.SHOWN)
            with c.loop(plan(c, Table.RELATIONS)) as i, c.when(told(c, i, Row.TIMED).equals(0)):
                values.store(shown.load(REAL, i), to.get())
                to.set(to.get() + 1)

    def set_states(self, name: str) -> None:
        with self.entry(name, "ptr values, i64 count", (Phase.CONTINUOUS,)) as (
            c,
            (m, values, count),
        ):
            with c.when(~count.equals(plan(c, Table.STATES)), leaves=True):
                self.fail(c, m, f"{name}: the model has another number of states")
            y = m.load(POINTER, Own.Y)
            with c.loop(count) as i:
                y.store(values.load(REAL, i), i)
            m.store(whole(c, Stale.ALL), Own.STALE)

    def set_time(self, name: str) -> None:
        with self.entry(name, "double t", (Phase.EVENT, Phase.CONTINUOUS)) as (c, (m, t)):
            w, _, _, _ = open_frame(m)
            w.store(t)
            m.store(whole(c, Stale.ALL), Own.STALE)

    def save(self, name: str) -> None:
        with self.entry(name, "ptr to", ALWAYS) as (c, (m, to)):
            kept = to.load(POINTER)
            none = c.emit("i1", f"icmp eq ptr {kept.text}, null")
            with c.when(~none, leaves=True):
                c.run("px_copy", kept, m.at(Own.PHASE), _state_words(c))
                c.give(OK)
            to.store(c.call(POINTER, "px_save", m))

    def restore(self, name: str) -> None:
        with self.entry(name, "ptr saved", ALWAYS) as (c, (m, saved)):
            with c.when(is_null(c, saved), leaves=True):
                self.fail(c, m, f"{name}: there is no state")
            c.run("px_load", m, saved)

    def forget(self, name: str) -> None:
        with self.entry(name, "ptr to", ALWAYS) as (c, (_, to)):
            c.run("free", to.load(POINTER))
            to.store(Value(c, POINTER, "null"))

    def serialize(self, write: str, size: str, read: str) -> None:
        """The state as bytes, by the functions of these names, behind a seal of the model and a
        sum: nothing else is ever read as a state."""
        with self.entry(write, "ptr saved, ptr bytes, i64 size", ALWAYS) as (c, given):
            m, saved, place, room = given
            with c.when((room < _sealed_size(c)) | is_null(c, saved), leaves=True):
                self.fail(c, m, "there is too little room for the state, or there is none")
            place.store(constant(c, "px_seal").load(INT))
            place.store(_sum(c, saved), 1)
            c.run("px_copy", place.at(2), saved, _state_words(c))
        with self.entry(size, "ptr saved, ptr size", ALWAYS) as (c, (_, _, to)):
            to.store(_sealed_size(c))
        with self.entry(read, "ptr bytes, i64 size, ptr to", ALWAYS) as (c, given):
            m, place, room, to = given
            strange = "these bytes are no state of this model"
            with c.when(~room.equals(_sealed_size(c)), leaves=True):
                self.fail(c, m, strange)
            sealed = place.load(INT).equals(constant(c, "px_seal").load(INT))
            with c.when(~(sealed & place.load(INT, 1).equals(_sum(c, place.at(2)))), leaves=True):
                self.fail(c, m, strange)
            made = c.call(POINTER, "px_save", m)
            with c.when(~is_null(c, made)):
                c.run("px_copy", made, place.at(2), _state_words(c))
            to.store(made)

    def experiment(
        self,
        c: Code,
        m: Value,
        given: Value,
        tolerance: Value,
        start: Value,
        stops: Value,
        stop: Value,
    ) -> None:
        """Times and tolerance; a start at another time than at export is another start."""
        wanted = c.emit("i1", f"icmp ne {given.type} {given.text}, 0") & (tolerance > 0.0)
        with c.when(wanted & (tolerance < m.load(REAL, Own.TOLERANCE))):
            m.store(tolerance, Own.TOLERANCE)
        with c.when(c.emit("i1", f"icmp ne {stops.type} {stops.text}, 0")):
            m.store(stop, Own.STOP)
        w, _, _, _ = open_frame(m)
        with c.when(~w.load(REAL).equals(start)):
            w.store(start)
            m.store(whole(c, Stale.START), Own.STALE)

    def give_word(self, c: Code, to: Value, value: Value, place: int) -> None:
        """A number of 4 bytes in its place of a structure."""
        store_narrow(c, "i32", to, value, place)

    def started(self, c: Code, m: Value) -> None:
        """The end of the initialization."""
        self.refresh(c, m, Stale.NOTHING)
        self.check(c, m)
        m.store(m.load(INT, Own.BEGUN), Own.PHASE)

    def accept(self, c: Code, m: Value) -> Value:
        """A step was accepted; 1 where other states are to be taken."""
        from planarc.instance.block import hold

        self.record(c, m)
        self.refresh(c, m, Stale.NOTHING)
        self.mark(c, m)
        hold(c, m)
        self.check(c, m)
        c.run("px_passed", m, m.load(POINTER, Frame.W).load(REAL))
        bad = c.call(REAL, "px_look", m) > m.load(REAL, Own.BOUND)
        with c.when(bad):
            m.store(whole(c, 1), Own.WAITING)
        return m.load(INT, Own.WAITING)

    def update(self, c: Code, m: Value) -> tuple[Value, Value, Value, Value]:
        """An event: whether states are set anew, and whether others are taken; whether the run is
        terminated; the next instant."""
        changed = c.variable(0, INT)
        self.record(c, m)
        self.refresh(c, m, Stale.NOTHING)
        self.judge(c, m, c.call(FLAG, "px_update", m))
        self.refresh(c, m, Stale.NOTHING)
        self.check(c, m)
        bad = c.call(REAL, "px_look", m) > m.load(REAL, Own.BOUND)
        with c.when(bad | m.load(INT, Own.WAITING).equals(1)):
            flag = c.call(FLAG, "px_exchange", m)
            with c.when(flag > 0):
                changed.set(whole(c, 1))
                m.store(whole(c, Stale.ALL), Own.STALE)
        other = changed.get()
        anew = other
        for moved in (Own.RESET, Own.MOVED):
            anew = c.emit(INT, f"or i64 {anew.text}, {m.load(INT, moved).text}")
        return anew, other, m.load(INT, Own.OVER), c.call(REAL, "px_next", m)

    def record(self, c: Code, m: Value) -> None:
        """The way of a host since its last step becomes past."""
        if self._delayed:
            host = m.load(INT, Own.BEGUN).equals(Phase.EVENT)
            with c.when(host & ~m.load(INT, Own.STALE).equals(Stale.START)):
                self.judge(c, m, c.call(FLAG, "px_record", m))

    def mark(self, c: Code, m: Value) -> None:
        """The host's next step begins here."""
        if self._delayed:
            self.refresh(c, m, Stale.REST)
            c.run("px_mark", m)

    def judge(self, c: Code, m: Value, flag: Value) -> None:
        """What an event came to, told to the host where it ends the run."""
        self._ask(c, "px_judged", "ptr m, i32 flag", self._judged, m, flag)

    def _judged(self, c: Code, m: Value, came: Value) -> None:
        with c.when(came.equals(ACTED)):
            text = c.call(POINTER, "px_message", m, c.flag(m.load(INT, Own.ENDED)))
            over = m.load(INT, Own.OVER).equals(1)
            with c.when(over):
                c.run("px_log", m, c.constant(OK, FLAG), text)
            with c.when(~over, leaves=True):
                self.enter(c, m, Phase.FAILED)
                c.run("px_log", m, c.constant(ERROR, FLAG), text)
                c.give(ERROR)
        for wrong, reason in (
            (UNSOLVED, f"{_NOW}, behind an event, {_SUBJECT}"),
            (ENDLESS, f"the events {_NOW} do not come to rest"),
        ):
            with c.when(came.equals(wrong), leaves=True):
                self.enter(c, m, Phase.FAILED)
                self.fail(c, m, reason)
        c.give(OK)

    def step(self, c: Code, m: Value, t: Value, h: Value) -> None:
        """A step of co-simulation."""
        w, _, _, _ = open_frame(m)
        now = w.load(REAL)
        near = c.absolute(now - t) <= larger(c, c.absolute(t), c.constant(1.0, REAL)) * 1e-9
        with c.when(~near, leaves=True):
            self.fail(c, m, "the step does not begin where the last one ended")
        end = t + h
        with c.when(~((h > 0.0) & (end < 1e300)), leaves=True):
            self.fail(c, m, "the length of the step is not above zero")
        with c.when(end > m.load(REAL, Own.STOP) + c.absolute(end) * 1e-9, leaves=True):
            self.fail(c, m, "the step goes beyond the stop time")
        with c.when(m.load(INT, Own.OVER).equals(1), leaves=True):
            self.fail(c, m, "the run was terminated by the model")
        with c.when(m.load(INT, Own.CALLED).equals(1), leaves=True):
            self.fail(c, m, "an event is to be handled in event mode before the next step")
        flag = c.call(FLAG, "px_advance", m, end)
        self.judge(c, m, flag)
        with c.when(flag.equals(CROWDED), leaves=True):
            self.enter(c, m, Phase.FAILED)
            self.fail(c, m, f"events follow each other without end {_NOW}: the model chatters")
        with c.when((~flag.equals(0)) & (~flag.equals(ACTED)), leaves=True):
            self.fail(c, m, f"{_NOW} no step leads on: {_SUBJECT}, or the motion is too quick for "
                      "an explicit method", DISCARD)  # fmt: skip
        self.refresh(c, m, Stale.NOTHING)
        self.check(c, m)


def _pairs(arguments: str) -> list[tuple[str, str]]:
    """Types and names: "ptr m, i64 count"."""
    return [(t, n) for t, n in (a.split() for a in arguments.split(", ") if a)]


def _unless_well(c: Code, status: Value) -> None:
    """Give this status, unless all is well."""
    with c.when(~status.equals(OK), leaves=True):
        c.give(status)


def _may() -> str:
    """What every function asks first."""
    c = Code("px_may", FLAG, ((POINTER, "m"), (INT, "phases"), (POINTER, "message")))
    m, phases, message = c.arguments
    with c.when(is_null(c, m), leaves=True):
        c.give(ERROR)
    bit = c.emit(INT, f"lshr i64 {phases.text}, {m.load(INT, Own.PHASE).text}")
    with c.when(c.emit("i1", f"trunc i64 {bit.text} to i1"), leaves=True):
        c.give(OK)
    c.run("px_log", m, c.constant(ERROR, FLAG), message)
    c.give(ERROR)
    return c.text(SELDOM)


def _warn() -> str:
    """What the message of this number tells, as a warning."""
    c = Code("px_warn", "void", ((POINTER, "m"), (INT, "number")))
    m, number = c.arguments
    c.run("px_values", m, number)
    c.run("px_log", m, c.constant(WARNING, FLAG), c.call(POINTER, "px_message", m, c.flag(number)))
    c.give()
    return c.text(SELDOM)


def indicator_count(c: Code) -> Value:
    some = plan(c, Table.OPEN) > 0
    return c.emit(INT, f"zext i1 {some.text} to i64") + plan(c, Table.INDICATORS)


def _state_words(c: Code) -> Value:
    return plan(c, Table.WORDS) - int(Own.PHASE)


def _sealed_size(c: Code) -> Value:
    """Bytes of a serialized state."""
    return _state_words(c) * 8 + 16


def _sum(c: Code, words: Value) -> Value:
    """A number in which every bit of the state counts."""
    total = c.variable(0, INT)
    with c.loop(_state_words(c)) as i:
        total.set(total.get() * 31 + words.load(INT, i))
    return total.get()


def state(c: Code, m: Value, values: Value, i: Value) -> None:
    """A state, as `Entries.vector` wants it."""
    values.store(m.load(POINTER, Own.Y).load(REAL, i), i)


def rate(c: Code, m: Value, values: Value, i: Value) -> None:
    """Its derivative."""
    w, numbers, _, _ = open_frame(m)
    slots = numbers.at(plan(c, Table.STATES) + int(Number.FIRST_STATE))
    values.store(w.load(REAL, slots.load(INT, i)), i)


def nominal(c: Code, m: Value, values: Value, i: Value) -> None:
    """Its size."""
    values.store(nominal_of(c, m, i), i)


def give_flag(c: Code, place: Value, truth: Value | int, type: str = BYTE) -> None:
    """A truth value where the host wants it."""
    value = whole(c, truth) if isinstance(truth, int) else truth
    store_narrow(c, type, place, value)


def same_text(c: Code, a: Value, b: Value) -> Value:
    """Whether two texts are the same."""
    same, done, i = c.variable(1, INT), c.variable(0, INT), c.variable(0, INT)
    again, behind = c.label(), c.label()
    c.enter(again)
    one, two = load_narrow(c, BYTE, a, i.get()), load_narrow(c, BYTE, b, i.get())
    with c.when(~one.equals(two)):
        same.set(whole(c, 0))
        done.set(whole(c, 1))
    with c.when(one.equals(0)):
        done.set(whole(c, 1))
    i.set(i.get() + 1)
    c.branch(done.get().equals(0), again, behind)
    c.begin(behind)
    return same.get().equals(1)
