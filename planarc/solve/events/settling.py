"""One instant of an event: truths and discrete values iterated until they rest.

In:   Crossings, Whens, the states, and the relations that cross zero here
Out:  stored truths and discrete values that agree with the equations

Relations that cross zero here are held at the truth of their crossing's direction until
what they compare is changed at this instant; all others follow the sign of their zero
function, unless this is a number from integration that is zero to rounding.

Relations inside of an algebraic loop (friction that sticks or slides) can chase each
other. When a state of the iteration comes back, first only those that want to become false
do so; when one comes back again, all choices of the restless ones are tried, the nearest
to the present one first.

Reference: Modelica 3.6, appendix B; for friction: M. Otter, H. Elmqvist, S. E. Mattsson,
           Hybrid modeling in Modelica based on the synchronous data flow principle, CACSD 1999.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from planarc.solve.events.closure import close_loop, same_number
from planarc.solve.events.crossings import EXACT, NOISE, Crossings
from planarc.solve.events.snapshot import (
    LAST_ITERATIONS,
    MOST_ITERATIONS,
    Snapshot,
    changed_numbers,
    most_iterations,
    snapshot,
)
from planarc.solve.events.whens import Processed, Whens
from planarc.solve.rescue.rescue import Rescue

#: Passes after which a loop of numbers is not left to come to rest by itself. One that comes back
#: to where it was never does.
PATIENCE = 12
#: Relations of which all choices are tried when they chase each other.
MOST_SEARCHED = 10
#: Instants of crossings are found so exactly that a function is this part of its largest
#: value there, at most.
NEAR = 1e-9
#: How exactly truths are to agree with their equations, tried in turn: to rounding, as instants are
#: found, and to what states err by. A clutch that slips back by as much before it can slide neither
#: holds nor slides for an instant.
EXACTLY = (0.0, NEAR, 1e-5)

#: How often a relation may turn ahead at one instant: the second time it was turned back.
MOST_TURNS = 2
#: What reaches zero within this part of the time that `rises` looks ahead is at zero.
SOON = 1e-7


class Settling:
    """The iteration at one instant. Problems are told in `done`.

    `held` are the relations that keep their truth as long as their zero function is not
    above `bound`, and the values of these functions. `before` are the values from integration.
    """

    def __init__(
        self,
        crossings: Crossings,
        whens: Whens,
        rescue: Rescue,
        t: float,
        done: Processed,
        crossing: Mapping[int, bool],
        before: Sequence[float],
    ) -> None:
        self.program, self.kernel = crossings.program, crossings.kernel
        self.crossings, self.whens, self._rescue = crossings, whens, rescue
        self.t, self.done = t, done
        now, largest = crossings.now, crossings.largest
        self.held = {i: now[i] for i in crossing}
        self.bound = {i: 2 * abs(now[i]) + NOISE * largest[i] for i in crossing}
        # Seen after it had crossed: it turns back only where an action makes it.
        self._late = {i for i in crossing if abs(now[i]) > 1e3 * NOISE * largest[i]}
        self._before, self._known_noise = before, [0.0][:0]
        self._turned: Counter[int] = Counter()
        self._searching = False
        self._inexact: list[int] = []  # of which no choice agreed but to near zero
        self._closed: dict[int, float] = {}  # numbers of a loop, as a pass leaves them

    @property
    def doubtful(self) -> list[int]:
        """Relations of which neither truth agreed."""
        return [*self._inexact, *(i for i, times in self._turned.items() if times >= MOST_TURNS)]

    def settle(self, moved: bool, now: Snapshot) -> bool:
        """Iterate with fixed pre-values until nothing changes; false where that fails.

        `moved`: states were set anew, and with these what held relations compare. `now` is what
        the workspace holds.
        """
        seen: set[Snapshot] = set()
        careful = False
        restless: set[int] = set()
        trail: deque[Snapshot] = deque(maxlen=LAST_ITERATIONS)
        for count in range(most_iterations(self.program)):
            before = now
            trail.append(before)
            if not self._evaluate():
                return False
            if moved:
                moved = False
                self._release()
            restless |= self._take_signs(careful)
            now = snapshot(self.program, self.kernel)
            if now == before:
                return True
            loop = changed_numbers(self.program, before, now)
            if loop and (count >= PATIENCE or now in seen):
                w = self.kernel.w
                if not close_loop(w, loop, self._evaluate):
                    return self.done.ended is None and self.endless([*trail, now])
                self._closed = {slot: w[slot] for slot in loop}
                now = snapshot(self.program, self.kernel)
            elif now in seen:
                if careful:
                    return self._search(sorted(restless), trail)
                careful = True
                seen.clear()
                restless.clear()
            seen.add(now)
        return self.endless(trail)

    def endless(self, trail: Iterable[Snapshot]) -> bool:
        """The iteration ends without rest: the values that changed in it are named."""
        from planarc.solve.messages.event import endless

        values = (*trail, snapshot(self.program, self.kernel))
        self.done.ended = endless(self.program, self.t, values)
        return False

    def failed(self) -> bool:
        """The equations have no solution here."""
        from planarc.solve.messages.event import unsolved

        program, kernel, done = self.program, self.kernel, self.done
        block = kernel.failed_block
        found = unsolved(program, kernel, self.t, done.reset)
        done.ended = self._rescue.told(found, self.t, block)
        return False

    def _evaluate(self) -> bool:
        """The equations and the zero functions with the stored truths as they are."""
        t, y = self.t, self.done.y
        self._known_noise = []
        if self._outputs() != 0 or self.kernel.discrete() < 0:
            return self.failed()
        problem = self.whens.assign(t, self.whens.edges())
        if problem is not None:
            self.done.ended = problem
            return False
        for slot, value in self._closed.items():
            if same_number(self.kernel.w[slot], value):
                self.kernel.w[slot] = value
        return self.crossings.evaluate(t, y) == 0 or self.failed()

    def _outputs(self) -> int:
        """The kernel's flag; of many choices each is tried without help."""
        call = partial(self.kernel.outputs, self.t, self.done.y)
        return call() if self._searching else self._rescue.overcome(self.t, call)

    def _search(self, restless: Sequence[int], trail: Iterable[Snapshot]) -> bool:
        """Try all truths of the restless relations until one agrees with its own equations.

        Where none does to rounding, one counts that does less exactly.
        """
        w, relations, self._searching = self.kernel.w, self.program.relations, True
        slots = [relations[i].slot for i in restless[:MOST_SEARCHED]]
        present = [w[s] for s in slots]
        choices = sorted(range(2 ** len(slots)), key=lambda n: (n.bit_count(), n))
        for flips, near in ((f, near) for near in EXACTLY for f in choices):
            for k, (slot, value) in enumerate(zip(slots, present, strict=True)):
                w[slot] = 1.0 - value if flips >> k & 1 else value
            if self._agrees(near):
                self._searching = False
                self._inexact = [*restless] if near else []
                return True
        return self.endless(trail)

    def _agrees(self, near: float) -> bool:
        """Whether the truths as they are follow from their own equations."""
        for _ in range(MOST_ITERATIONS):  # discrete equations follow the truths
            before = snapshot(self.program, self.kernel)
            if not self._evaluate():
                self.done.ended = None  # no solution here; another choice may have one
                return False
            if snapshot(self.program, self.kernel) == before:
                self._hold_near(near)
                return not self._take_signs(False)
        return False

    def _hold_near(self, near: float) -> None:
        """Relations that are as good as zero keep their truth."""
        for i, relation in enumerate(self.program.relations):
            size = abs(self.crossings.now[i])
            if size <= near * max(1.0, self.crossings.largest[i]) and not relation.time_only:
                self.held[i], self.bound[i] = self.crossings.now[i], 2 * size

    def _take_signs(self, careful: bool) -> set[int]:
        """Truth from the zero functions, but not for those that are at zero here; gives those
        that changed. `careful`: none becomes true while another one becomes false."""
        w, crossings = self.kernel.w, self.crossings
        wanted: dict[int, bool] = {}
        for i, relation in enumerate(self.program.relations):
            truth = crossings.sign(i)
            if i in self.held:
                if abs(crossings.now[i]) <= self.bound[i]:
                    continue
                del self.held[i]
            if truth != (w[relation.slot] != 0) and (relation.time_only or self._is_clear(i)):
                wanted[i] = truth
        if careful and not all(wanted.values()):
            wanted = {i: truth for i, truth in wanted.items() if not truth}
        for i, truth in wanted.items():
            w[self.program.relations[i].slot] = float(truth)
        return set(wanted)

    def _is_clear(self, i: int) -> bool:
        """Whether the value of a zero function is more than an error of rounding. One that
        was changed at this instant is known better than one that was integrated."""
        now, largest = self.crossings.now[i], self.crossings.largest[i]
        if i in self.crossings.touches:
            return now >= 0.0 or -now > NOISE * largest
        if abs(now) <= EXACT or abs(now) > max(self.crossings.quiet(), NOISE * largest):
            return True
        noise = self._noise()[i]
        least = noise if abs(now - self._before[i]) > noise else max(noise, NOISE * largest)
        return abs(now) > least

    def _noise(self) -> list[float]:
        if not self._known_noise:
            self._known_noise = self.crossings.noise(self.t, self.done.y)
        return self._known_noise

    def _release(self) -> None:
        """Hold no relation any more of which a side was set anew."""
        now = self.crossings.now
        for i, value in list(self.held.items()):
            if now[i] == value:
                continue
            if i in self.crossings.touches or abs(now[i] - value) > self._noise()[i]:
                del self.held[i]

    def look_ahead(self) -> bool:
        """Relations at zero take their truth right after this instant; true if one changed."""
        w, relations, crossings = self.kernel.w, self.program.relations, self.crossings
        rest = [NOISE * size for size in crossings.largest]
        for i, bound in self.bound.items():
            if i not in self._late or self.done.reset:
                rest[i] = bound
        near = [
            i
            for i, now in enumerate(crossings.now)
            if self._turned[i] < MOST_TURNS and abs(now) <= max(rest[i], NOISE)
        ]
        least = [1e-4 * NOISE * size for size in crossings.largest]
        rises = crossings.rises(self.t, self.done.y) if near else None
        if rises is not None and any(abs(rises[i]) <= least[i] for i in near):
            bent = crossings.rises(self.t, self.done.y, bent=True) or rises
            rises = [b if abs(a) <= c else a for a, b, c in zip(rises, bent, least, strict=True)]
        if rises is None:
            return False
        changed = False
        for i in near:
            if abs(crossings.now[i]) > max(rest[i], SOON * abs(rises[i])):
                continue
            if abs(rises[i]) > least[i]:
                truth = rises[i] < 0
                if truth != (w[relations[i].slot] != 0):
                    w[relations[i].slot] = float(truth)
                    self.held[i], changed = crossings.now[i], True
                    self.bound[i] = max(rest[i], abs(crossings.now[i]))
                    self._turned[i] += 1
        return changed
