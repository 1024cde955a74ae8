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

    plain      all of it in machine code, where each question has a plain answer
    search     else which start values are held, and the loops closed with them
    judge      joints that hold a motion twice (`redundancy`), bars on one line (`flat`)

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
from planarc.solve.start import plain
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
    judge: Callable[[System, Vector], None] | None = None,
    rescue: Rescue | None = None,
    near: Vector | None = None,
    follow: bool = False,
) -> Start:
    """Leaves the workspace at the start values found. `given` are the slots of start values
    that the user sets for this run: they count as written. `judge` is shown the assembled
    mechanism, before it is known whether it can move. `near` are the candidates at a place that
    is better as a guess than start values that nothing holds; with `follow` it was an assembly, and
    one beside it is taken without looking for others."""
    ordinary = near is None and judge is None
    if ordinary and (found := plain.begin(program, kernel, t, given)) is not None:
        told = _told(program, kernel.w, given, found.uses, form_of(program).fixed)
        return Start(found.values, told, found.determined)
    from planarc.solve.start.search import search

    system, values, held = search(program, kernel, t, given, rescue, near, follow)
    return _finish(system, values, held, judge)


def _finish(
    system: System,
    values: Vector,
    held: Sequence[bool],
    judge: Callable[[System, Vector], None] | None,
) -> Start:
    if judge is None:
        from planarc.solve.start.redundancy import refuse_redundancy

        judge = refuse_redundancy
    program = system.program
    flag = system.evaluate_flag(values)
    judge(system, values)
    if flag != 0 or not system.finite(values):
        from planarc.solve.start.unevaluated import not_evaluated

        # Judging has evaluated other places: the kernel is to say what fails at this one.
        raise not_evaluated(system, system.evaluate_flag(values))
    w, found = system.kernel.w, (values * system.units).tolist()
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
