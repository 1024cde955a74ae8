"""Motions that change no condition at the start, in LLVM.

    pc_motions(frame, table, out, q, part) -> rank

The rows of the Jacobian that `differences` tells, made comparable with lengths and then orthogonal
by the method of Gram and Schmidt, the longest first; and behind them what completes a basis, from
the unit vectors that are the furthest from it. `q` holds as many vectors as the `table` has
candidates, each as long; from number `rank` on they are the motions.

Rows count as dependent from `part` of the longest on. Where one is not clearly longer or shorter,
by a factor of `CLEAR`, the rank is -1, as where there are more rows than candidates or no numbers:
then singular values decide (`solve.start.newton`).

Reference: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed. 2013, section 5.2.8.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.codegen.native.differences import counts
from planarc.ir.newton import CLEAR


@function("i32 pc_motions(ptr frame, ptr table, ptr out, ptr q, double part)", seldom=True)
def motions_function(
    c: Code, frame: Value, table: Value, out: Value, q: Value, part: Value
) -> None:
    n, *others = counts(table)
    width = others[0] + others[1] + others[2]
    flag = c.call(FLAG, "pc_differences", frame, table, out)
    with c.when(~flag.equals(0) | (width > n), leaves=True):
        c.give(-1)
    with c.loop(width) as i:
        size = c.variable(1.0)
        with c.loop(n) as j:
            size.set(c.largest(c.absolute(out.load(REAL, (j + 1) * width + i)), size.get()))
        with c.loop(n) as j:
            q.store(out.load(REAL, (j + 1) * width + i) / size.get(), i * n + j)
    rank = _orthogonalize(c, q, width, n, part)
    with c.loop(n, rank) as k:
        _complete(c, q, k, n)
    c.give(c.flag(rank))


def _orthogonalize(c: Code, q: Value, width: Value, n: Value, part: Value) -> Value:
    rank, first = c.variable(0, INT), c.variable(0.0)
    done = c.label()
    with c.loop(width) as k:
        longest, most = c.variable(k, INT), c.variable(-1.0)
        with c.loop(width, k) as i:
            length = _product(c, q.at(i * n), q.at(i * n), n)
            with c.when(~(length <= most.get())):
                longest.set(i)
                most.set(length)
        own, other = q.at(k * n), q.at(longest.get() * n)
        with c.loop(n) as j:
            one, two = own.load(REAL, j), other.load(REAL, j)
            own.store(two, j)
            other.store(one, j)
        length = c.call(REAL, "llvm.sqrt.f64", most.get())
        with c.when(k.equals(0)):
            first.set(length)
        least = first.get() * part
        c.leave(length * CLEAR <= least, done)
        with c.when(~(length > least * CLEAR), leaves=True):
            c.give(-1)
        _scale(c, own, 1.0 / length, n)
        with c.loop(width, k + 1) as i:
            _project(c, q.at(i * n), own, n)
        rank.set(k + 1)
    c.enter(done)
    return rank.get()


def _complete(c: Code, q: Value, k: Value, n: Value) -> None:
    furthest, most = c.variable(0, INT), c.variable(-1.0)
    with c.loop(n) as j:
        left = c.variable(1.0)
        with c.loop(k) as i:
            entry = q.load(REAL, i * n + j)
            left.set(left.get() - entry * entry)
        with c.when(left.get() > most.get()):
            furthest.set(j)
            most.set(left.get())
    own = q.at(k * n)
    with c.loop(n) as j:
        own.store(c.select(j.equals(furthest.get()), c.constant(1.0, REAL), 0.0), j)
    with c.loop(2), c.loop(k) as i:  # twice is enough
        _project(c, own, q.at(i * n), n)
    length = c.call(REAL, "llvm.sqrt.f64", _product(c, own, own, n))
    _scale(c, own, 1.0 / length, n)


def _product(c: Code, a: Value, b: Value, n: Value) -> Value:
    total = c.variable(0.0)
    with c.loop(n) as j:
        total.set(total.get() + a.load(REAL, j) * b.load(REAL, j))
    return total.get()


def _scale(c: Code, a: Value, factor: Value, n: Value) -> None:
    with c.loop(n) as j:
        a.store(a.load(REAL, j) * factor, j)


def _project(c: Code, a: Value, unit: Value, n: Value) -> None:
    """What of a vector is at right angles to a unit vector."""
    c.subtract(a, unit, _product(c, a, unit, n), n)
