"""How far the ends of a loop stay apart, as a length.

In:   the equation that is farthest from being met, its residual, and a kernel at the best point
Out:  the distance, with its unit where that is known

An equation between squares of lengths misses by a difference of squares, which is no length.

Example: a `JointRR` of 1 m whose ends are held 3 m from each other. `L*L = d*d` is off by 8 m2, and
the rod is 2 m too short.
"""

from __future__ import annotations

from math import sqrt

from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.program import EquationInfo, Program
from planarc.solve.messages.text import Reader


def units_in(program: Program, info: EquationInfo) -> set[str]:
    """The units of an equation's variables."""
    sides = () if isinstance(info.written, str) else info.written
    names = {e.name for e in postorder(sides) if e.is_symbol}
    return {c.unit for c in program.columns if c.name in names}


def unit_of(program: Program, info: EquationInfo) -> str:
    """The unit of an equation that gives one variable a value; empty where it is not known."""
    sides = () if isinstance(info.written, str) else info.written
    names = {side.name for side in sides if side.is_symbol}
    return next((c.unit for c in program.columns if c.name in names and c.unit), "")


def squares_apart(program: Program, kernel: Kernel, info: EquationInfo) -> float | None:
    """The difference of the lengths whose squares an equation compares; None where it compares
    something else."""
    if isinstance(info.written, str) or not all(map(_is_square, info.written)):
        return None
    read = Reader(program, kernel, 0.0)
    try:
        left, right = (sqrt(read(side)) for side in info.written)
    except (KeyError, ArithmeticError, ValueError):
        return None
    return abs(left - right)


def _is_square(e: Expr) -> bool:
    if e.op is Op.ADD:
        return all(map(_is_square, e.args))
    return e.op is Op.POW and e.args[1].is_const and e.args[1].data == 2
