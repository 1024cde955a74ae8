"""How often a value is read.

What nothing reads but the time of a loop that sets it needs no place in memory.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from itertools import chain

from planarc.codegen.certain import all_lets, taken_values
from planarc.codegen.native.shapes import Shapes
from planarc.ir.expr import Expr
from planarc.ir.program import Program


def reads_of(program: Program, shapes: Shapes) -> Counter[Expr]:
    """How many formulas of the program's functions read each leaf."""
    lists = (program.parameters, *program.levels, program.rest, program.initial, program.roots,
             program.discrete)  # fmt: skip
    values = [let.value for statements in lists for let in all_lets(program, statements)]
    values += [*program.initial_residuals, *(r.zero for r in program.relations)]
    for code in program.blocks:
        values += taken_values(code)
        if code.direct is not None:
            values += code.direct.values
    return counted(values, shapes)


def counted(values: Iterable[Expr], shapes: Shapes) -> Counter[Expr]:
    """How many of the values read each leaf."""
    return Counter(chain.from_iterable(shapes(v)[1] if v.args else (v,) for v in values))
