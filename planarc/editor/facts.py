"""What a checked model says of its variables: values, units, states, blocks.

In:   Seen    what a check was made from
Out:  Facts   by the full names of the flat model

The values are those at the start; where that cannot be found, those of parameters alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from msgspec.structs import replace

from planarc import stages
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.prose import counted
from planarc.ir.expr import Op, symbol_text
from planarc.ir.program import Program
from planarc.ir.sorted import Block, SortedDae, computed
from planarc.probe.check import Seen
from planarc.probe.open import open_program


class Fact(Data):
    """The facts of a scalar variable. `block` tells what it is solved with, in words."""

    unit: str = ""
    description: str = ""
    value: float | None = None
    is_state: bool = False
    parameter: bool = False
    block: str = ""


class Facts(Data):
    scalars: dict[str, Fact]
    sizes: dict[str, tuple[int | None, ...]]  # of arrays

    def of(self, name: str) -> tuple[tuple[str, Fact], ...]:
        """A variable, or the elements of an array in their order."""
        if name in self.scalars:
            return ((name, self.scalars[name]),)
        return tuple((n, f) for n, f in self.scalars.items() if n.startswith(f"{name}["))

    def states_in(self, component: str) -> tuple[str, ...]:
        start = f"{component}." if component else ""
        return tuple(n for n, f in self.scalars.items() if f.is_state and n.startswith(start))


def facts_of(seen: Seen) -> Facts:
    sizes = {v.name: v.type.dims for v in seen.flat.variables if v.type.dims}
    program = stages.to_program(seen.model)
    blocks, states = _blocks(seen.model), {c.display for c in seen.model.candidates}
    values = dict(_values(program))
    scalars = {}
    for column in program.columns:
        fact = Fact(column.unit, column.description, values.get(column.name))
        kind = "" if column.constant else blocks.get(column.name, "")
        state = column.name in states
        scalars[column.name] = replace(fact, is_state=state, parameter=column.constant, block=kind)
    return Facts(scalars, sizes)


def _values(program: Program) -> Iterator[tuple[str, float]]:
    try:
        opened = open_program(program)
    except (PlanarcError, ArithmeticError):
        return
    started = True
    try:
        opened.start()
    except (PlanarcError, ArithmeticError):
        started = False
    for column in program.columns:
        if started or column.constant:
            value = column.sign * float(opened.kernel.w[column.slot])
            if math.isfinite(value):
                yield column.name, value


def _blocks(model: SortedDae) -> dict[str, str]:
    """The words about the block of each variable that a block computes."""
    found: dict[str, str] = {}
    number = 0
    for level in model.levels:
        for step in level.steps:
            if not isinstance(step, Block) or not step.residuals:
                continue
            number += 1
            kind = "linear" if step.linear else "nonlinear"
            words = f"{kind} block {number} of {counted(len(step.residuals), 'equation')}"
            for symbol in computed(step):
                found.setdefault(symbol_text(*symbol.data), words)
    for alias in model.aliases:
        if alias.target.op is Op.SYMBOL and symbol_text(*alias.target.data) in found:
            found.setdefault(alias.name, found[symbol_text(*alias.target.data)])
    return found


def shown(value: float, unit: str = "") -> str:
    """A number as an editor shows it."""
    text = f"{value:.6g}"
    return f"{text} {unit}" if unit and unit != "1" else text
