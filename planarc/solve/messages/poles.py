"""Poles of the user's own equations that a run stepped over: a divisor that went through zero.

In:   Program, the rows of a run that went to its end
Out:  a warning R421 for the first pole of each equation

What has a pole is no state, so that nothing stops there: the rows before and behind it are right,
and it is easily overlooked. A division under an `if` may be guarded, so it is not looked at.

Example: `b = f*g/(g - f)` while g falls from 3 to 1 and f is 2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.expr import Expr, Op, brief, postorder
from planarc.ir.once import once
from planarc.ir.places import is_own
from planarc.ir.program import EquationInfo, Program

if TYPE_CHECKING:
    from planarc.core.arrays import Vector


class Division(Data):
    info: EquationInfo
    above: Expr
    below: Expr


def stepped_over(
    program: Program, time: Vector, column: Callable[[Expr], Vector | float]
) -> Iterator[Diagnostic]:
    """Warnings of poles between rows. `column` gives the values of a symbol, or of time, in all
    rows."""
    import numpy as np

    from planarc.evaluate.rows import RowValues

    divisions = _divisions(program)
    if not divisions or len(time) < 2:
        return
    values, told = RowValues(column), set()
    for d in divisions:
        with np.errstate(all="ignore"):
            above, below = (np.broadcast_to(values(e), time.shape) for e in (d.above, d.below))
            signs = np.sign(below)
            turns = (signs[1:] * signs[:-1] <= 0) & (time[1:] > time[:-1])
            found = np.flatnonzero(turns & (above[1:] * above[:-1] > 0))
        if len(found) and d.info.text not in told:
            told.add(d.info.text)
            k = int(found[0])
            at = float(np.interp(0.0, *_rising(below[k : k + 2], time[k : k + 2])))
            yield Diagnostic(
                "R421",
                f"`{d.info.text}` divides by `{brief(d.below)}`, which goes through zero at "
                f"t = {at:.6g} s: near to it the value has no bounds",
                d.info.span,
                Severity.WARNING,
                hint="end the run before, or keep the divisor away from zero",
            )


def _rising(x: Vector, y: Vector) -> tuple[Vector, Vector]:
    return (x, y) if x[0] <= x[-1] else (x[::-1], y[::-1])


@once
def _divisions(program: Program) -> tuple[Division, ...]:
    """Divisions by what changes, that no `if` guards, in equations of the user's own."""
    constant = {c.slot for c in program.columns if c.constant}
    constant |= {p.slot for p in program.parameter_slots}

    def varies(e: Expr) -> bool:
        leaves = (x for x in postorder((e,)) if not x.args and x.op is not Op.CONST)
        slots = [None if x.op is Op.TIME else program.slots.get(repr(x), -1) for x in leaves]
        return -1 not in slots and not constant.issuperset(slots)

    return tuple(
        Division(info, *e.args)
        for info in program.equations
        if not isinstance(info.written, str) and is_own(program, info.span)
        for e in _unguarded(info.written)
        if varies(e.args[1])
    )


def _unguarded(roots: tuple[Expr, ...]) -> Iterator[Expr]:
    stack = list(roots)
    while stack:
        e = stack.pop()
        if e.op is Op.DIV:
            yield e
        if e.op is not Op.IF:
            stack += e.args
