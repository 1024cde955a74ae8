"""Newton's method for a block of two unknowns, the most frequent size, in LLVM.

    pc_start_pair(frame, t, record)            as `pc_start`
    pc_pair(frame, record) -> flag             as `pc_step`
    pc_linear_pair(frame, record) -> flag      as `pc_linear`

The rule is that of `newton` with its loops written out. Two unknowns come from determinants: one
division, where an elimination waits for one after the other. Of a step of Newton's method the step
behind it mends what rounding they add. A linear block is not mended, so its rows must be clearly
apart. Whatever is rare, as a matrix that is nearly singular, is left to the general functions,
before anything is stored.

Reference: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 1.10.1: for
           two unknowns the error of Cramer's rule is no larger than that of an elimination.
"""

from __future__ import annotations

from typing import Final

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.codegen.native.flags import DONE, MORE
from planarc.codegen.native.newton import Block, fail, start
from planarc.ir.frame import COUNT, FACTOR, NORM, TINY, Number
from planarc.ir.newton import FAR, NEARLY, QUADRATIC, SINGULAR, STEPS_BELOW

#: Above it nothing is counted as a number.
_HUGE: Final = 1e300
#: Size of a determinant, beside the sizes of its rows, where a step behind mends the solution, and
#: where none does: there no more than some three digits may be lost in what an equation leaves.
_MENDED, _UNMENDED = 2 * SINGULAR, NEARLY


def pair_functions() -> tuple[str, ...]:
    return _start(), _step(), _linear()


@function("void pc_start_pair(ptr frame, double t, ptr record)")
def _start(c: Code, frame: Value, t: Value, record: Value) -> None:
    b = Block(frame, record)
    solves = b.numbers.load(INT, Number.MODE).equals(0)
    with c.when(~(b.below & solves), leaves=True):
        c.run("pc_start", frame, t, record)
        c.give()
    b.state.store(0.0, COUNT)
    b.state.store(0.0, TINY)
    h = t - b.accepted.load(REAL, b.total * 3)
    half = h * h * 0.5
    for k in (0, 1):
        start(c, b, b.solved.load(INT, k), h, half)
    c.give()


class _Pair:
    """The two unknowns of a block: their places among the tears, their matrix row by row."""

    def __init__(self, c: Code, b: Block) -> None:
        self.places = [c.select(b.below, b.solved.load(INT, k), c.constant(k, INT)) for k in (0, 1)]
        rows = b.jacobian, b.jacobian.at(b.n)
        self.rows = [[row.load(REAL, i) for i in self.places] for row in rows]
        self.sizes = [_larger(c, *map(c.absolute, row)) for row in self.rows]

    def solve(self, c: Code, right: list[Value], apart: float) -> tuple[list[Value], Value]:
        """The solution for a right side, and whether there is one: where rows are as far `apart`,
        and all numbers finite."""
        (a, b), (d, e) = self.rows
        (p, q), (s, t) = right, self.sizes
        determinant = a * e - b * d
        inverse = 1.0 / determinant
        found = [(p * e - q * b) * inverse, (q * a - p * d) * inverse]
        size = c.absolute(determinant)
        together = (s + t) + (c.absolute(p) + c.absolute(q)) + sum(map(c.absolute, found), size)
        return found, (size > s * t * apart) & (together < _HUGE)


@function("i32 pc_pair(ptr frame, ptr record)")
def _step(c: Code, frame: Value, record: Value) -> None:
    b = Block(frame, record)
    with c.when(b.below & (b.numbers.load(INT, Number.MODE) > 0), leaves=True):
        c.give(DONE)
    pair = _Pair(c, b)
    places, sizes = pair.places, pair.sizes
    residuals = [b.residuals.load(REAL, i) for i in (0, 1)]
    change, usual = pair.solve(c, residuals, _MENDED)
    count = b.state.load(REAL, COUNT)
    # Sizes are multiplied, not divided by: divisions wait for each other.
    norm, left = b.state.load(REAL, NORM), list(map(c.absolute, residuals))
    less = [r < norm * b.sizes.load(REAL, i) for i, r in enumerate(left)]
    better = (count < 1.0) | (less[0] & less[1])
    slots = [b.x(i) for i in places]
    old = [x.load(REAL) for x in slots]
    new = [x - d for x, d in zip(old, change, strict=True)]
    ways, ends = list(map(c.absolute, change)), list(map(c.absolute, new))
    usual = usual & better & (count < float(STEPS_BELOW - 1))
    limits = [_larger(c, x, c.constant(1.0, REAL)) * QUADRATIC for x in ends]
    small = (ways[0] < limits[0]) & (ways[1] < limits[1])
    beside = (ways[0] <= ends[0] * QUADRATIC) & (ways[1] <= ends[1] * QUADRATIC)
    usual = usual & (~small | beside)  # else it takes more to know whether it is the last
    with c.when(~usual, leaves=True):
        c.give(c.call(FLAG, "pc_step", frame, record))
    for slot, x in zip(slots, new, strict=True):
        slot.store(x)
    with c.when(small, leaves=True):
        b.state.store(count + 1.0, COUNT)
        with c.when(b.below & _is_far(c, b, places, new), leaves=True):
            fail(c, b)
        c.give(DONE)
    for k, i in enumerate(places):
        b.change.store(change[k], k)
        b.sizes.store(sizes[k], k)
        b.before.store(old[k], i)
    b.state.store(count + 1.0, COUNT)
    b.state.store(1.0, FACTOR)
    b.state.store(0.0, TINY)
    b.state.store(_larger(c, *(r / s for r, s in zip(left, sizes, strict=True))), NORM)
    c.give(MORE)


def _larger(c: Code, p: Value, q: Value) -> Value:
    return c.select(p > q, p, q)


@function("i32 pc_linear_pair(ptr frame, ptr record)")
def _linear(c: Code, frame: Value, record: Value) -> None:
    b = Block(frame, record)
    given = b.below & (b.numbers.load(INT, Number.MODE) > 0)
    pair = _Pair(c, b)
    right = [c.variable(b.residuals.load(REAL, i)) for i in (0, 1)]
    with c.when(b.below), c.loop(b.n) as j:  # the states as given
        solved = j.equals(pair.places[0]) | j.equals(pair.places[1])
        x = c.select(solved, 0.0, b.x(j).load(REAL))
        for total, row in zip(right, (b.jacobian, b.jacobian.at(b.n)), strict=True):
            total.set(total.get() + row.load(REAL, j) * x)
    found, usual = pair.solve(c, [total.get() for total in right], _UNMENDED)
    s, t = pair.sizes
    usual = usual & (s > t * NEARLY) & (t > s * NEARLY)
    with c.when(given | ~usual, leaves=True):
        with c.when(b.below & ~given):
            b.numbers.store(c.constant(1, INT), Number.NEAR)
        c.give(c.call(FLAG, "pc_linear", frame, record))
    for k, i in enumerate(pair.places):
        b.x(i).store(0.0 - found[k])
    c.give(DONE)


def _is_far(c: Code, b: Block, places: list[Value], x: list[Value]) -> Value:
    """Whether an unknown lies far from where it started."""
    far = []
    for i, value in zip(places, x, strict=True):
        origin = b.origin.load(REAL, i)
        limit = _larger(c, c.absolute(origin), c.constant(1.0, REAL)) * FAR
        far.append(c.absolute(value - origin) > limit)
    return far[0] | far[1]
