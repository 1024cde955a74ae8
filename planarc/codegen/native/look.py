"""The distance of the present states from a place where they can be none, in LLVM.

    pc_look(frame, blocks, count, scales) -> the largest sensitivity, or infinity
    pc_watch(frame, blocks, count, scales)   the same, but for what it leaves in the block's matrix

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


def look_functions() -> tuple[str, ...]:
    return _look(), _watch()


@function("double pc_look(ptr frame, ptr blocks, i64 count, ptr scales)")
def _look(c: Code, frame: Value, blocks: Value, count: Value, scales: Value) -> None:
    worst, first = c.variable(0.0), c.variable(0, INT)
    with c.loop(count) as k:
        b = _block(frame, blocks, k)
        scale = scales.at(first.get())
        _arrange(c, b, scale, _measure(c, b, scale))
        _reduce(c, b, worst)
        first.set(first.get() + b.n)
    c.give(c.select(worst.get() < 1e300, worst.get(), math.inf), REAL)


@function("double pc_watch(ptr frame, ptr blocks, i64 count, ptr scales)")
def _watch(c: Code, frame: Value, blocks: Value, count: Value, scales: Value) -> None:
    worst, first = c.variable(0.0), c.variable(0, INT)
    with c.loop(count) as k:
        b = _block(frame, blocks, k)
        scale = scales.at(first.get())
        pair = b.m.equals(2)
        with c.when(pair):
            _reduce_pair(c, b, scale, worst)
        with c.when(~pair):
            size = c.call(REAL, "pc_look", frame, blocks.at(k), c.constant(1, INT), scale)
            worst.set(c.largest(size, worst.get()))
        first.set(first.get() + b.n)
    c.give(c.select(worst.get() < 1e300, worst.get(), math.inf), REAL)


def _block(frame: Value, blocks: Value, k: Value) -> Block:
    table = Value(frame.code, POINTER, "@pc_blocks")
    return Block(frame, table.at(blocks.load(INT, k)))


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


def _reduce_pair(c: Code, b: Block, scale: Value, worst: Variable) -> None:
    """All of it for two rows, the most frequent number, by determinants: a look is taken at every
    step, and this way costs a third."""
    one, two, most = b.jacobian, b.jacobian.at(b.n), c.variable(0.0)
    with c.loop(b.n) as j:
        p, q, known = one.load(REAL, j), two.load(REAL, j), scale.load(REAL, j)
        square, grown = p * p + q * q, c.variable(known)
        with c.when(~(square <= known * known)):  # columns seldom grow
            grown.set(c.call(REAL, "llvm.sqrt.f64", square))
            scale.store(grown.get(), j)
        most.set(c.largest(grown.get(), most.get()))
    least = most.get() * NEGLIGIBLE
    i, k = (b.solved.load(INT, place) for place in (0, 1))
    first, second = scale.load(REAL, i), scale.load(REAL, k)
    determinant = one.load(REAL, i) * two.load(REAL, k) - one.load(REAL, k) * two.load(REAL, i)
    singular = determinant.equals(0.0) | ~((first > least) & (second > least))
    with c.when(singular, leaves=True):
        c.give(c.constant(math.inf, REAL))
    with c.loop(b.n) as j, c.when(~(j.equals(i) | j.equals(k) | (scale.load(REAL, j) <= least))):
        p, q = one.load(REAL, j), two.load(REAL, j)
        part = 1.0 / (determinant * scale.load(REAL, j))
        x = (p * two.load(REAL, k) - q * one.load(REAL, k)) * first * part
        y = (q * one.load(REAL, i) - p * two.load(REAL, i)) * second * part
        size = c.largest(c.absolute(x), c.absolute(y))
        worst.set(c.largest(size, worst.get()))
