"""The distance of the present states from a place where they can be none, in LLVM.

    pc_look(frame, blocks, count, scales) -> the largest sensitivity, or infinity

of what is determined to a state, of `count` blocks whose records begin at `blocks`; the
rule is `solve.states.selector`, which says the same in Python. The constraint Jacobians are those
that the last evaluation left behind, so that a look costs less than an evaluation and
every accepted step can be looked at. `scales` holds the largest columns seen so far.
"""

from __future__ import annotations

import math

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value, Variable, function
from planarc.codegen.native.newton import Block
from planarc.ir.newton import NEGLIGIBLE


@function("double pc_look(ptr frame, ptr blocks, i64 count, ptr scales)")
def look_function(c: Code, frame: Value, blocks: Value, count: Value, scales: Value) -> None:
    table = Value(c, POINTER, "@pc_blocks")
    worst, first = c.variable(0.0), c.variable(0, INT)
    with c.loop(count) as k:
        b = Block(frame, table.at(blocks.load(INT, k)))
        scale = scales.at(first.get())
        _arrange(c, b, scale, _measure(c, b, scale))
        _reduce(c, b, worst)
        first.set(first.get() + b.n)
    c.give(c.select(worst.get() < 1e300, worst.get(), math.inf), REAL)


def _measure(c: Code, b: Block, scale: Value) -> Value:
    """The sizes of the columns; a column smaller than what is given back is none."""
    most = c.variable(0.0)
    with c.loop(b.n) as j:
        total = c.variable(0.0)
        with c.loop(b.m) as i:
            entry = b.jacobian.load(REAL, i * b.n + j)
            total.set(total.get() + entry * entry)
        size = c.largest(c.call(REAL, "llvm.sqrt.f64", total.get()), scale.load(REAL, j))
        scale.store(size, j)
        most.set(c.largest(size, most.get()))
    return most.get() * NEGLIGIBLE


def _arrange(c: Code, b: Block, scale: Value, least: Value) -> None:
    """The scaled columns into the matrix, those that are determined first."""
    done = c.variable(0, INT)
    with c.loop(b.n) as j:
        k = done.get()
        last = b.m - 1
        solved = b.solved.load(INT, c.select(k < b.m, k, last)).equals(j) & (k < b.m)
        column = c.select(solved, k, b.m + j - k)
        size = scale.load(REAL, j)
        part = c.select(size > least, c.constant(1.0, REAL) / size, 0.0)
        with c.loop(b.m) as i:
            b.matrix.store(b.jacobian.load(REAL, i * b.n + j) * part, i * b.n + column)
        with c.when(solved):
            done.set(k + 1)


def _reduce(c: Code, b: Block, worst: Variable) -> None:
    """Gauss and Jordan's elimination; what stands behind the unit matrix is looked at."""
    a, m, n = b.matrix, b.m, b.n
    with c.loop(m) as k:
        row, most = c.variable(k, INT), c.variable(0.0)
        with c.loop(m, k) as i:
            pivot = c.absolute(a.load(REAL, i * n + k))
            with c.when(pivot > most.get()):
                row.set(i)
                most.set(pivot)
        with c.when(most.get().equals(0.0), leaves=True):
            c.give(c.constant(math.inf, REAL))
        p, own = a.at(row.get() * n), a.at(k * n)
        with c.when(~row.get().equals(k)), c.loop(n, k) as j:
            one, two = p.load(REAL, j), own.load(REAL, j)
            p.store(two, j)
            own.store(one, j)
        inverse, rest = c.constant(1.0, REAL) / own.load(REAL, k), n - k - 1
        with c.loop(m) as i, c.when(~i.equals(k)):
            factor = a.load(REAL, i * n + k) * inverse
            with c.when(~factor.equals(0.0)):
                c.subtract(a.at(i * n + k + 1), own.at(k + 1), factor, rest)
    with c.loop(m) as k, c.loop(n, m) as j:
        entry = c.absolute(a.load(REAL, k * n + j) / a.load(REAL, k * n + k))
        worst.set(c.largest(entry, worst.get()))
