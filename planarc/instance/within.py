"""Crossings within a step that neither its stages nor its end show, in LLVM.

    px_within(block, t, h)            what of a step that is accepted; `Own.NODE` is the first
    px_between_at(block, t, h, part, zeros) -> flag   zero functions at a part of the step
    px_looks(block, t, h, count, first) -> switches   so many looks; the first behind a crossing
    px_smooth(block) -> truth         whether the first looks lie on smooth curves
    px_steady(block) -> truth         whether stages do
    px_swings(block, t, h) -> part    the first look behind a crossing; `NONE`
    px_dips(block, t, h, ...) -> part  the same of functions that come near zero and turn back
    px_dip(block, t, h, i, ...) -> part   of one of them

Steps follow the states, and know nothing of how often a sine of them, or of the time, turns. What
may do so (`Row.SWINGS`) is looked at within every step: where the looks lie on smooth curves, that
is all; else there are twice as many looks again and again, until these find neither more switches
nor an earlier one. They lie by chance, so that no period hides between them. No look is needed at
sines of states whose stages lie on a parabola. What may have gone through zero and back, by the
parabola through three looks, or through two stages and the end, is looked at where that is lowest,
and where those through the points found are.

A model none of whose relations swings takes no looks, and holds none of this code.

Example: `sin(1000*x) > 0` with der(x) = 1; a step of 0.02 s goes across six switches.

Reference: `solve.solvers.waves`, `solve.solvers.dips`, `solve.events.scan`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod

from planarc.codegen.native.assembly import (
    FLAG,
    INT,
    REAL,
    Code,
    Value,
    Variable,
    function,
)
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import plan, whole
from planarc.instance.plan import LOOKS, Look, Own, Relation, Row, Swing, Table
from planarc.instance.relations import differs, looked, numbers_of, told, truth, word
from planarc.instance.steps import END, NODES, TRIAL, vector
from planarc.instance.steps import NOTED as EXPLICIT
from planarc.instance.stiff import NODES as STIFF_NODES
from planarc.instance.stiff import NOTED as STIFF
from planarc.ir.march import DIP_MARGIN, DIP_NOISE
from planarc.solve.solvers.waves import MOST, SMOOTH

#: Looks within a step at first: with both ends of it as many as are kept.
_FEWEST = LOOKS - 2
#: Where nothing has crossed.
NONE = 2.0
#: What makes chance of whole numbers: the fractional part of k^2 times it.
_CHANCE = 0.6180339887498949
#: Parabolas that are followed to their lowest points, and the part of a step that is no way.
_ROUNDS, _NEAR = 8, 1e-6
#: When the stages are whose zero functions are kept, of implicit and of explicit steps.
_STAGES = (*((STIFF_NODES[i], NODES[k]) for i, k in zip(STIFF, (2, 3), strict=True)), (1.0, 1.0))


def within_functions() -> tuple[str, ...]:
    return _between_at(), _looks(), _smooth(), _steady(), _swings(), _dips(), _dip(), _within()


@function("i32 px_between_at(ptr m, double t, double h, double part, ptr zeros)")
def _between_at(c: Code, m: Value, t: Value, h: Value, part: Value, zeros: Value) -> None:
    """By the states there, in whose place a trial stood; at the end exactly those of the trial."""
    moment, states = t + h * part, vector(c, m, TRIAL)
    c.run("px_between", m, moment, states)
    with c.when(part.equals(1.0)):
        c.run("px_copy", states, vector(c, m, END), plan(c, Table.STATES))
    c.give(c.call(FLAG, "pc_roots", m, moment, states, zeros))


@function("i64 px_looks(ptr m, double t, double h, i64 count, ptr first)", seldom=True)
def _looks(c: Code, m: Value, t: Value, h: Value, count: Value, first: Value) -> None:
    """Both ends of the step, and a look in each of so many parts between; -1 where one fails."""
    n, rows = plan(c, Table.RELATIONS), looked(c, m, Look.MANY)
    switches, flag = c.variable(0, INT), c.variable(c.constant(0, FLAG), FLAG)
    parts = c.place(REAL, 3)
    for place in range(3):
        parts.store(0.0, place)
    first.store(NONE)
    with c.loop(count + 2) as k:
        part = _part(c, k, count)
        early, before, row = (rows.at(n * (i - i / LOOKS * LOOKS)) for i in (k + 8, k + 9, k))
        for place in range(2):
            parts.store(parts.load(REAL, place + 1), place)
        parts.store(part, 2)
        alone = plan(c, Table.SWINGS).equals(Swing.TIME)
        with c.when(alone):
            flag.set(c.call(FLAG, "pc_zeros", m, t + h * part, row))
        with c.when(~alone):
            flag.set(c.call(FLAG, "px_between_at", m, t, h, part, row))
        with c.when(~flag.get().equals(0), leaves=True):
            first.store(NONE)
            c.give(-1, INT)
        with c.when(k > 0), c.loop(n) as i, c.when(~told(c, i, Row.SWINGS).equals(0)):
            a, b = before.load(REAL, i) > 0.0, row.load(REAL, i) > 0.0
            switches.set(switches.get() + word(c, differs(c, a, b)))
            gone = (_way(c, m, row, i) <= 0.0) & (part < first.load(REAL))
            first.store(c.select(gone, part, first.load(REAL)))
        with c.when((k > 1) & (parts.load(REAL) < first.load(REAL))):
            given = (parts.load(REAL), parts, early, before, row, whole(c, 1))
            dip = c.call(REAL, "px_dips", m, t, h, *given)
            first.store(c.select(dip < first.load(REAL), dip, first.load(REAL)))
    c.give(switches.get())


def _part(c: Code, k: Value, count: Value) -> Value:
    """When look `k` is: in a step of length 1, the first one at its begin, the last at its end."""
    place = c.real(k)
    square = place * place * _CHANCE
    inside = (place - 1.0 + (square - c.real(c.whole(square)))) / c.real(count)
    inside = c.select(k.equals(0), c.constant(0.0, REAL), inside)
    return c.select(k > count, c.constant(1.0, REAL), inside)


def _first_parts() -> list[float]:
    """Those of the first looks."""
    squares = [k * k * _CHANCE for k in range(1, _FEWEST + 1)]
    inside = [(k + (s - int(s))) / _FEWEST for k, s in enumerate(squares)]
    return [0.0, *inside, 1.0]


@function("i64 px_smooth(ptr m)", seldom=True)
def _smooth(c: Code, m: Value) -> None:
    """Each lies near the cubic polynomial through the two before it and the two behind it."""
    n, rows, parts = plan(c, Table.RELATIONS), looked(c, m, Look.MANY), _first_parts()
    through = {k: (k - 2, k - 1, k + 1, k + 2) for k in range(2, len(parts) - 2)}
    with c.loop(n) as i, c.when(~told(c, i, Row.SWINGS).equals(Swing.NOTHING)):
        values = [rows.load(REAL, n * k + i) for k in range(len(parts))]
        _give_where_rough(c, m, i, values, parts, through)
    c.give(1, INT)


@function("i64 px_steady(ptr m)")
def _steady(c: Code, m: Value) -> None:
    """So do stages of an explicit step near parabolas. Periods of time may fit them by chance."""
    with c.when(m.load(REAL, Own.STIFF) > 0.0, leaves=True):
        c.give(0, INT)
    parts = [*(NODES[k] for k in EXPLICIT), 1.0]
    arrays = [*(looked(c, m, k) for k in EXPLICIT.values()), numbers_of(c, m, Relation.TRIAL)]
    with c.loop(plan(c, Table.RELATIONS)) as i:
        with c.when(told(c, i, Row.SWINGS).equals(Swing.TIME), leaves=True):
            c.give(0, INT)
        with c.when(told(c, i, Row.SWINGS).equals(Swing.STATES)):
            values = [zeros.load(REAL, i) for zeros in arrays]
            _give_where_rough(c, m, i, values, parts, {1: (0, 2, 4), 3: (1, 2, 4)})
    c.give(1, INT)


def _give_where_rough(
    c: Code, m: Value, i: Value, values: Sequence[Value], parts: Sequence[float],
    through: Mapping[int, Sequence[int]],
) -> None:  # fmt: skip
    """The function gives 0 where points lie off the polynomials through others."""
    least = most = values[0]
    for value in values[1:]:
        least = c.select(value < least, value, least)
        most = c.select(value > most, value, most)
    noise = numbers_of(c, m, Relation.LARGEST).load(REAL, i) * DIP_NOISE
    room = (most - least) * SMOOTH + noise
    for k, others in through.items():
        off = values[k]
        for j in others:
            off = off - values[j] * _weight(parts, k, j, others)
        with c.when(~(c.absolute(off) <= room), leaves=True):
            c.give(0, INT)


def _weight(parts: Sequence[float], k: int, j: int, others: Sequence[int]) -> float:
    """Of point `j` in the value at `k` of the polynomial through `others`."""
    return prod((parts[k] - parts[i]) / (parts[j] - parts[i]) for i in others if i != j)


@function("double px_swings(ptr m, double t, double h)", seldom=True)
def _swings(c: Code, m: Value, t: Value, h: Value) -> None:
    first, last = c.place(REAL), c.variable(NONE)
    count, before = c.variable(_FEWEST, INT), c.variable(-1, INT)
    again, behind = c.label(), c.label()
    c.enter(again)
    now = c.call(INT, "px_looks", m, t, h, count.get(), first)
    apart = c.absolute(first.load(REAL) - last.get()) * c.real(count.get())
    known = now.equals(before.get()) & (apart <= 2.0)
    c.leave((now < 0) | known | (count.get() >= MOST), behind)
    with c.when(count.get().equals(_FEWEST)):
        c.leave(c.call(INT, "px_smooth", m).equals(1), behind)
    before.set(now)
    last.set(first.load(REAL))
    count.set(count.get() * 2)
    c.jump(again)
    c.begin(behind)
    c.give(first.load(REAL), REAL)


def _lowest(*points: tuple[Value, Value]) -> tuple[Value, Value, Value]:
    """Where the parabola through three points has no slope; its bend, and the slope from the second
    point to the third."""
    (x0, a), (x1, b), (x2, z) = points
    before, behind = (b - a) / (x1 - x0), (z - b) / (x2 - x1)
    bend = (behind - before) / (x2 - x0)
    return (x1 + x2 - behind / bend) * 0.5, bend, behind


def _way(c: Code, m: Value, zeros: Value, i: Value) -> Value:
    """From a zero function to where relation `i` crosses."""
    g, width = zeros.load(REAL, i), numbers_of(c, m, Relation.WIDTH).load(REAL, i)
    return c.select(truth(c, m, i), -g, g) + width


@function(
    "double px_dips(ptr m, double t, double h, double left, ptr parts, "
    "ptr one, ptr two, ptr three, i64 swings)"
)
def _dips(
    c: Code, m: Value, t: Value, h: Value, left: Value, parts: Value,
    one: Value, two: Value, three: Value, swings: Value,
) -> None:  # fmt: skip
    """Between a part of the step and the last one of three, where zero functions are known."""
    largest, found = numbers_of(c, m, Relation.LARGEST), c.variable(NONE)
    x0, x1, x2 = (parts.load(REAL, k) for k in range(3))
    with c.loop(plan(c, Table.RELATIONS)) as i:
        a, b, z = (_way(c, m, zeros, i) for zeros in (one, two, three))
        x, bend, behind = _lowest((x0, a), (x1, b), (x2, z))
        least = b + (x - x1) * (behind + bend * (x - x2))
        moved = c.absolute(b - a) + c.absolute(z - b)
        suspect = (bend > 0.0) & (x > left) & (x < x2) & (least < moved * DIP_MARGIN)
        suspect = suspect & (b > 0.0) & (z > 0.0) & (moved > largest.load(REAL, i) * DIP_NOISE)
        swinging = c.select(told(c, i, Row.SWINGS) > 0, whole(c, 1), whole(c, 0))
        suspect = suspect & told(c, i, Row.TIMED).equals(0) & swinging.equals(swings)
        with c.when(suspect):
            part = c.call(REAL, "px_dip", m, t, h, i, left, x, x2)
            found.set(c.select(part < found.get(), part, found.get()))
    c.give(found.get(), REAL)


@function(
    "double px_dip(ptr m, double t, double h, i64 i, double begin, double part, double end)",
    seldom=True,
)
def _dip(
    c: Code, m: Value, t: Value, h: Value, i: Value, begin: Value, part: Value, end: Value
) -> None:
    """Down the parabolas of one function; each has its lowest point within the one before."""
    zeros = looked(c, m, Look.HERE)
    x, left, right = c.variable(part), c.variable(begin), c.variable(end)
    a, z = c.variable(0.0), c.variable(0.0)

    def look(where: Value) -> None:
        flag = c.call(FLAG, "px_between_at", m, t, h, where, zeros)
        with c.when(~flag.equals(0), leaves=True):
            c.give(NONE, REAL)

    for where, way in ((left, a), (right, z)):
        look(where.get())
        way.set(_way(c, m, zeros, i))
    behind = c.label()
    with c.loop(_ROUNDS):
        look(x.get())
        with c.when(c.call(REAL, "px_crossed", m, zeros) <= 0.0, leaves=True):
            c.give(x.get(), REAL)
        middle, b = x.get(), _way(c, m, zeros, i)
        lowest, _, _ = _lowest((left.get(), a.get()), (middle, b), (right.get(), z.get()))
        before = lowest < middle
        left.set(c.select(before, left.get(), middle))
        a.set(c.select(before, a.get(), b))
        right.set(c.select(before, middle, right.get()))
        z.set(c.select(before, b, z.get()))
        inside = (lowest > left.get()) & (lowest < right.get())
        c.leave(~(inside & (c.absolute(lowest - middle) > _NEAR)), behind)
        x.set(lowest)
    c.enter(behind)
    c.give(NONE, REAL)


def _sooner(c: Code, node: Variable, part: Value) -> None:
    node.set(c.select(part < node.get(), part, node.get()))


def _dips_of_stages(c: Code, m: Value, t: Value, h: Value, swings: int) -> Value:
    stiff, parts = m.load(REAL, Own.STIFF) > 0.0, c.place(REAL, 3)
    for k, (late, early) in enumerate(_STAGES):
        parts.store(c.select(stiff, c.constant(late, REAL), early), k)
    stages = (looked(c, m, k) for k in (Look.EARLIER, Look.LATER))
    zeros = (*stages, numbers_of(c, m, Relation.TRIAL))
    begin = c.constant(0.0, REAL)
    return c.call(REAL, "px_dips", m, t, h, begin, parts, *zeros, whole(c, swings))


@function("void px_within(ptr m, double t, double h)")
def _within(c: Code, m: Value, t: Value, h: Value) -> None:
    w, _, _, _ = open_frame(m)
    c.run("px_copy", vector(c, m, END), vector(c, m, TRIAL), plan(c, Table.STATES))
    m.store(t + h, Own.REACH)
    m.store(h, Own.SPAN)
    node = c.variable(m.load(REAL, Own.NODE))
    steady = c.call(INT, "px_steady", m).equals(1)
    with c.when(~steady):
        _sooner(c, node, c.call(REAL, "px_swings", m, t, h))
    with c.when(steady & (node.get() > 1.0)):
        _sooner(c, node, _dips_of_stages(c, m, t, h, 1))
    with c.when(node.get() > 1.0):
        _sooner(c, node, _dips_of_stages(c, m, t, h, 0))
    m.store(node.get(), Own.NODE)
    with c.when((node.get() > 1.0) & ~w.load(REAL).equals(t + h)):  # back from where it was looked
        zeros = looked(c, m, Look.HERE)
        c.call(FLAG, "px_between_at", m, t, h, c.constant(1.0, REAL), zeros)
    c.give()
