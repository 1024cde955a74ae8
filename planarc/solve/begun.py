"""The start of a run: values that fit together, the first states, the first row.

Start values and relations are found by turns: each may change what the other one is. A program
with `homotopy` begins where the way from its simplified equations ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.diagnostic import PlanarcError, Severity, error
from planarc.ir.dae import INITIAL
from planarc.ir.result import EventRecord, Held
from planarc.solve.bench import Bench
from planarc.solve.events.delays import not_settled
from planarc.solve.start.alike import judge_alike
from planarc.solve.start.coincident import judge_coincident
from planarc.solve.start.inertia import judge_inertia
from planarc.solve.start.longest import judge_longest
from planarc.solve.start.moved import judge_moved
from planarc.solve.start.sizes import judge_sizes
from planarc.solve.start.solve import solve_start

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Rounds of start values and relations before they are called contradictory, and after which a loop
#: of numbers is not left to come to rest by itself.
START_ROUNDS, PATIENCE = 50, 12


class Begun(Bench):
    """A run until it leaves its start."""

    def begin(self) -> None:
        """Start values, the first states, the first row."""
        t = self.request.start
        for found in self.schedule.judge(t, self.request.stop):
            if found.severity is Severity.ERROR:
                raise PlanarcError(found)
            self.warnings.append(found)
        self._open(t)
        near = self._led(t)
        follow = near is None and self.request.near is not None
        if follow:
            import numpy as np

            near = np.array(self.request.near)
        self.held = self.settle(t, near, follow)
        y = self.states.values()
        self.rescue.begun = True
        if self.events.present or self.program.table.knows(INITIAL):  # else the first row does it
            self.kernel.outputs(t, y)
        done = self.events.finish_start(t, y, self.states.slots())
        self._note(done.ended, done.warnings)
        if self.events.present:
            fired, slots, struck = self.schedule.firing(t), self.states.slots(), done.told
            done = self.events.process(t, done.y, {}, fired, slots, ahead=False)
            self._note(done.ended, done.warnings)
            y = done.y
            if causes := (*struck, *self.events.causes((), fired)):
                self.records.append(EventRecord(t, causes))
        whole = self._row(t, y)
        if whole and self.events.present and self.ended is None:
            done = self.events.process(t, y, {}, (), slots)
            self._note(done.ended, done.warnings)
            y = done.y
            self._row_where_new(t, y)
        self._already.begin()
        self.recorder.pass_by(t)
        self._check_asserts(True)
        self.warnings += judge_sizes(self.program, self.kernel)
        if (longest := judge_longest(self.program, self.kernel)) is not None:
            self.warnings.append(longest)
        elif (light := judge_inertia(self.program, self.kernel)) is not None:
            self.warnings.append(light)
        if (coincident := judge_coincident(self.program, self.kernel)) is not None:
            self.warnings.append(coincident)
        elif (alike := judge_alike(self.program, self.kernel)) is not None:
            self.warnings.append(alike)
        moved = judge_moved(self.program, self.kernel, self.held, self.request.starts)
        if moved is not None and not (self.warnings and moved.severity is Severity.NOTE):
            self.warnings.append(moved)  # what is told says why it moved
        self.delays.kink(t)
        if whole and not (self.events.present or self.delays.present):  # as it was at the first row
            self._go_on(t, y)
        else:
            self.restart(t, y)
        if self.recorder.count == 0 and self.ended is not None:
            raise PlanarcError(self.ended)
        if self.program.sharing is not None and self.ended is None:
            from planarc.solve.start.sharing import judge_sharing

            self.warnings.append(judge_sharing(self.program, self.kernel, t, y))

    def _open(self, t: float) -> None:
        self.events.begin(t)
        self.delays.begin(t)

    def settle(
        self, t: float, near: Vector | None = None, follow: bool = False
    ) -> tuple[Held, ...]:
        """Start values, near to a place that is known to be good, and what is true there."""
        delayed: bool = False
        held: tuple[Held, ...] = ()

        def changes() -> bool:
            nonlocal delayed, held
            given = frozenset(self.request.starts)
            start = solve_start(
                self.program, self.kernel, t, given, rescue=self.rescue, near=near, follow=follow
            )
            self.kernel.accept(t)
            self.states.choose(t, start.held[: len(self.program.candidates)], start.determined)
            held, delayed = start.held, self.delays.settle_start(t)
            y = self.states.values()
            return delayed or (self.events.present and self.events.settle_start(t, y))

        closed: dict[int, float] = {}
        for count in range(START_ROUNDS):
            before = self.events.state()
            if not changes() or (closed and self.events.rests(before, closed)):
                return held
            if count == PATIENCE and (loop := self.events.changed(before)):
                from planarc.solve.events.closure import close_loop

                if close_loop(self.kernel.w, loop, lambda: changes() or True):
                    closed = {slot: self.kernel.w[slot] for slot in loop}
        if delayed:
            raise not_settled(self.program)
        if (lost := self.events.undefined(t)) is not None:  # it is never what it was before
            raise PlanarcError(lost)
        raise error(
            "R433",
            "the relations and the start values do not agree: they switch to and fro",
            self.program.relations[0].span if len(self.program.relations) == 1 else None,
            hint="write start values that lie clearly on one side of each relation",
        )

    def _led(self, t: float) -> Vector | None:
        """The candidates where the way from simplified equations ends, if there is one."""
        load = self.kernel.capabilities.lead
        if load is None:
            return None
        from planarc.solve.lead import lead, request_of

        program, kernel = load()
        request = request_of(program, self.program, self.kernel, self.request)
        run = Begun(program, kernel, request, self.backend)
        try:
            run._open(t)
            return lead(self.program, self.kernel, run, t)
        finally:
            run.close()
