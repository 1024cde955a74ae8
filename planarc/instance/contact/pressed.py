"""Forces where joints rub, in LLVM: what presses on a joint follows from all forces.

    px_pressed(block, t, count, noise) -> flag    as `px_forces`, of the touches in `Area.LIST`

How limits and forces are brought to agree stands in `solve.contact.pressed`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.instance.block import larger
from planarc.instance.contact.access import arrays, slot, zero
from planarc.instance.contact.area import Area
from planarc.instance.contact.cases import copy, fill, largest_of
from planarc.instance.plan import Touch
from planarc.instance.relations import attempt
from planarc.solve.contact.pressed import AGREE, ROUNDS

#: What is left of a direction that others hold already, as a part of it.
_HELD = 1e-10


def pressed_functions() -> tuple[str, ...]:
    return _next(), _pressed()


def _dot(c: Code, a: Value, b: Value, n: Value) -> Value:
    total = c.variable(0.0)
    with c.loop(n) as i:
        total.set(total.get() + a.load(REAL, i) * b.load(REAL, i))
    return total.get()


def _take_off(c: Code, a: Value, b: Value, part: Value, n: Value) -> None:
    with c.loop(n) as i:
        a.store(a.load(REAL, i) - part * b.load(REAL, i), i)


@function("void px_promised(ptr m, i64 rows, i64 n)")
def _next(c: Code, m: Value, rows: Value, n: Value) -> None:
    """The limits that the last ones and their errors promise, behind the last row: the errors
    without what a combination of earlier changes takes off, by Gram and Schmidt's method."""
    limits, errors, steps, changes = arrays(m, Area.LIMITS, Area.ERRORS, Area.STEPS, Area.CHANGES)
    last = (rows - 1) * n
    to, error = steps.at(last), changes.at(last)
    copy(c, to, limits.at(last), n)
    copy(c, error, errors.at(last), n)
    with c.loop(rows - 1) as k:
        step, change = steps.at(k * n), changes.at(k * n)
        with c.loop(n) as i:
            step.store(limits.load(REAL, k * n + i) - limits.load(REAL, last + i), i)
            change.store(errors.load(REAL, k * n + i) - errors.load(REAL, last + i), i)
        before = _dot(c, change, change, n)
        with c.loop(k) as j:
            part = _dot(c, change, changes.at(j * n), n)
            _take_off(c, change, changes.at(j * n), part, n)
            _take_off(c, step, steps.at(j * n), part, n)
        size = _dot(c, change, change, n)
        own = size > before * (_HELD * _HELD)
        scale = c.select(own, 1.0 / c.call(REAL, "llvm.sqrt.f64", size), 0.0)
        with c.loop(n) as i:
            step.store(step.load(REAL, i) * scale, i)
            change.store(change.load(REAL, i) * scale, i)
        part = _dot(c, error, change, n)
        _take_off(c, to, step, part, n)
        _take_off(c, error, change, part, n)
    with c.loop(n) as i:
        to.store(larger(c, to.load(REAL, i) + error.load(REAL, i), 0.0), i)
    c.give()


@function("i32 px_pressed(ptr m, double t, i64 count, double noise)")
def _pressed(c: Code, m: Value, t: Value, count: Value, noise: Value) -> None:
    here, listed, joints, matrix, given, x, presses, limits, errors, steps = arrays(
        m, Area.HERE, Area.LIST, Area.JOINTS, Area.MATRIX, Area.GIVEN, Area.FORCES, Area.PRESSES,
        Area.LIMITS, Area.ERRORS, Area.STEPS,
    )  # fmt: skip
    some = c.variable(0, INT)
    with c.loop(count) as p:
        i = here.load(INT, listed.load(INT, p))
        with c.when(slot(c, i, Touch.JOINT).equals(1)):
            joints.store(p, some.get())
            some.set(some.get() + 1)
    n = some.get()
    with c.when(n.equals(0), leaves=True):
        c.give(c.call(FLAG, "px_forces", m, count, noise))
    rows, promised = c.variable(0, INT), c.variable(0, INT)
    fill(c, x, zero(c), count * 2)
    with c.loop(ROUNDS) as turn:
        attempt(c, "px_press", m, t, count)
        with c.when(rows.get() > n):  # the oldest one is forgotten
            copy(c, limits, limits.at(n), n * n)
            copy(c, errors, errors.at(n), n * n)
            rows.set(n)
        last = rows.get() * n
        with c.when(turn.equals(0)):
            fill(c, limits, zero(c), n)
        with c.when(turn > 0):
            copy(c, limits.at(last), steps.at(promised.get()), n)
        own, off = limits.at(last), errors.at(last)
        with c.loop(n) as r:
            off.store(presses.load(REAL, joints.load(INT, r)) - own.load(REAL, r), r)
        size = largest_of(c, off, n)
        with c.when(~(size < 1e300), leaves=True):
            c.give(1)
        agree = size <= largest_of(c, own, n) * AGREE
        with c.when(agree & (turn > 0), leaves=True):
            c.give(0)
        rows.set(rows.get() + 1)
        c.run("px_promised", m, rows.get(), n)
        promised.set((rows.get() - 1) * n)
        with c.loop(n) as r:
            limit, p = steps.load(REAL, promised.get() + r), joints.load(INT, r)
            given.store(zero(c) - matrix.load(REAL, p * (count * 2) + p) * limit, p)
        with c.when(~c.call(FLAG, "px_forces", m, count, noise).equals(0), leaves=True):
            c.give(1)
    c.give(1)
