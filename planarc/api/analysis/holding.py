"""What touches hold at a point: the motions that are left, in as few coordinates as they need.

In:   Point
Out:  Holding   the states that are left, and how all follow from these

A rigid touch that is held has a'' of its gap for an equation, and what the gap and its speed drift
to is led back, by constants of the method: for a gap at rest their roots are no modes of the
mechanism. Its own motions keep to

    gap = low,  v = 0,  and where it sticks slip = 0.

By the derivatives of these by the states x, in echelon form, some states follow from others z:
dx = lift*dz. The linear model in z is exact, since the true motion never leaves that surface.
States that are parameters which the start finds do not move at all.

Example: a ball that rests on the ground and rolls has x, y, phi and their rates for states; of
these y, v_y and v_x follow from the others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planarc.api.analysis.point import Point, derivative
from planarc.core.arrays import Array, Vector
from planarc.core.data import Data
from planarc.ir.expr import Expr
from planarc.solve.contact.messages import named
from planarc.solve.contact.touches import Touches
from planarc.solve.messages.text import Reader

#: A gradient that differs from those before by less than this part of its size tells nothing new.
DEPENDENT = 1e-6


class Holding(Data, eq=False):
    """`left` numbers the states that are left, `lift` gives all from these; `touches` are named."""

    left: tuple[int, ...]
    lift: Vector
    touches: tuple[str, ...]


def what_holds(point: Point) -> Holding:
    """What touches hold there, and what does not move."""
    left = np.flatnonzero([not c.at_start for c in point.states])
    lift = np.eye(len(point.states))[:, left]
    touches = Touches(point.program, point.kernel)
    if not len(touches.all):
        return Holding(tuple(left.tolist()), lift, ())
    point.outputs(point.y)
    gaps, rates, names = _kept(touches)
    if not names:
        return Holding(tuple(left.tolist()), lift, ())
    speeds = {c.derivative for c in point.program.candidates}
    moving = np.array([c.slot in speeds for c in point.states], dtype=bool)
    for kept, columns in ((gaps, ~moving), (rates, moving)):
        gradients = _unit(_gradients(point, kept)) @ lift
        chosen, others = _follow(gradients, columns[left])
        left, lift = left[others], lift @ chosen
    return Holding(tuple(left.tolist()), lift, names)


def _kept(touches: Touches) -> tuple[list[Expr], list[Expr], tuple[str, ...]]:
    """What does not change: gaps, and speeds and slips; the names of the touches."""
    gaps, rates = list[Expr](), list[Expr]()
    names = dict[str, None]()
    states = zip(touches.all, touches.get("held"), touches.get("way"), touches.bound, strict=True)
    for i, (touch, held, way, bound) in enumerate(states):
        closed, sticks = held != 0 and not bound, way == 0
        if closed:
            gaps.append(touch.read["gap"])
            rates.append(touch.read["v"])
        if sticks:
            rates.append(touch.read["slip"])
        if closed or sticks:
            names[named(touches, i)] = None
    gaps, rates = ([e for e in some if not e.is_const] for some in (gaps, rates))
    return gaps, rates, tuple(names)


def _gradients(point: Point, kept: Sequence[Expr]) -> Vector:
    """Derivatives by the states, a row for each expression."""
    if not kept:
        return np.zeros((0, len(point.y)))
    slots = [point.program.slots.get(repr(e)) for e in kept]
    formulas, whole = point.kernel.capabilities.formulas, [s for s in slots if s is not None]
    if formulas is not None and len(whole) == len(slots):
        found = formulas.derivatives(point.t, point.y.tolist(), (), whole)
        if found is not None:
            return np.asarray(found, dtype=float)
    read = Reader(point.program, point.kernel, point.t)

    def values(y: Vector) -> Vector:
        point.outputs(y)
        return np.array([float(read(e)) for e in kept])

    found = derivative(values, point.y)
    point.accept(point.y)
    return found


def _unit(rows: Vector) -> Vector:
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    scaled: Vector = rows / np.where(sizes > 0, sizes, 1.0)
    return scaled


def _follow(rows: Vector, columns: Array) -> tuple[Vector, Array]:
    """How all coordinates follow from some where the rows give zero; and whether one is of these.
    What follows is sought among `columns`: of a gap places, and of a speed, which hangs on places,
    too, speeds."""
    rows, free, pivots = rows.copy(), np.ones(len(columns), dtype=bool), list[int]()
    for n in range(len(rows)):
        size = np.abs(rows[n:] * columns).round(9)  # of equal ones the first is taken everywhere
        if size.max(initial=0.0) <= DEPENDENT:
            break
        at, column = divmod(int(size.argmax()), rows.shape[1])
        rows[[n, n + at]] = rows[[n + at, n]]
        rows[n] /= rows[n, column]
        others = np.arange(len(rows)) != n
        rows[others] -= np.outer(rows[others, column], rows[n])
        pivots.append(column)
    free[pivots] = False
    chosen = np.eye(len(columns))[:, free]
    chosen[pivots] = -rows[: len(pivots), free]
    return chosen, free
