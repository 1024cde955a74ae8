"""The states of a run: chosen at its start, watched on the way, exchanged where they go bad.

In:   Program, Kernel at an accepted point, what the selector says of the choice there
Out:  GoOn         where the run goes on: with other states from the same point, or with better
                   looks from the last place where the choice was good
      Diagnostic   why it ends: a state that cannot go on being one
      None         nothing changes

A choice of states that was good at the start may go bad where the mechanism moves to
(`selector` judges it). Nothing here moves the run: it does as it is told.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.ir.result import Held, StateChoice
from planarc.solve.measure import length_of, sizes_of_errors
from planarc.solve.recorder import Recorder
from planarc.solve.refuge import Refuge
from planarc.solve.states.selector import Determined, Selector, lost_diagnostic


class GoOn(Data):
    """The point at which the run restarts; `step` is the first one to try."""

    t: float
    y: list[float]
    step: float | None = None
    back: bool = False  # rows after `t` were taken back


class States:
    """The states of a run, chosen and exchanged. `selection` are the candidates that are states
    now; `choices` what they were, since when.

    `delayed`: signals have a past, so that the run cannot go back; `measured`: the integrator
    itself measures the choice at every step.
    """

    def __init__(
        self, program: Program, kernel: Kernel, recorder: Recorder, delayed: bool, measured: bool
    ) -> None:
        self._program, self._kernel, self._delayed = program, kernel, delayed
        self.selector = Selector(program, kernel, measured)
        self.watch = self.selector.watch
        self._refuge = self.watch.refuge = Refuge(kernel, program, recorder)
        self.selection: list[int] = []
        self.choices: list[StateChoice] = []

    def choose(self, t: float, held: Sequence[Held], known: Determined | None = None) -> None:
        """Choose by the workspace's values, whatever was chosen before; `held` tells of each
        candidate whether its start value was. Raises R423."""
        self.take(self.selector.choose([i for i, h in enumerate(held) if h.held], known))
        self.choices[:] = [self._choice(t)]

    def take(self, selection: Sequence[int]) -> None:
        """Make these candidates the states."""
        self.selection = list(selection)
        self._kernel.select(self.selection)

    def _choice(self, t: float) -> StateChoice:
        return StateChoice(t, tuple(self._program.candidates[i].display for i in self.selection))

    def values(self) -> list[float]:
        """The values that the states have in the workspace."""
        return [self._kernel.w[self._program.candidates[i].slot] for i in self.selection]

    def slots(self) -> dict[int, int]:
        """The index of each state by its slot."""
        return {self._program.candidates[c].slot: k for k, c in enumerate(self.selection)}

    def places(self) -> list[int]:
        """The slots of the states, then those of their derivatives."""
        chosen = [self._program.candidates[i] for i in self.selection]
        return [*(c.slot for c in chosen), *(c.derivative for c in chosen)]

    def absolute(self, tolerance: float) -> list[float]:
        """The absolute tolerance of each state: a part of its nominal value, or of what it is
        measured by."""
        w, result = self._kernel.w, []
        chosen = [self._program.candidates[i] for i in self.selection]
        length = length_of(self._program, self._kernel)
        own = sizes_of_errors(self._program, length, (c.slot for c in chosen))
        for candidate, size in zip(chosen, own, strict=True):
            nominal = candidate.nominal
            result.append(tolerance * (abs(w[nominal]) or size if nominal is not None else size))
        return result

    def resume(self, t: float, y: Sequence[float]) -> None:
        """The integrator restarts here, with a choice that is good."""
        if self.selector.open:
            self._refuge.keep(t, y)
        self.watch.restart()

    # The choice looked at

    def look(self, t: float, y: Sequence[float], step: float) -> GoOn | Diagnostic | None:
        """The workspace holds an accepted point near by: good enough to judge the choice."""
        if not self.selector.open:
            return None
        changed, lost = self.selector.check()
        if lost is not None:
            return lost_diagnostic(self._program, t, lost)
        if not changed:
            self._refuge.keep(t, y)
            return None
        if back := self._go_back(t):
            return back
        return self._exchange(t, step) if self._kernel.outputs(t, y) == 0 else None

    def rescue(self, t: float) -> GoOn | Diagnostic | None:
        """Other states where the integrator failed; the workspace holds the point reached."""
        if not self.selector.open:
            return None
        changed, lost = self.selector.check(urgent=True)
        if changed:
            return self._go_back(t) or self._exchange(t, None)
        return lost_diagnostic(self._program, t, lost) if lost is not None else None

    def after_event(self, t: float) -> GoOn | None:
        """Other states where an event has left the present ones no longer good."""
        changed, _ = self.selector.check(urgent=True)
        return self._exchange(t, None) if changed else None

    def _exchange(self, t: float, step: float | None) -> GoOn:
        """Other states from here on; the workspace holds consistent values at `t`."""
        self.take(self.selector.selection())
        self.choices.append(self._choice(t))
        return GoOn(t, self.values(), step)

    def _go_back(self, t: float) -> GoOn | None:
        """The last place where the choice of states was good, and shorter looks from there,
        where the present look came too late."""
        if not self.selector.overdue or self._delayed or not self._refuge.enter(t):
            return None
        self.selector.restore(self.selection)
        self.selector.hurry()
        return GoOn(self._refuge.t, self._refuge.y, back=True)
