"""An instance: made, evaluated, read and set.

    px_new(logger, host, logging, resources) -> block   from the image, in the first phase
    px_unpack(block)                             the model's whole numbers (`codegen.native.packed`)
    px_save(block) -> copy                       the state, in memory of its own
    px_load(block, copy)
    px_reset(block)                              its state as it was exported
    px_refresh(block, least) -> flag             evaluate what is stale, down to `least`
    px_place(block, reference, kind) -> pointer  of a value, null where there is none
    px_set(block, reference, kind, value) -> flag

A value's *reference* is made of its slot in the workspace: 8*slot + 2*kind + sign; slots
behind the workspace are the states as they are chosen, their derivatives, the margin, and what is
seen of relations. What a reference has from `OTHER` on makes other references of the same value.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.codegen.native.packed import CHUNK
from planarc.instance.plan import (
    FIRST_GIVEN,
    INPUT,
    PARAMETER,
    TUNABLE,
    Own,
    Phase,
    Relation,
    Stale,
    Table,
    Told,
)
from planarc.ir.frame import Frame, Number

BYTE, WORD = "i8", "i32"
LARGER = "px_larger"
#: More than 8 times as many slots as any model has.
OTHER = 1 << 24


def block_functions(delayed: bool, apart: bool, crowded: bool) -> tuple[str, ...]:
    """The texts of all of them. `delayed`: the model has a past; `apart`: its numbers stand in a
    file (`stored`); `crowded`: it has a crowd."""
    return (_larger(), _copy(), _unpack(apart), _new(apart), _reset(delayed, apart), _save(),
            _load(delayed), _refresh(), _place(), _set(apart, crowded))  # fmt: skip


def copy_functions() -> tuple[str, ...]:
    """Those that know of no instance."""
    return _larger(), _copy()


def constant(c: Code, name: str) -> Value:
    return Value(c, POINTER, f"@{name}")


def image(c: Code, m: Value, apart: bool) -> Value:
    """The first content of an instance, from `Own.PHASE` on."""
    return m.load(POINTER, Own.STORED).at(1) if apart else constant(c, "px_image")


def plan(c: Code, which: Table) -> Value:
    """A number of the model."""
    return constant(c, "px_plan").load(INT, which)


def whole(c: Code, value: int) -> Value:
    return c.constant(value, INT)


def load_narrow(c: Code, type: str, array: Value, index: Value) -> Value:
    """A number of 1 or 4 bytes as one of 8; without a sign."""
    at = c.emit(POINTER, f"getelementptr {type}, ptr {array.text}, i64 {index.text}")
    return c.emit(INT, f"zext {type} {c.emit(type, f'load {type}, ptr {at.text}').text} to i64")


def load_signed(c: Code, array: Value, index: Value) -> Value:
    """A number of 4 bytes with its sign."""
    at = c.emit(POINTER, f"getelementptr i32, ptr {array.text}, i64 {index.text}")
    return c.emit(INT, f"sext i32 {c.emit(WORD, f'load i32, ptr {at.text}').text} to i64")


def store_narrow(c: Code, type: str, array: Value, value: Value, index: Value | int = 0) -> None:
    """The low bytes of a whole number."""
    i = index if isinstance(index, int) else index.text
    at = c.emit(POINTER, f"getelementptr {type}, ptr {array.text}, i64 {i}")
    low = c.emit(type, f"trunc i64 {value.text} to {type}")
    c.line(f"store {type} {low.text}, ptr {at.text}")


def own(reference: Value) -> Value:
    """A reference without what makes it another one."""
    return reference - reference / OTHER * OTHER


def larger(c: Code, a: Value, b: Value | float) -> Value:
    """The larger one; not a number when one is none. A function, since some processors need ten
    instructions for it."""
    return c.call(REAL, LARGER, a, c.constant(b, REAL))


def is_null(c: Code, pointer: Value) -> Value:
    return c.emit("i1", f"icmp eq ptr {pointer.text}, null")


@function(f"double {LARGER}(double a, double b)")
def _larger(c: Code, a: Value, b: Value) -> None:
    with c.when((a > b) | a.is_nan(), leaves=True):
        c.give(a)
    c.give(b)


@function("void px_copy(ptr to, ptr from, i64 count)")
def _copy(c: Code, to: Value, source: Value, count: Value) -> None:
    """Sixteen words at a time, and the rest."""
    wide = "<16 x i64>"
    groups = count / 16
    with c.loop(groups) as group:
        found = c.emit(wide, f"load {wide}, ptr {source.at(group * 16).text}, align 8")
        c.line(f"store {wide} {found.text}, ptr {to.at(group * 16).text}, align 8")
    with c.loop(count, groups * 16) as i:
        to.store(source.load(INT, i), i)
    c.give()


@function("void px_unpack(ptr m)")
def _unpack(c: Code, m: Value, apart: bool) -> None:
    """Each is one before it and a step, whose lowest bit is set where it leads down."""
    numbers, count = m.load(POINTER, Own.NODES), plan(c, Table.PACKED)
    packed = m.load(POINTER, Own.PACKED) if apart else constant(c, "px_packed")
    at, back, step = (c.variable(0, INT) for _ in range(3))
    with c.loop(count + (count + (CHUNK - 1)) / CHUNK) as i:
        step.set(whole(c, 0))
        again, behind = c.label(), c.label()
        c.enter(again)
        place = at.get()
        word = packed.load(INT, place / 8)
        turned = c.emit(INT, f"lshr i64 {word.text}, {((place - place / 8 * 8) * 8).text}")
        byte = c.emit(INT, f"and i64 {turned.text}, 255")
        at.set(place + 1)
        ends = byte < 128
        low = c.emit(INT, f"and i64 {byte.text}, 127")
        step.set(step.get() * 128 + low)
        c.branch(ends, behind, again)
        c.begin(behind)
        chunk = i / (CHUNK + 1)
        begins = i.equals(chunk * (CHUNK + 1))
        with c.when(begins):
            back.set(step.get())
        with c.when(~begins):
            place = i - chunk - 1
            half = c.emit(INT, f"lshr i64 {step.get().text}, 1")
            down = whole(c, 0) - c.emit(INT, f"and i64 {step.get().text}, 1")
            by = c.emit(INT, f"xor i64 {half.text}, {down.text}")
            # Nothing stands there yet, where nothing stands before.
            before = c.select(place < back.get(), place, place - back.get())
            numbers.store(numbers.load(INT, before) + by, place)
    c.give()


@function("ptr px_new(ptr logger, ptr host, i64 logging, ptr resources)")
def _new(
    c: Code, logger: Value, host: Value, logging: Value, resources: Value, apart: bool
) -> None:
    block = c.call(POINTER, "calloc", plan(c, Table.ROOM), whole(c, 8))
    with c.when(is_null(c, block), leaves=True):
        c.give(block)
    homes = constant(c, "px_plan").at(Table.POINTERS)
    _point(c, block, homes.at(1), homes.load(INT))
    block.store(host, Own.HOST)
    block.store(logger, Own.LOGGER)
    block.store(logging, Own.LOGGING)
    if apart:
        failed = ~c.call(FLAG, "px_bring", block, resources).equals(0)
        with c.when(failed, leaves=True):
            c.run("px_log", block, c.constant(3, FLAG), constant(c, "px_unread"))
            c.run("free", block)
            c.give(Value(c, POINTER, "null"))
        end = block.load(POINTER, Own.STORED).at(plan(c, Table.STORED))
        count = end.load(INT, -1)
        _point(c, block, end.at(-1 - count * 2), count)
    c.run("px_reset", block)
    c.run("px_unpack", block)
    c.give(block)


def _point(c: Code, block: Value, homes: Value, count: Value) -> None:
    """Pointers of the block into itself."""
    with c.loop(count) as i:
        block.store(block.at(homes.load(INT, i * 2 + 1)), homes.load(INT, i * 2))


@function("void px_reset(ptr m)")
def _reset(c: Code, m: Value, delayed: bool, apart: bool) -> None:
    words = constant(c, "px_past").load(INT, Told.IMAGE) if delayed else plan(c, Table.WORDS)
    c.run("px_copy", m.at(Own.PHASE), image(c, m, apart), words - Own.PHASE)
    c.give()


@function("ptr px_save(ptr m)")
def _save(c: Code, m: Value) -> None:
    count = plan(c, Table.WORDS) - Own.PHASE
    found = c.call(POINTER, "calloc", count, whole(c, 8))
    with c.when(~is_null(c, found)):
        c.run("px_copy", found, m.at(Own.PHASE), count)
    c.give(found)


@function("void px_load(ptr m, ptr saved)")
def _load(c: Code, m: Value, saved: Value, delayed: bool) -> None:
    c.run("px_copy", m.at(Own.PHASE), saved, plan(c, Table.WORDS) - Own.PHASE)
    if delayed:
        c.run("px_link", m)
    c.give()


@function("i32 px_refresh(ptr m, i64 least)")
def _refresh(c: Code, m: Value, least: Value) -> None:
    """With `least` = Stale.REST derivatives are enough."""
    with c.when(m.load(INT, Own.STALE).equals(Stale.START)):
        flag = c.call(FLAG, "px_start", m)
        with c.when(~flag.equals(0), leaves=True):
            m.store(whole(c, Stale.START), Own.STALE)
            c.give(flag)
    w, _, _, _ = open_frame(m)
    t = w.load(REAL)
    with c.when(m.load(INT, Own.STALE).equals(Stale.ALL)):
        flag = c.call(FLAG, "px_derive", m)
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
        m.store(whole(c, Stale.REST), Own.STALE)
    with c.when(m.load(INT, Own.STALE).equals(Stale.REST) & least.equals(Stale.NOTHING)):
        flag = c.call(FLAG, "pc_rest", m, t)
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
        c.run("px_measure", m)
        flag = c.call(FLAG, "px_indicate", m)
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
        m.store(whole(c, Stale.NOTHING), Own.STALE)
    c.give(0)


@function("ptr px_place(ptr m, i64 reference, i64 kind)")
def _place(c: Code, m: Value, given: Value, kind: Value) -> None:
    reference = own(given)
    slot = reference / 8
    states = plan(c, Table.STATES)
    behind = slot - plan(c, Table.SIZE)
    wrong = ~((reference - slot * 8) / 2).equals(kind)
    wrong = wrong | (behind > states * 2 + plan(c, Table.RELATIONS) + 1)
    with c.when(wrong, leaves=True):
        c.give(Value(c, POINTER, "null"))
    w, numbers, _, _ = open_frame(m)
    with c.when(behind.equals(states * 2 + plan(c, Table.RELATIONS) + 1), leaves=True):
        c.give(m.at(int(Own.STIFF)))
    with c.when(behind > states * 2, leaves=True):
        relations = m.load(POINTER, Own.RELATIONS)
        shown = plan(c, Table.RELATIONS) * int(Relation.SHOWN)
        c.give(relations.at(shown + behind - states * 2 - 1))
    with c.when(behind.equals(states * 2), leaves=True):
        c.give(w.at(plan(c, Table.MARGIN)))
    with c.when(behind >= 0, leaves=True):
        c.give(w.at(numbers.at(Number.FIRST_STATE).load(INT, behind)))
    c.give(w.at(slot))


@function("i32 px_set(ptr m, i64 reference, i64 kind, double value)")
def _set(
    c: Code, m: Value, reference: Value, kind: Value, value: Value, apart: bool, crowded: bool
) -> None:  # fmt: skip
    """1 where such a value cannot be set now, 2 where there is none, 3 where it is no number, or no
    length. A start goes by all names of its value. Some hosts set everything, each name to what is
    described of it: the start at export is then no news to one that was given by another name."""
    place = c.call(POINTER, "px_place", m, reference, kind)
    slot = own(reference) / 8
    behind = slot - plan(c, Table.SIZE) - plan(c, Table.STATES) * 2
    chooses = behind.equals(plan(c, Table.RELATIONS) + 1)
    chosen = ~is_null(c, place) & chooses
    if crowded:
        with c.when(chosen & ~((value > 0.0) & (value < 1e300)), leaves=True):
            c.give(3)
    with c.when(chosen, leaves=True):
        early = m.load(INT, Own.PHASE) < Phase.EVENT
        with c.when(early):
            place.store(value)
        c.give(c.select(early, c.constant(0, FLAG), c.constant(1, FLAG)))
    with c.when(is_null(c, place) | (slot >= plan(c, Table.SIZE)), leaves=True):
        c.give(2)
    with c.when(~((value - value).equals(0.0)), leaves=True):
        c.give(3)
    rule = m.load(POINTER, Own.RULES).load(INT, slot)
    negative = (own(reference) - slot * 8 - kind * 2).equals(1)
    wanted = c.select(negative, c.constant(0.0, REAL) - value, value)
    with c.when(rule.equals(INPUT), leaves=True):
        place.store(wanted)
        stale = m.load(INT, Own.STALE)
        now = c.emit(INT, f"select i1 {(stale < Stale.ALL).text}, i64 2, i64 {stale.text}")
        m.store(now, Own.STALE)
        m.store(whole(c, 0), Own.EXACT)
        m.store(whole(c, 1), Own.TOUCHED)
        c.give(0)
    phase = m.load(INT, Own.PHASE)
    begun = phase.equals(Phase.EVENT) | phase.equals(Phase.STEP) | phase.equals(Phase.PAUSE)
    with c.when(rule.equals(TUNABLE) & begun, leaves=True):
        place.store(wanted)
        m.store(whole(c, Stale.ALL), Own.STALE)
        m.store(whole(c, 0), Own.EXACT)
        m.store(whole(c, 1), Own.TOUCHED)
        c.give(c.call(FLAG, "pc_parameters", m, m.load(POINTER, Frame.W).load(REAL)))
    with c.when((rule < PARAMETER) | (m.load(INT, Own.PHASE) > Phase.INITIALIZATION), leaves=True):
        c.give(1)
    with c.when(rule < INPUT):
        place.store(wanted)
    with c.when(rule >= FIRST_GIVEN):
        given = m.load(POINTER, Own.GIVEN)
        by, known = reference + 1, given.load(INT, rule - FIRST_GIVEN)
        exported = image(c, m, apart).at(plan(c, Table.WORKSPACE)).load(REAL, slot)
        with c.when(~(known.equals(0) | known.equals(by)) & wanted.equals(exported), leaves=True):
            c.give(0)
        m.load(POINTER, Own.STARTS).store(wanted, rule - FIRST_GIVEN)
        given.store(by, rule - FIRST_GIVEN)
        place.store(wanted)
    m.store(whole(c, Stale.START), Own.STALE)
    c.give(0)


def hold(c: Code, m: Value) -> None:
    """The present point becomes the one that nonlinear blocks start from (`reaching`)."""
    c.run("px_hold", m)


def nominal_of(c: Code, m: Value, i: Value) -> Value:
    """The size of a state: that of its candidate, which the model says, or 1."""
    w, numbers, _, _ = open_frame(m)
    slot = numbers.at(Number.FIRST_STATE).load(INT, i)
    table = constant(c, "px_nominals")
    found = c.variable(1.0)
    with c.loop(plan(c, Table.NOMINALS)) as k, c.when(table.load(INT, k * 2).equals(slot)):
        value = c.absolute(w.load(REAL, table.load(INT, k * 2 + 1)))
        found.set(c.select(value > 0.0, value, 1.0))
    return found.get()
