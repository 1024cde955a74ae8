"""Inputs that are no Reals, as a page takes them: held during the run, as parameters are.

In:   Program
Out:  Program   with parameters in their place

A page sets each value once, before the run begins. `pre(on)` is `on` then.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.export.refusal import refuse
from planarc.ir.program import DiscreteSlot, Let, ParameterSlot, Program


def held_inputs(program: Program) -> tuple[DiscreteSlot, ...]:
    """The inputs of the model itself that are Booleans, Integers or enumerations."""
    return tuple(d for d in program.discretes if d.given is not None)


def taken(program: Program, stiff: bool = False) -> Program:
    """The program, in which these are parameters. Raises PlanarcError C300 for what a page cannot
    run."""
    held, table = held_inputs(program), program.table
    found = replace(
        program,
        discretes=tuple(d for d in program.discretes if d not in held),
        parameter_slots=(
            *program.parameter_slots,
            *(ParameterSlot(d.name, d.slot, d.kind, True, False) for d in held),
        ),
        parameters=(
            *program.parameters,
            *(Let(table.pre(d.name), table.symbol(d.name)) for d in held),
        ),
    )
    refuse(found, stiff)
    return found
