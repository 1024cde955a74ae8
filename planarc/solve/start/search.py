"""A start that is not plain: start values to be held are chosen, and loops closed with them.

In:   Program, Kernel (parameters set), the time
Out:  the system with all that is held, the values of the candidates in its measure, which of these
      are held

    held       which start values are held (`held`)
    assembly   the loops closed with them (`assembly`, on the right side: `branch`)
    failure    why there is no start, in words
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.solve.measure import length_of
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.start import sharing
from planarc.solve.start.assembly import assemble
from planarc.solve.start.held import choose_closed, choose_fixed, choose_held, is_confirmed
from planarc.solve.start.singular import refuse_singular
from planarc.solve.start.system import System, form_of

if TYPE_CHECKING:
    from planarc.core.arrays import Vector


def search(
    program: Program,
    kernel: Kernel,
    t: float,
    given: frozenset[int],
    rescue: Rescue | None,
    near: Vector | None,
    follow: bool,
) -> tuple[System, Vector, Sequence[bool]]:
    """The arguments are those of `solve_start`."""
    import numpy as np

    length = length_of(program, kernel)
    system = System(program, kernel, t, given, rescue=rescue, follow=follow, length=length)
    u0 = np.array(form_of(program).starts(kernel.w), float) / system.units
    if not system.rows and not any(system.written(f) for f in program.fixed):
        return system, u0, [True] * len(u0)
    if near is None:
        choice = choose_held(system, u0)
    else:
        starts, near = u0, near / system.units
        choice = choose_held(system, np.where([*map(system.written, program.candidates)], u0, near))
        u0 = np.where(choice.held, starts, near)
    values = assemble(system.holding(choice.others), u0, choice)
    if values is None or not is_confirmed(system, values, choice):
        again = choose_closed(system, u0)
        if again is not None and again.choice != choice:
            choice = again.choice
            values = assemble(system.holding(choice.others), u0, choice)
    if values is None and len(u0) <= system.rows:
        wished = choice.others or any(
            h and not c.fixed for h, c in zip(choice.held, program.candidates, strict=True)
        )
        if wished:  # what is not fixed is a guess
            choice = choose_fixed(program)
            values = assemble(system, u0, choice)
    system = system.holding(choice.others)
    if values is None:
        from planarc.solve.start.failure import explain

        raise explain(system, u0, choice)
    if sharing.missed(system, values):
        back = None if near is None else near * system.units
        return search(sharing.strict(program), kernel, t, given, rescue, back, follow)
    refuse_singular(system, u0, values, choice)
    return system, values, choice.held
