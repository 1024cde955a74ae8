"""A driven loop that jams, in words: how far its bars reach, and how it may be meant.

In:   the message about the loop; Program, Kernel at the place where it jams, parts of the loop
Out:  the message at the part to change, with a hint

Example: a motor turns a crank of 0.2 m, whose rod of 0.15 m does not reach its slide everywhere.
"""

from __future__ import annotations

from collections.abc import Collection

from msgspec.structs import replace

from planarc.core.prose import listed
from planarc.ir.kernel import Kernel
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.messages.loops import lengths_in_loop
from planarc.solve.messages.slides import goes_round
from planarc.solve.messages.trouble import Unsolved


def jammed(
    found: Unsolved, program: Program, kernel: Kernel, components: Collection[str]
) -> Unsolved:
    """At what would let a crank go round if it were changed, else at the shortest bar."""
    lengths = lengths_in_loop(program, kernel, components)
    culprit, otherwise = goes_round(program, kernel, components, lengths)
    shortest = min(lengths, key=lambda name: lengths[name], default="")
    told = listed(f"`{name}` over {length:.4g} m" for name, length in lengths.items())
    part = own_part(program, culprit or shortest)
    hint = "it is jammed here, as its parts do not reach where this leads"
    hint += f", {told}" if told else ""
    hint += f": {f'{otherwise}; or ' if culprit else ''}end the run before, or change lengths"
    return replace(found, span=part.span if part else found.span, hint=hint)
