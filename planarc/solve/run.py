"""A run: from parameters and start values to rows over time.

In:   Program, Kernel, Request
Out:  Result

    workspace  parameters, what depends on them, and start values (`opened`)
    start      consistent positions and velocities, and the first states
    march      the integrator goes to the next instant known beforehand, or to the
               first root of a relation, or for a while; rows are taken on the way
    event      rows before and after; what switched is settled; the integrator restarts
    exchange   of states where the present ones go bad; the integrator restarts

The parts of a run stand in `bench`, its start in `begun`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from planarc.ir.expr import Expr, Op
from planarc.ir.result import EventRecord, Result, Statistics
from planarc.solve.begun import Begun
from planarc.solve.effort import Pace, runs_away
from planarc.solve.events.chatter import CHATTER_TIME
from planarc.solve.events.delays import jumped
from planarc.solve.events.instants import room, same
from planarc.solve.recorder import constants
from planarc.solve.solvers.integrator import Cause, March, Outcome

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

Progress = Callable[[float], None]

#: Failures of an integrator behind which the solution of a block may end, and the part of the run
#: within which it does.
LEAPING, FURTHEST = (Cause.BLOCK, Cause.CONVERGENCE, Cause.ERROR_TEST), 1e-6
#: Solutions in a row, each of which ends at once, that are none to go on from.
MOST_LEAPS = 3


class Run(Begun):
    """One run under way."""

    # On the way

    def go(self, progress: Progress | None) -> None:
        if progress is not None:
            progress(self.request.start)
        self.march_to(self.request.stop, progress)
        if self.ended is None:
            self._finish()

    def march_to(self, end: float, progress: Progress | None = None) -> None:
        """Go to a time, not after the stop time, through all events on the way."""
        effort = self.effort
        while self.ended is None and not same(self.integrator.t, end):
            limit = min(self.schedule.next(t := self.integrator.t), self.delays.next(t), end)
            if same(limit, end):
                limit = end
            march = self.integrator.march(limit, self.recorder, self.states.watch, effort.steps)
            way = effort.take(self.integrator.t, march.steps)
            if progress is not None:
                progress(self.integrator.t)
            if self.interruption.asked:
                raise KeyboardInterrupt
            self._check_asserts(march.outcome is Outcome.FAILED)
            if self.ended is None:
                self._check_values()
            if self.ended is not None:
                return
            if self.delays.trouble is not None:
                self.ended = self.delays.trouble
            elif march.outcome is Outcome.FAILED:
                self._rescue(march)
                effort.restart()
            elif self._happens(march):
                effort.restart()
            elif march.outcome is Outcome.LOOK:
                step = self.integrator.last_step()
                self._follow(self.states.look(self.integrator.t, self.integrator.y, step))
            if way is not None and self.ended is None and march.outcome is not Outcome.LIMIT:
                self._judge(way)
        if self.ended is not None:  # what a row before has broken comes first
            self._check_asserts(True)

    def _judge(self, way: float) -> None:
        """End a run that creeps, and note what one may warn of."""
        t, y, tolerance = self.integrator.t, self.integrator.y, self.request.tolerance
        pace = self.effort.pace(way)
        away = pace is Pace.ABSURD and runs_away(self.program, self.states.selection, y)
        if pace is Pace.CREEPING or away:  # it may be up to where a solution ends
            if not away and self._leap(t, y, self.kernel.outputs(t, y) == 0):
                self.effort.restart()
                return
            self.ended = self._stopped(t, y, Cause.STEP, way=way)
        elif pace is not Pace.ORDINARY and self.request.fixed_step is None:
            from planarc.solve.messages.labour import Labour, Stretch

            absolute = self.states.absolute(tolerance)
            sizes = [a + tolerance * abs(v) for a, v in zip(absolute, y, strict=True)]
            names = [self.program.candidates[i].display for i in self.states.selection]
            self.labour = self.labour or Labour(self.program, self.kernel, self.request.span)
            stretch = Stretch(t - way, t, names, y, sizes, pace is Pace.ABSURD)
            self.ended = self.labour.note(stretch)

    def _rescue(self, march: March) -> None:
        """The integrator failed: other states may help, else the run ends here."""
        if self.integrator.trouble is not None:
            self.ended = self.integrator.trouble
            return
        t, y, block = self.integrator.t, self.integrator.y, self.kernel.failed_block
        if march.cause is Cause.POLE:  # rows behind it are none
            self.recorder.cut(int((self.recorder.rows()[0] <= t).sum()))
            self.asserts.forget(self.recorder.count)
        whole = self.kernel.outputs(t, y) == 0
        decision = self.states.rescue(t) if whole and march.cause is not Cause.POLE else None
        if decision is None and march.cause in LEAPING and self._leap(t, y, whole):
            return
        self._follow(decision or self._stopped(t, y, march.cause, block))

    def _leap(self, t: float, y: Sequence[float], whole: bool) -> bool:
        """Go on from another solution of a block whose present one ends here, as after an event;
        `whole`: it still has one at this very point."""
        if whole:
            self._row(t, y)
            self.kernel.accept(t)
        furthest = (FURTHEST if y else 1.0) * self.request.span
        from planarc.solve.rescue.fold import leap

        found = leap(self.rescue, t, y, 4 * room(t), furthest)
        if found is None:
            self.recorder.cut(self.recorder.count - whole)
            return False
        if self._leaps and t - self._leaps[-1][0] > CHATTER_TIME * self.request.span:
            self._leaps.clear()
        self._leaps.append((t, self.recorder.count))
        if len(self._leaps) > MOST_LEAPS:  # each solution ends where the one before did
            self.recorder.cut(self._leaps[0][1])
            self.rescue.forget()
            return False
        self._process(*found, {}, [], self.rescue.leapt)
        return True

    def _happens(self, march: March) -> bool:
        """Treat the event at the time reached, if there is one."""
        t, stop = self.integrator.t, self.request.stop
        if self.events.present:
            if self._is_met(march):
                return True
        elif march.outcome in (Outcome.BUDGET, Outcome.LOOK):
            return False
        if self.delays.present and same(self.delays.next(t - 4 * room(t)), t):
            self._come_back(t)
            return True
        if march.outcome is Outcome.LIMIT and t >= stop:
            self._row(t, self.integrator.y)
        return False

    def _is_met(self, march: March) -> bool:
        """Treat what switches or is fired at the time reached, if anything does."""
        t, stop = self.integrator.t, self.request.stop
        crossing = self._crossings(march)
        known = self.schedule.next(t - 4 * room(t))
        if same(known, t):
            t = stop if same(known, stop) else known
            truths = self.events.crossings.truths()  # steps may be shorter than an instant
            switching = self.schedule.switching(t).items()
            crossing |= {i: truth for i, truth in switching if truth != truths[i]}
        fired = self.schedule.firing(t)
        if not crossing and march.outcome is not Outcome.ROOT:
            crossing = self.events.crossings.missed(t, self.integrator.y)
            self._chatter.found_late(t, crossing)
        if crossing or fired:
            self._event(t, crossing, fired)
            return True
        if march.outcome is Outcome.ROOT:
            self.ended = self._chatter.vain(t, march.directions)
            # A step that is lost in the digits of the time would meet the same root again.
            step = self._chatter.step or self.integrator.last_step()
            self.restart(t, self.integrator.y, max(step, room(t)))
            return True
        return False

    def _crossings(self, march: March) -> dict[int, bool]:
        """Relations that switch here, and the truth that each takes."""
        if march.outcome is not Outcome.ROOT:
            return {}
        t, crossings = self.integrator.t, self.events.crossings
        rises = crossings.rises(t, self.integrator.y)
        crossing = crossings.real(march.directions, rises, t, self.integrator.y)
        if rises is not None:
            self._chatter.note(t, crossing, rises)
        return crossing

    def _event(self, t: float, crossing: dict[int, bool], fired: list[int]) -> None:
        y = self.integrator.y
        if self._row(t, y):
            owners = self.events.owners(crossing)
            self._process(t, y, crossing, fired, self.events.causes(crossing, fired), owners)

    def _process(
        self,
        t: float,
        y: Sequence[float],
        crossing: dict[int, bool],
        fired: list[int],
        causes: tuple[str, ...],
        owners: tuple[str, ...] = (),
    ) -> None:
        """Settle what happens at an instant, of which the row before is taken, and restart."""
        self.kernel.accept(t)
        self.delays.cross(t)
        self.delays.kink(t)
        before = self._jumps.values()
        done = self.events.process(t, y, crossing, fired, self.states.slots())
        if crossing and done.ended is None:
            self._passed.note(t, done.y, crossing, done.reset, y)
        self._already.note()
        others, own = self.events.others(causes, owners)
        if done.told or others or not causes:
            own = ("",) * len(done.told) + own
            self.records.append(EventRecord(t, (*done.told, *others), own))
        self._note(done.ended, done.warnings)
        if self._row(t, done.y):
            self.recorder.pass_by(t)
            if (crossing or fired) and not done.reset:
                after = self._unstruck(t, y, done.y, bool(others))
                self.warnings += self._jumps.judge(t, before, after or before)
            chattering = self._chatter.judge(t, crossing, others if not fired else ())
            self.ended = self.ended or chattering
            self.restart(t, done.y, self._chatter.step)
            self._follow(self.states.after_event(t))
        self._check_asserts(self.ended is not None)

    def _unstruck(
        self, t: float, y: Sequence[float], struck: Sequence[float], switched: bool
    ) -> list[float]:
        """What is watched for jumps, behind an event, as if it had left the states as they were;
        nothing where impacts alone changed them."""
        if list(y) == list(struck):
            return self._jumps.values()
        if not switched or self.kernel.outputs(t, y) != 0:
            return []
        found = self._jumps.values()
        self.kernel.outputs(t, struck)
        return found

    def _come_back(self, t: float) -> None:
        """What was a kink of a delayed signal is one of the delay now: an event where the
        delay jumps, or where a relation switches."""
        y, before, truths = self.integrator.y, self.delays.values(t), self.events.crossings.truths()
        if not self._row(t, y):
            return
        self.kernel.accept(t)
        generation = self.delays.cross(t)
        jumps = jumped(before, self.delays.values(t))
        if self.events.present:
            done = self.events.process(t, y, {}, (), self.states.slots())
            self._note(done.ended, done.warnings)
            y = done.y
        switched = [
            i for i, truth in enumerate(self.events.crossings.truths()) if truth != truths[i]
        ]
        if jumps or switched:
            causes = (*self.delays.texts(jumps), *self.events.causes(switched, ()))
            self.records.append(EventRecord(t, causes))
            self._row(t, y)
            self.recorder.pass_by(t)
        elif t < self.request.stop:
            self.recorder.cut(self.recorder.count - 1)
        self.delays.kink(t, 0 if jumps or switched else (generation or 0) + 1)
        self.restart(t, y)

    # Step by step

    def take_inputs(self) -> None:
        """Go on from here with other inputs, which stand in the workspace already."""
        t, y = self.integrator.t, self.integrator.y
        if not self.events.present:
            self.restart(t, y)
        elif self._row(t, y):
            self._process(t, y, self.events.crossings.missed(t, y), [], ())

    def stand(self) -> None:
        """Fill the workspace for the instant reached, and look at assertions."""
        if self._row(self.integrator.t, self.integrator.y):
            self._check_asserts(True)

    def forget_rows(self) -> None:
        """Keep the last row alone, and go on as after an event: nothing leads back behind it."""
        self.recorder.keep_last()
        self.asserts.forget(self.recorder.count)
        self.records.clear()
        self.restart(self.integrator.t, self.integrator.y, self.integrator.last_step())

    def go_back(self, t: float, y: Sequence[float], selection: Sequence[int]) -> None:
        """Go on from an earlier instant, of which the workspace holds all values."""
        self.ended = None
        self.recorder.cut(0)
        self.asserts.forget(0)
        self.records.clear()
        self._chatter.forget()
        self.states.take(selection)
        self.kernel.accept(t)
        self.restart(t, y)
        self.stand()

    # The end

    def _finish(self) -> None:
        self._check_asserts(True)
        if self.ended is not None:
            return
        self.warnings += self._passed.judge(self.integrator.t, self.integrator.y)
        self.warnings += self._already.judge()
        self._judge_shares()
        if self.events.finish():  # nothing comes after it
            t, y = self.integrator.t, self.integrator.y
            done = self.events.process(t, y, {}, (), self.states.slots(), ahead=False)
            self._note(done.ended, done.warnings)
            self._row_where_new(t, done.y)

    def _judge_shares(self) -> None:
        """Note contacts at rest whose forces are not determined."""
        t, y = self.integrator.t, self.integrator.y
        impacts = self.events.impacts if self.events.touches else None
        if impacts is None or self.kernel.outputs(t, y) != 0:
            return
        from planarc.solve.contact.shares import judge_shares

        self.warnings += judge_shares(impacts.touches, t, y, self.states.slots())

    def _warn_of_poles(self, times: Vector, data: Vector) -> None:
        from planarc.solve.messages.poles import stepped_over

        stored, slots, w = self.recorder.stored, self.program.slots, self.kernel.w

        def column(e: Expr) -> Vector | float:
            slot = slots.get(repr(e), -1)
            at = stored.get(slot)
            return times if e.op is Op.TIME else float(w[slot]) if at is None else data[:, at]

        self.warnings.extend(stepped_over(self.program, times, column))

    def _warn_of_faint_states(self, data: Vector) -> None:
        from planarc.solve.messages.faint import judge_faint

        w, stored = self.kernel.w, self.recorder.stored
        sizes = self.states.absolute(self.request.tolerance)
        states = dict(zip(self.states.selection, sizes, strict=True))
        self.warnings += judge_faint(self.program, states, w, stored, data)

    def result(self) -> Result:
        self.warnings.extend(self.rescue.notes.values())
        self.warnings.extend(self.asserts.warnings())
        if self.labour is not None and (found := self.labour.warning()) is not None:
            self.warnings.append(found)
        times, data = self.recorder.rows()
        w = self.kernel.w
        if self.ended is None and self.program.mechanism is None:
            self._warn_of_poles(times, data)
        if self.ended is None and self.request.fixed_step is None:  # no tolerance holds the latter
            self._warn_of_faint_states(data)
        counts = self.integrator.counts()
        if self.program.sharing is not None and self.ended is None:
            from planarc.solve.start import sharing

            stored = self.recorder.stored
            self.ended = sharing.misfit(
                self.program,
                self.kernel,
                times,
                lambda slot: data[:, stored[slot]] if slot in stored else w[slot] + 0 * times,
            )
        return Result(
            program=self.program,
            time=times,
            data=data,
            stored=self.recorder.stored,
            constants=constants(self.program, self.kernel),
            statistics=Statistics(
                solver=self.integrator.name,
                backend=self.backend,
                steps=counts.steps,
                rhs_calls=counts.rhs_calls,
                jacobians=counts.jacobians,
                error_test_failures=counts.error_test_failures,
                events=len(self.records),
                reason=self.reason + ", Jacobian from formulas" * self.integrator.formulas,
            ),
            states=tuple(self.states.choices),
            held=self.held,
            events=tuple(self.records),
            warnings=tuple(self.warnings),
            ended=self.ended,
            near_singular=self.kernel.near_singular,
        )
