"""The march of CVODE in machine code, so that no step comes back to Python.

    pc_march(a) -> CVODE's last flag; `a` are the `Arguments` of `planarc.ir.march`

A call from Python into a compiled function costs 1 us, twice as much as a right-hand
side of a four-bar; a step with its accepted point, a row and a look at the choice of
states would need five of them. So this does what `solve.solvers.integrator.Integrator.march`
does, and ends when CVODE reports anything but an ordinary step, when the steps allowed
are used up, when the choice of states is to be looked at, when a zero function may have
gone through zero and back within the step, when a derivative may have gone across a pole, or
when the kernel could not solve its equations.
"""

from __future__ import annotations

import ctypes

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.ir.frame import Frame
from planarc.ir.march import (
    DIP_MARGIN,
    DIP_NOISE,
    DIP_POINTS,
    FIELDS,
    GROWTH,
    MISFIT,
    POINTS,
    REACH,
    ROUGH_MARGIN,
    ROUGH_NOISE,
    WARNING,
)
from planarc.ir.newton import GROWN

_KINDS = {ctypes.c_void_p: POINTER, ctypes.c_double: REAL, ctypes.c_int64: INT}
#: The task of `CVode` that comes back after every step.
_ONE_STEP = 2
#: Its flag where a zero function has crossed zero.
_ROOT = 2


class _Arguments:
    """The arguments by name, with the values that they have when they are asked for."""

    def __init__(self, a: Value) -> None:
        self._a = a

    def __getattr__(self, name: str) -> Value:
        place, kind = FIELDS[name]
        return self._a.load(_KINDS[kind], place)

    def set(self, name: str, value: Value | int) -> None:
        place, kind = FIELDS[name]
        self._a.store(self._a.code.constant(value, _KINDS[kind]), place)


@function("i32 pc_march(ptr a)")
def march_function(c: Code, a: Value) -> None:
    given = _Arguments(a)
    memory, y, time, context = given.memory, given.y, given.time, given.context
    again, made, failed, end = c.label(), c.label(), c.label(), c.label()
    flag = c.variable(c.flag(given.flag), FLAG)
    c.leave(given.flag >= 0, made)
    c.enter(again)
    one_step = c.constant(_ONE_STEP, FLAG)
    flag.set(given.cvode.call(FLAG, memory, given.limit, y, time, one_step))
    c.leave(flag.get() < 0, end)
    is_root = flag.get().equals(_ROOT)
    with c.when((given.relations > 0) & ~is_root):
        _note(c, given, time.load(REAL), end)
    with c.when(is_root):  # there may be others before it
        _note_angles(c, given, end)
    c.enter(made)
    t, before = time.load(REAL), given.count
    ordinary = flag.get().equals(0) | flag.get().equals(WARNING)
    _rows(c, given, c.select(ordinary, t, t - given.near), failed)
    with c.when(ordinary & given.count.equals(before)):
        # The point reached is accepted as it was evaluated last, when CVODE's corrector
        # converged: it lies within the tolerance, and blocks only start there.
        with c.when(~given.workspace.load(REAL).equals(t)):
            unsolved = c.call(FLAG, "pc_rhs", context, t, given.y_numbers, given.dense_numbers)
            c.leave(~unsolved.equals(0), failed)
        c.call(FLAG, "pc_accept", context, t)
    given.set("taken", given.taken + 1)
    c.leave(~ordinary, end)
    _turn(c, given, end)
    with c.when(given.block_count > 0):
        _look(c, given, t, end)
    c.branch(given.taken < given.steps, again, end)
    c.begin(failed)
    given.set("failed", 1)
    c.enter(end)
    c.give(flag.get())


def _note(c: Code, given: _Arguments, t: Value, end: str) -> None:
    """The zero functions at the end of a step, and what one may have done within it."""
    n, points = given.relations, given.points
    width = n + 1
    zeros = given.context.load(POINTER, Frame.ZEROS)
    with c.loop(width * (POINTS - 1)) as i:
        points.store(points.load(REAL, i + width), i)
    last, largest = points.at(width * (POINTS - 1)), points.at(width * POINTS + 1)
    last.store(t)
    with c.loop(n) as i:
        g = zeros.load(REAL, i)
        last.store(g, i + 1)
        largest.store(c.largest(c.absolute(g), largest.load(REAL, i)), i)
    given.set("seen", given.seen + 1)
    _note_angles(c, given, end)
    with c.when(given.seen >= DIP_POINTS):
        _find_rough(c, given, points, width, largest, end)
        _find_dips(c, given, points, width, largest, end)


def _note_angles(c: Code, given: _Arguments, end: str) -> None:
    """The angles at the end of a step; one that has turned far asks for looks along it."""
    farthest, turned, w = c.variable(0.0, REAL), given.turned, given.workspace
    slots, factors = given.turning, given.factors
    with c.loop(given.turning_count) as i:
        now = w.load(REAL, slots.load(INT, i)) * factors.load(REAL, i)
        farthest.set(c.largest(c.absolute(now - turned.load(REAL, i)), farthest.get()))
        turned.store(now, i)
    given.set("farthest", farthest.get())
    with c.when(farthest.get() > REACH, leaves=True):
        given.set("dips", 2)
        c.jump(end)


def _find_rough(
    c: Code, given: _Arguments, points: Value, width: Value, largest: Value, end: str
) -> None:
    """A zero function that a parabola through the points before, or a line, does not lead to."""
    t0, t1, t2, t3 = (points.load(REAL, width * k) for k in range(4))
    first, last, ahead, back = t1 - t0, t2 - t1, t3 - t2, t3 - t1
    with c.loop(given.relations) as i:
        p, q, r, z = (points.load(REAL, width * k + i + 1) for k in range(4))
        slope = (r - q) / last
        bend = (slope - (q - p) / first) / (t2 - t0)
        bend = c.select(given.seen >= POINTS, bend, slope * 0.0)
        off = c.absolute(z - (r + ahead * (slope + bend * back)))
        away = c.select(c.absolute(r) < c.absolute(z), c.absolute(r), c.absolute(z))
        found = (r * z > 0) & (away < off * ROUGH_MARGIN)
        found = found & (off > largest.load(REAL, i) * ROUGH_NOISE)
        with c.when(found, leaves=True):
            given.set("dips", 2)
            c.jump(end)


def _find_dips(
    c: Code, given: _Arguments, points: Value, width: Value, largest: Value, end: str
) -> None:
    """A parabola through the last three points that comes near zero between the last two."""
    t0, t1, t = (points.load(REAL, width * k) for k in range(POINTS - 3, POINTS))
    h = t - t1
    with c.loop(given.relations) as i:
        a, b, z = (points.load(REAL, width * k + i + 1) for k in range(POINTS - 3, POINTS))
        before, behind = (b - a) / (t1 - t0), (z - b) / h
        bend = (behind - before) / (t - t0)
        x = c.largest((h - behind / bend) / 2, 0.0)
        x = c.select(x < h, x, h)
        least = b + x * (behind + bend * (x - h))
        away = c.select(b > 0, least, -least)
        way = c.absolute(b - a) + c.absolute(z - b)
        found = (b * z > 0) & (b * bend > 0)
        found = found & (c.absolute(behind) < h * 2 * c.absolute(bend))
        found = found & (way > largest.load(REAL, i) * DIP_NOISE) & (away < way * DIP_MARGIN)
        with c.when(found, leaves=True):
            given.set("dips", 1)
            c.jump(end)


def _rows(c: Code, given: _Arguments, until: Value, failed: str) -> None:
    """Every row that is due."""
    done = c.label()
    with c.loop(given.grid_end, given.next) as i:
        due = given.grid.load(REAL, i)
        c.leave(due > until, done)
        given.interpolate.call(FLAG, given.memory, due, c.constant(0, FLAG), given.dense)
        unsolved = c.call(FLAG, "pc_outputs", given.context, due, given.dense_numbers)
        c.leave(~unsolved.equals(0), failed)
        count, columns = given.count, given.columns
        given.times.store(due, count)
        row = given.rows.at(count * columns)
        _gather(c, given.workspace, given.slots, columns, row)
        given.set("count", count + 1)
        c.call(FLAG, "pc_accept", given.context, due)
        given.set("next", i + 1)
    c.enter(done)


def _look(c: Code, given: _Arguments, t: Value, end: str) -> None:
    """Measure the choice of states, and keep this point as a refuge where it is good."""
    size = c.call(REAL, "pc_watch", given.context, given.blocks, given.block_count, given.scales)
    bound, least = given.bound, given.least
    with c.when(~(size <= bound), leaves=True):
        given.set("looks", 1)
        c.jump(end)
    lower = c.select(size <= least, least, size * GROWN)
    given.set("bound", c.select(lower < bound, lower, bound))
    _gather(c, given.workspace, given.kept_slots, given.kept_count, given.guess)
    state = given.state
    state.store(t)
    numbers = given.y_numbers
    with c.loop(given.states) as i:
        state.store(numbers.load(REAL, i), i + 1)
    given.kept_rows.store(given.count)
    given.kept_rows.store(given.next, 1)


def _turn(c: Code, given: _Arguments, end: str) -> None:
    """The workspace's point, of the step's end or its last row; back to Python where a pole may lie
    between the last one and this one."""
    n, trail, w, odd = given.states, given.trail, given.workspace, c.variable(0, INT)
    states, slopes, least, ways, absolute = (trail.at(n * k + 1) for k in range(5))
    t, places = w.load(REAL), given.places
    h = t - trail.load(REAL)
    with c.loop(n) as i:
        f0, f1 = slopes.load(REAL, i), w.load(REAL, places.load(INT, n + i))
        with c.when(f0 * f1 < 0):
            missed = w.load(REAL, places.load(INT, i)) - states.load(REAL, i) - h * (f0 + f1) * 0.5
            size = c.largest(c.absolute(f0), c.absolute(f1))
            moves = h * size * GROWTH > absolute.load(REAL, i)
            known = size > least.load(REAL, i)
            with c.when(known & moves & (c.absolute(missed) > h * size * MISFIT)):
                odd.set(c.constant(1, INT))
        way, limit = c.absolute(f1 * t), ways.load(REAL, i)
        with c.when(way > limit):
            y1 = w.load(REAL, places.load(INT, i))
            with c.when(way > limit * (c.absolute(y1) + 1.0)):
                odd.set(c.constant(1, INT))
    with c.when(odd.get().equals(1), leaves=True):
        given.set("poles", 1)
        c.jump(end)
    trail.store(t)
    _gather(c, w, places, n * 2, states)


def _gather(c: Code, source: Value, slots: Value, count: Value, target: Value) -> None:
    """target[i] = source[slots[i]]"""
    with c.loop(count) as i:
        target.store(source.load(REAL, slots.load(INT, i)), i)
