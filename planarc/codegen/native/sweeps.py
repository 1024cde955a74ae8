"""Projected Gauss-Seidel for the impulses of many contacts, in LLVM.

    pc_sweep(starts, columns, entries, rest, mu, inverse, x, count, most, tolerance) -> sweeps

A sparse matrix by rows, two for each of `count` contacts, its normal before its slip, whose
`inverse` diagonal is given; see `planarc.solve.stepping.impulses`, which does the same in Python.
Every other sweep goes backwards.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function


@function(
    "i32 pc_sweep(ptr starts, ptr columns, ptr entries, ptr rest, ptr mu, ptr inverse, ptr x, "
    "i64 count, i64 most, double tolerance)"
)
def sweep_function(
    c: Code,
    starts: Value,
    columns: Value,
    entries: Value,
    rest: Value,
    mu: Value,
    inverse: Value,
    x: Value,
    count: Value,
    most: Value,
    tolerance: Value,
) -> None:
    worst, changes = c.variable(0.0), c.label()

    def wanted(row: Value) -> Value:
        """The impulse that would stop the motion of a row."""
        total = c.variable(rest.load(REAL, row))
        with c.loop(starts.load(INT, row + 1), starts.load(INT, row)) as k:
            total.set(total.get() + entries.load(REAL, k) * x.load(REAL, columns.load(INT, k)))
        return x.load(REAL, row) - total.get() * inverse.load(REAL, row)

    def give(row: Value, value: Value) -> None:
        change = c.absolute(value - x.load(REAL, row))
        by = inverse.load(REAL, row)
        speed = c.select(by > 0.0, change / by, 0.0)
        worst.set(c.largest(worst.get(), speed))
        x.store(value, row)

    with c.loop(most) as sweep:
        worst.set(0.0)
        back = (sweep - sweep / 2 * 2).equals(1)
        with c.loop(count) as k:
            i = c.select(back, count - 1 - k, k)
            normal, slip = i * 2, i * 2 + 1
            pressed = wanted(normal)
            give(normal, c.select(pressed > 0.0, pressed, 0.0))
            limit = mu.load(REAL, i) * x.load(REAL, normal)
            rubs = wanted(slip)
            rubs = c.select(rubs > limit, limit, rubs)
            give(slip, c.select(rubs < 0 - limit, 0 - limit, rubs))
        c.leave(worst.get() <= tolerance, changes)
    c.give(c.flag(most))
    c.begin(changes)
    c.give(0)
