"""Consistent initial values: positions and velocities that satisfy every constraint.

In:   Program, Kernel (parameters set), the time
Out:  Start    a value for every candidate, and how each start value was used

The unknowns are all candidates for states. Held exactly are, as far as they are
independent of each other under the constraints: those with `fixed = true`; then the
start values that were written, in the order of StateSelect and of declaration, be they
of candidates or of variables that follow from these. All others are guesses, and the
solution nearest to them is taken (`branch`). So the result depends on what the
user wrote alone, never on which states the run chooses.

Example: a four-bar of which three angles have written start values. It has one
degree of freedom, so the first angle is held, and the other two only say on which
side the loop closes.

    held       which start values are held (`held`)
    assembly   the loops closed with them (`assembly`, on the right side: `branch`)
    judge      joints that hold a motion twice (`redundancy`), bars on one line (`flat`)
    failure    why there is no start, in words

Promises: does not depend on tolerances.
Raises:   PlanarcError R411 (fixed values contradict), R412 (does not assemble),
          R410 (cannot be solved), R413 (cannot be evaluated), R415 (redundant joints),
          R428 (held at a dead centre), R437 (flat).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.ir.dae import MISFIT
from planarc.ir.kernel import Kernel
from planarc.ir.program import FixedSlot, Program
from planarc.ir.result import Held
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.start import plain, sharing
from planarc.solve.start.assembly import assemble
from planarc.solve.start.held import choose_closed, choose_fixed, choose_held, is_confirmed
from planarc.solve.start.redundancy import refuse_redundancy
from planarc.solve.start.singular import refuse_singular
from planarc.solve.start.system import System, form_of, is_written
from planarc.solve.states.selector import Determined

if TYPE_CHECKING:
    from planarc.core.arrays import Vector


class Start(Data):
    values: tuple[float, ...]  # of the candidates
    held: tuple[Held, ...]  # of the candidates, then of other variables with a written start
    determined: Determined | None = None  # the choice of states there, where it is known


def solve_start(
    program: Program,
    kernel: Kernel,
    t: float,
    given: frozenset[int] = frozenset(),
    judge: Callable[[System, Vector], None] = refuse_redundancy,
    rescue: Rescue | None = None,
    near: Vector | None = None,
    follow: bool = False,
) -> Start:
    """Leaves the workspace at the start values found. `given` are the slots of start values
    that the user sets for this run: they count as written. `judge` is shown the assembled
    mechanism, before it is known whether it can move. `near` are the candidates at a place that
    is better as a guess than start values that nothing holds; with `follow` it was an assembly, and
    one beside it is taken without looking for others."""
    ordinary = near is None and judge is refuse_redundancy
    if ordinary and (found := plain.begin(program, kernel, t, given)) is not None:
        told = _told(program, kernel.w, given, found.uses, form_of(program).fixed)
        return Start(found.values, told, found.determined)
    import numpy as np

    u0 = np.array(form_of(program).starts(kernel.w), float)
    system = System(program, kernel, t, given, rescue=rescue, follow=follow)
    if not system.rows and not any(system.written(f) for f in program.fixed):
        return _finish(system, u0, [True] * len(u0), judge)
    if near is None:
        choice = choose_held(system, u0)
    else:
        starts = u0
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
        return solve_start(sharing.strict(program), kernel, t, given, judge, rescue, near, follow)
    refuse_singular(system, u0, values, choice)
    return _finish(system, values, choice.held, judge)


def _finish(
    system: System,
    values: Vector,
    held: Sequence[bool],
    judge: Callable[[System, Vector], None],
) -> Start:
    program = system.program
    flag = system.evaluate_flag(values)
    judge(system, values)
    if flag != 0 or not system.finite(values):
        from planarc.solve.start.unevaluated import not_evaluated

        # Judging has evaluated other places: the kernel is to say what fails at this one.
        raise not_evaluated(system, system.evaluate_flag(values))
    w, found = system.kernel.w, values.tolist()
    starts = [float(w[c.start]) for c in program.candidates]
    uses = zip(starts, found, map(bool, held), strict=True)
    return Start(tuple(found), _told(program, w, system.given, uses, system.conditions))


def _told(
    program: Program,
    w: Sequence[float],
    given: frozenset[int],
    uses: Iterable[tuple[float, float, bool]],
    conditions: Sequence[FixedSlot],
) -> tuple[Held, ...]:
    """The use of each start value; `uses` are those of the candidates: what was wanted, what it
    became, whether it is held."""
    told = [Held(c.display, *use) for c, use in zip(program.candidates, uses, strict=True)]
    for f in program.fixed:
        if is_written(f, given) and not f.display.startswith(MISFIT):
            told.append(Held(f.display, float(w[f.start]), float(w[f.slot]), f in conditions))
    return tuple(told)
