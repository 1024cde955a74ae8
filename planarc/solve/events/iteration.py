"""Events: what switches at an instant, and what follows from it.

Between events the truth of every relation is stored in the workspace and does not
change. At an event the equations are iterated at one instant of time:

    1  relations that cross zero here get the truth that lies in the direction of the
       crossing; all others are taken from the sign of their zero function (`crossings`)
    2  continuous and discrete equations are evaluated, actions of when-clauses assign,
       until nothing changes (`settling`)
    3  the actions of conditions that just became true reinitialize, assert, terminate
       (`whens`)
    4  pre-values become the present values; again from 1 while anything changed
    5  a relation at zero takes the truth that it has right after this instant

The last step is what a bouncing ball needs: its `h <= 0` becomes true, the velocity
is reversed, and right after the instant `h <= 0` is false. Where that turns the motion
again, as in a sliding mode, the relation is turned back and left to the next event.

Reference: Modelica 3.6, section 8.6 and appendix B.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, TypeAlias

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import INITIAL, LARGEST_INTEGER, LEFT, TERMINAL, Kind
from planarc.ir.expr import Expr
from planarc.ir.kernel import Copier, Kernel, Reactions, copier
from planarc.ir.once import once
from planarc.ir.program import DiscreteSlot, Let, ParameterSlot, Program
from planarc.solve.events.crossings import Crossings
from planarc.solve.events.instants import TimeFunction, known_functions
from planarc.solve.events.snapshot import (
    LAST_ITERATIONS,
    Snapshot,
    changed_numbers,
    most_iterations,
    snapshot,
)
from planarc.solve.events.whens import Processed, Whens
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.settings import Request

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.solve.contact.impacts import Impacts

Integers: TypeAlias = "tuple[tuple[str, ...], NDArray[np.intp]]"


class Events:
    """The discrete part of a run. All its values live in the kernel's workspace."""

    def __init__(self, program: Program, kernel: Kernel, request: Request, rescue: Rescue) -> None:
        self.program, self.kernel, self._rescue = program, kernel, rescue
        self.present = program.switches
        self.crossings = Crossings(program, kernel, request.span)
        self._request = request
        # What is wrong with an impact is told before the start.
        self.touches = _of_touches(program, self._whens) if program.whens else frozenset[int]()
        self.crossings.touches = self.touches
        self._remember, self._integers = _discrete(program)
        self._lefts = lefts(program)
        self._ticks: dict[int, str] = {}  # causes, by the samplers that have fired

    @cached_property
    def _whens(self) -> Whens:
        return Whens(self.program, self.kernel, self._request)

    # The start

    def state(self) -> Snapshot:
        """Truths and discrete values."""
        return self._snapshot()

    def undefined(self, t: float) -> Diagnostic | None:
        """The refusal of a discrete variable that is no number, if there is one."""
        from planarc.solve.messages.event import undefined

        values = {d.name: float(self.kernel.w[d.slot]) for d in self.program.discretes}
        return undefined(self.program, t, values)

    def changed(self, before: Snapshot) -> list[int]:
        """The slots of numbers that have other values now; none where anything else has."""
        return changed_numbers(self.program, before, self._snapshot())

    def rests(self, before: Snapshot, closed: Mapping[int, float]) -> bool:
        """Whether a pass has left all as it was, but for rounding of the numbers of a loop, which
        are put back."""
        from planarc.solve.events.closure import same_number

        w = self.kernel.w
        for slot, value in closed.items():
            if same_number(w[slot], value):
                w[slot] = value
        return self._snapshot() == before

    def begin(self, t: float) -> None:
        """Everything discrete before anything is solved: start values, then what follows
        from these, from time and from parameters. Relations of unknowns count as false."""
        w, program = self.kernel.w, self.program
        self.crossings.begin(t)
        for d in program.discretes:
            w[d.slot] = w[d.pre] = w[d.start]
        self._set_flag(INITIAL, True)
        known = known_functions(program, self.kernel)
        self._take_known(known, t)
        w[0] = t
        for _ in program.discretes:
            before = self._snapshot()
            if self.kernel.discrete() != 0:
                for d in program.discretes:  # has no value before the unknowns have
                    w[d.slot] = w[d.start]
                return
            self._take_known(known, t)
            if self._snapshot() == before:
                return

    def _take_known(self, known: Mapping[int, TimeFunction], t: float) -> None:
        for i, zero in known.items():
            g = zero(t)
            if g is not None:
                self.crossings.now[i] = g
                self.kernel.w[self.program.relations[i].slot] = float(self.crossings.sign(i))

    def settle_start(self, t: float, y: Sequence[float]) -> bool:
        """One pass at the start; true when it changed something, so that the start values
        must be solved for once more."""
        before = self._snapshot()
        flag = self.crossings.evaluate(t, y)
        if flag < 0:
            from planarc.solve.messages.event import unsolved

            block, found = self.kernel.failed_block, unsolved(self.program, self.kernel, t, ())
            raise PlanarcError(self._rescue.told(found, t, block))
        if flag == 0:
            truths = self.crossings.truths_at_start(t, y)
            for relation, truth in zip(self.program.relations, truths, strict=True):
                self.kernel.w[relation.slot] = float(truth)
        self.kernel.outputs(t, y)
        self.kernel.discrete()
        self._whens.assign(t, self._whens.edges(initial=True))
        return self._snapshot() != before

    def finish_start(self, t: float, y: Sequence[float], states: Mapping[int, int]) -> Processed:
        """Actions that were to run at the start; then everything is its own left limit."""
        done = Processed(list(y))
        self._refuse_inexact(t, done, _given_integers(self.program))
        if not self.present:
            self._set_flag(INITIAL, False)
            return done
        whens = self._whens
        done.ended = done.ended or whens.assign(t, whens.edges(initial=True))
        edges = whens.edges(initial=True)
        whens.act(t, edges, done, {})
        whens.strike(t, edges, done, states)
        self._refuse_inexact(t, done, self._integers)
        self._keep_pre()
        self._set_flag(INITIAL, False)
        self.crossings.begin(t)
        return done

    # An event

    def process(
        self,
        t: float,
        y: Sequence[float],
        crossing: Mapping[int, bool],
        samples: Sequence[int],
        states: Mapping[int, int],
        ahead: bool = True,
    ) -> Processed:
        """`crossing`: relation -> truth from here on. `states`: slot -> index in y. Without
        `ahead`, relations at zero keep the truth of this instant (the first row shows it)."""
        from planarc.solve.events.settling import Settling

        if self._lefts:
            self._look_back(t, y)
        quick = self._reacted(t, y, crossing, samples, states, ahead)
        if quick is not None:
            return quick
        w, program, done = self.kernel.w, self.program, Processed(list(y))
        self.crossings.forget_noise()
        flag = self._evaluate(t, done.y)
        before = list(self.crossings.now)
        fired = [program.samplers[i][0] for i in samples]
        for slot in fired:
            w[slot] = 1.0
        for i, truth in crossing.items():
            w[program.relations[i].slot] = float(truth)
        if fired or crossing:
            flag = self._evaluate(t, done.y)
        settling = Settling(self.crossings, self._whens, self._rescue, t, done, crossing, before)
        if flag != 0:
            settling.failed()
            return done
        trail: deque[Snapshot] = deque(maxlen=LAST_ITERATIONS)
        moved = False
        for _ in range(most_iterations(program)):
            earlier = self._snapshot()
            trail.append(earlier)
            if not settling.settle(moved, earlier):
                return done
            edges = self._whens.edges()
            moved = self._whens.act(t, edges, done, states)
            moved |= self._whens.strike(t, edges, done, states)
            self._keep_pre()
            for slot in fired:
                w[slot] = 0.0
            fired_now, fired = bool(fired), []
            if done.ended is not None:
                break
            if moved or fired_now or self._snapshot() != earlier:
                continue
            if not (ahead and settling.look_ahead()):
                break
        else:
            settling.endless(trail)
        if self._rescue.overcome(t, lambda: self.kernel.outputs(t, done.y)) != 0:
            settling.failed()
        self.crossings.leave(settling.doubtful)
        self._refuse_inexact(t, done, self._integers)
        return done

    def _look_back(self, t: float, y: Sequence[float]) -> None:
        """What is asked for left limits takes the values before the event."""
        w, read = self.kernel.w, self._whens.reader(t)
        if self.kernel.outputs(t, y) != 0:
            return
        for slot, pre, value in self._lefts:
            w[slot] = w[pre] = float(read(value))

    @cached_property
    def _reactions(self) -> Reactions | None:
        """The same iteration in machine code."""
        stepping = self._request.stepping
        found = None if stepping else self.kernel.capabilities.reacting().reactions
        if found is not None:
            found.prepare(self._request.span, self._request.tolerance)
        return found

    def _reacted(
        self,
        t: float,
        y: Sequence[float],
        crossing: Mapping[int, bool],
        samples: Sequence[int],
        states: Mapping[int, int],
        ahead: bool,
    ) -> Processed | None:
        """An event that machine code iterates; None where that is left to this module."""
        if self._reactions is None:
            return None
        w: Any = self.kernel.w
        impacts, crossings = self._whens.impacts, self.crossings
        relations = self.program.relations
        if any((w[relations[i].slot] != 0) == truth for i, truth in crossing.items()):
            return None
        known = None if impacts is None else impacts.known(t)
        if impacts is not None and known is None:
            return None
        before = w.copy()
        w[0] = t
        found = self._reactions.react(
            y, crossing, samples, crossings.largest, crossings.leaping_at(t), ahead, known
        )
        if found is None:
            w[:] = before
            return None
        crossings.take(t, found.now, found.largest, found.doubtful)
        done = Processed(found.y)
        if found.reset:
            reset = {slot for slot, k in states.items() if k in found.reset}
            done.reset += [c.display for c in self.program.candidates if c.slot in reset]
        if impacts is not None and found.known is not None:
            done.told += impacts.take(found.known, found.struck)
        self._refuse_inexact(t, done, self._integers)
        return done

    def _refuse_inexact(self, t: float, done: Processed, integers: Integers) -> None:
        """End the run where an Integer is no longer exact."""
        names, slots = integers
        if done.ended is not None or not names:
            return
        w: Any = self.kernel.w
        if isinstance(w, list):
            values = [w[slot] for slot in slots.tolist()]
        else:
            values = w.take(slots).tolist()
        if max(values) > LARGEST_INTEGER or min(values) < -LARGEST_INTEGER:
            from planarc.solve.messages.event import inexact_integer

            pairs = zip(names, values, strict=True)
            name, value = next(pair for pair in pairs if abs(pair[1]) > LARGEST_INTEGER)
            done.ended = inexact_integer(self.program, t, name, float(value))

    def _evaluate(self, t: float, y: Sequence[float]) -> int:
        return self._rescue.overcome(t, lambda: self.crossings.evaluate(t, y))

    def causes(self, crossing: Iterable[int], samples: Iterable[int]) -> tuple[str, ...]:
        """The causes of an event, as texts."""
        texts = [self.program.relations[i].text for i in crossing]
        return (*texts, *map(self._tick, samples))

    def _tick(self, i: int) -> str:
        """What a sampler is called: its ticks are known before a run."""
        if i not in self._ticks:
            from planarc.solve.messages.event import ticked

            self._ticks[i] = ticked(self.program, self._whens.reader(0.0), i)
        return self._ticks[i]

    def owners(self, crossing: Iterable[int]) -> tuple[str, ...]:
        """The components of relations."""
        return tuple(self.program.relations[i].component for i in crossing)

    def sharpness(self) -> float:
        """The part of the tolerance with which the run goes on: low bounces ask for less."""
        impacts = self._whens.impacts if self.present else None
        return 1.0 if impacts is None else impacts.sharpness

    @property
    def impacts(self) -> Impacts | None:
        return self._whens.impacts

    def others(
        self, causes: Sequence[str], owners: Sequence[str]
    ) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The causes that are not relations of touches, and their components."""
        if not self.touches:
            return tuple(causes), tuple(owners)
        own = {self.program.relations[i].component for i in self.touches}
        pairs = [p for p in zip_longest(causes, owners, fillvalue="") if p[1] not in own]
        return tuple(c for c, _ in pairs), tuple(o for _, o in pairs)

    def finish(self) -> bool:
        """Whether anything may happen at the end."""
        self._set_flag(TERMINAL, True)
        return self.present or self.program.table.knows(TERMINAL)

    # Bookkeeping

    def _snapshot(self) -> Snapshot:
        return snapshot(self.program, self.kernel)

    def _keep_pre(self) -> None:
        self._remember(self.kernel.w)

    def _set_flag(self, name: str, value: bool) -> None:
        slot = self.program.slots.get(name)
        if slot is not None:
            self.kernel.w[slot] = float(value)


def _of_touches(program: Program, whens: Whens) -> frozenset[int]:
    """The relations of touches."""
    own = whens.impacts.components if whens.impacts is not None else ()
    return (
        frozenset(i for i, r in enumerate(program.relations) if r.component in own)
        if own
        else (frozenset())
    )


@once
def lefts(program: Program) -> tuple[tuple[int, int, Expr], ...]:
    """The slots of discrete variables that follow continuous ones, those of their left limits, and
    what they follow."""
    values = {s.target: s.value for s in program.discrete if isinstance(s, Let)}
    followed = (d for d in program.discretes if d.name.startswith(f"{LEFT}["))
    return tuple((d.slot, d.pre, values[program.table.symbol(d.name)]) for d in followed)


@once
def _discrete(program: Program) -> tuple[Copier, Integers]:
    """What makes discrete values their own left limits; and the Integers among them."""
    found = program.discretes
    return copier([d.pre for d in found], [d.slot for d in found]), _integers(found)


@once
def _given_integers(program: Program) -> Integers:
    return _integers(program.parameter_slots)


def _integers(slots: Iterable[DiscreteSlot | ParameterSlot]) -> Integers:
    """The names of Integers, and their slots."""
    import numpy as np

    found = [s for s in slots if s.kind is Kind.INTEGER]
    return tuple(s.name for s in found), np.array([s.slot for s in found], np.intp)
