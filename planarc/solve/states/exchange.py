"""Other states on the way: the choice watched, exchanged, and tried as a rescue.

A choice of states that was good at the start may go bad where the mechanism moves to
(`states` judges it). Then the run goes on with other states from the same point; where
that was seen too late, it goes back to the last place where the choice was good.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.ir.result import StateChoice
from planarc.solve.messages import failure
from planarc.solve.solvers.integrator import March
from planarc.solve.states.selector import lost_diagnostic

if TYPE_CHECKING:
    from planarc.solve.run import Run


def watch(run: Run) -> None:
    """The workspace holds an accepted point near by: good enough to judge the choice."""
    if not run.selector.open:
        return
    t, y = run.integrator.t, run.integrator.y
    changed, lost = run.selector.check()
    if lost is not None:
        run.ended = lost_diagnostic(run.program, t, lost)
    elif changed and run.selector.overdue and go_back(run):
        return
    elif changed and run.kernel.outputs(t, y) == 0:
        exchange(run, t, run.integrator.last_step())
    elif not changed:
        run.refuge.keep(t, y)


def go_back(run: Run) -> bool:
    """To the last place where the choice of states was good, and on in shorter looks."""
    refuge = run.refuge
    if run.delays.present or not refuge.enter(run.integrator.t):
        return False
    run.asserts.forget(run.recorder.count)
    run.selector.restore(run.selection)
    run.selector.hurry()
    run.restart(refuge.t, refuge.y)
    return True


def exchange(run: Run, t: float, step: float | None) -> None:
    """Other states from here on; the workspace holds consistent values at `t`."""
    run.selection = run.selector.selection()
    run.kernel.select(run.selection)
    names = tuple(run.program.candidates[i].display for i in run.selection)
    run.states.append(StateChoice(t, names))
    run.restart(t, run.state_values(), step)


def rescue(run: Run, march: March) -> None:
    """The integrator failed: other states may help, else the run ends here."""
    t, y = run.integrator.t, run.integrator.y
    failed = run.kernel.failed_block
    usable = run.kernel.outputs(t, y) == 0
    if usable and run.selector.open:
        changed, lost = run.selector.check(urgent=True)
        if changed and run.selector.overdue and go_back(run):
            return
        if changed:
            exchange(run, t, None)
            return
        if lost is not None:
            run.ended = lost_diagnostic(run.program, t, lost)
            return
    run.ended = failure.stopped(run, t, y, march.cause, failed)
