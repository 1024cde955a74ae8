"""A program without parameters on which nothing hangs that an exported model computes.

In:   Program
Out:  Program   without their columns, without what computes them

Most of them are colours, widths and outlines of a picture that an FMU does not draw; others belong
to laws of force that are not chosen. A host that set one would change nothing.

    width := 0.02                 read by the drawing alone           left out
    outline[1] := r + R*cos(a)    read by the drawing alone           left out, and `a` with it
    m := 2.5                      read by an equation                 stays
    gear                          a parameter of the model itself     stays, whoever reads it

Promises:  all values keep their places; what stays is computed as it was.
"""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import Struct
from msgspec.structs import replace

from planarc.ir.expr import Expr, symbols, text
from planarc.ir.program import Let, Program

#: What says nothing of what is computed, and what is judged here.
_ASIDE = frozenset(
    {"columns", "limits", "enumerations", "parameter_slots", "parameters", "visuals", "declared",
     "parts", "figures", "mechanism", "equations", "initial_equations", "table", "slots", "span",
     "locked"}
)  # fmt: skip


def without_idle(program: Program) -> Program:
    """The program with the parameters that count, and those of the model itself."""
    of_parameters = {p.slot for p in program.parameter_slots}
    needed = {program.slots.get(text(e)) for e in symbols(*_formulas(program))}
    needed |= {slot for c in program.candidates for slot in (c.start, c.nominal)}
    needed |= {f.start for f in program.fixed} | {d.start for d in program.discretes}
    needed |= {start for _, start in program.guesses} | {d.interval_slot for d in program.delays}
    needed |= {c.slot for c in program.columns if "." not in c.name}
    kept = []
    for s in reversed(program.parameters):
        slot = program.slots.get(text(s.target)) if isinstance(s, Let) else None
        if slot not in of_parameters or slot in needed:
            kept.append(s)
            if isinstance(s, Let):
                needed.update(program.slots.get(text(e)) for e in symbols(s.value))
            else:
                return program  # parameters that equations tie together
    idle = of_parameters - needed
    return replace(
        program,
        columns=tuple(c for c in program.columns if c.slot not in idle),
        parameter_slots=tuple(p for p in program.parameter_slots if p.slot not in idle),
        parameters=tuple(reversed(kept)),
    )


def _formulas(program: Program) -> Iterator[Expr]:
    """All but those of parameters."""
    todo = [getattr(program, name) for name in program.__struct_fields__ if name not in _ASIDE]
    while todo:
        found = todo.pop()
        if isinstance(found, Expr):
            yield found
        elif isinstance(found, tuple):
            todo += found
        elif isinstance(found, Struct):
            todo += (getattr(found, name) for name in found.__struct_fields__ if name != "span")
