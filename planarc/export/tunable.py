"""Parameters that a host may change while the model runs: those that the start does not hang on.

In:   Program
Out:  names of parameters, and of all that is computed from these alone

Positions, velocities, start values and events are to stay as they were found: what these are
computed from stays fixed. Left are masses, springs, dampers and the like.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.instance.plan import is_settable
from planarc.ir.expr import Expr, symbols, text
from planarc.ir.once import once
from planarc.ir.program import Let, Program, Solve, Statement


@once
def tunable_parameters(program: Program) -> frozenset[str]:
    """Names of parameters that can be set, and of those that follow from them."""
    solved = any(isinstance(s, Solve) for s in program.parameters)
    forces = any(not f.height for f in program.fixed)  # of which the start may hang on everything
    if solved or forces or program.initial_residuals:
        return frozenset()
    needed = {text(s) for s in symbols(*_of_start(program))}
    lets = [s for s in program.parameters if isinstance(s, Let)]
    for let in reversed(lets):
        name = text(let.target)
        if name in needed or name.startswith("start("):
            needed.update(text(s) for s in symbols(let.value))
    found = {p.name for p in program.parameter_slots if is_settable(p)} - needed
    for let in lets:
        if any(text(s) in found for s in symbols(let.value)):
            found.add(text(let.target))
    return frozenset(found)


def _of_start(program: Program) -> Iterator[Expr]:
    for level in (*program.levels[:-1], program.roots, program.discrete):
        yield from _values(program, level)
    for block in (b for b in program.blocks if b.height):
        yield from (let.value for let in (*block.body, *block.jacobian_body))
        yield from (value for _, _, value in block.jacobian)
    for _, start, interval, _ in program.samplers:
        yield from (start, interval)
    for delay in program.delays:
        yield from (delay.interval, *(() if delay.maximum is None else (delay.maximum,)))
    for when in program.whens:
        for _, _, actions in when.branches:
            yield from (a.value for a in actions if hasattr(a, "value"))


def _values(program: Program, statements: Iterable[Statement]) -> Iterator[Expr]:
    """What is computed, in blocks too: events may stand on any level."""
    for s in statements:
        if isinstance(s, Let):
            yield s.value
        else:
            block = program.blocks[s.block]
            yield from (let.value for let in (*block.body, *block.jacobian_body))
