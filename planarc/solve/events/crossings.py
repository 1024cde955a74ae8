"""The zero functions of relations: stored truths, and what crosses zero where.

Between events the truth of every relation is stored in the workspace. A relation is
true where its zero function is negative, and, when it is not strict, where it is zero. A
number that comes from integration is known to rounding only: near zero its sign says
nothing, and the direction of the crossing counts. What the equations set at an event is
exact, however small: there the value counts, and zero is zero.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.solve.events.instants import room

if TYPE_CHECKING:
    from planarc.solve.events.rounding import Rounding

#: An integrated zero function below this part of its largest value has no sign.
NOISE = 1e-14
#: One below this, relative to what is solved for, may be nothing but rounding errors of its
#: equations (the torque limit of an open clutch): whether it is, is found out by `noise`.
QUIET = 1e-12
#: What moves by this part of its largest value within a short time may be noise alone.
SUDDEN = 0.01
#: So many times further is looked where a function that was seen to cross seems to stand still.
FURTHER = (8.0, 64.0, 512.0)
#: The part of a run that is looked ahead at its events.
AHEAD = 1e-7
#: The bounds of a single evaluation count so often: integration has added to what states err.
SAFETY = 8.0
#: Where neither truth agreed, an event is tried again so many times further beyond zero: the
#: further off, the more is held for zero there.
FURTHER_OFF = 4.0
#: The side on which a function of noise stands is widened by this factor where noise has crossed
#: again, up to so many times the first width: what goes further has left it.
WIDER, WIDEST = 8.0, 256.0
#: So small are zero functions that stand at zero and say by their sign on which side.
EXACT = 1e-200


class Crossings:
    """`now` are the values of the zero functions where they were evaluated last, `largest`
    the greatest sizes seen in the run, `heard` the greatest noise found since the last event;
    `beyond` are relations that it left beyond zero, since neither truth agreed."""

    def __init__(self, program: Program, kernel: Kernel, span: float) -> None:
        self.program, self.kernel = program, kernel
        self.touches: frozenset[int] = frozenset()  # relations that an operator sets at events
        self.now = [0.0] * len(program.relations)
        self.largest = [0.0] * len(program.relations)
        self._ahead = self._least = AHEAD * (span or 1.0)
        self._later: tuple[float, Sequence[float]] = (0.0, ())  # where `rises` looked last
        self.heard = [0.0] * len(program.relations)
        self.beyond: frozenset[int] = frozenset()
        self._bands: dict[int, float] = {}  # of these, and of those that crossed by noise alone
        self._earlier: tuple[float, list[float]] = (0.0, self.largest)  # sizes before an instant
        self._leaps: Collection[int] = ()  # functions that went across poles there
        self._start = 0.0
        self._unknowns = unknowns(program)

    @cached_property
    def _rounding(self) -> Rounding:
        from planarc.solve.events.rounding import Rounding

        return Rounding(self.program, self.kernel)

    def truths(self) -> list[bool]:
        return [self.kernel.w[r.slot] != 0 for r in self.program.relations]

    def directions(self) -> list[int]:
        """The only way in which each zero function may cross next."""
        return [1 if truth else -1 for truth in self.truths()]

    def forget_noise(self) -> None:
        """What is noise in one mode says nothing of the next one."""
        self.heard = [0.0] * len(self.heard)
        self.beyond = frozenset()
        self._bands.clear()

    def leave(self, doubtful: Iterable[int]) -> None:
        """An event is over in which neither truth of these agreed: beyond zero they cross again,
        but further off."""
        if not (doubtful := frozenset(doubtful)):  # as after nearly all events
            return
        ways = zip(self.directions(), self.now, strict=True)
        past = [i for i, (d, g) in enumerate(ways) if d * g >= 0.0]
        self.beyond = doubtful.intersection(past) - self.touches
        for i in self.beyond:
            self._bands[i] = FURTHER_OFF * max(abs(self.now[i]), NOISE * self.largest[i])

    def leaping_at(self, t: float) -> Collection[int]:
        """The functions that went across poles at an instant."""
        return self._leaps if t == self._earlier[0] else ()

    def take(
        self, t: float, now: list[float], largest: list[float], doubtful: Iterable[int]
    ) -> None:
        """An event is over that machine code has iterated."""
        self.forget_noise()
        if t != self._earlier[0]:
            self._earlier, self._leaps = (t, self.largest), ()
        self.now, self.largest = now, largest
        self.leave(doubtful)

    def shifts(self) -> list[float]:
        """Moves of the zero functions, away from zero, by which an integrator sees no crossings
        of noise, and those of what is beyond zero; empty where there is none."""
        if not self._bands:
            return []
        return [-d * self._bands.get(i, 0.0) for i, d in enumerate(self.directions())]

    def evaluate(self, t: float, y: Sequence[float]) -> int:
        """The kernel's flag; `now` and `largest` are up to date after it."""
        flag = self.kernel.roots(t, y, self.now)
        if t != self._earlier[0]:
            self._earlier, self._leaps = (t, self.largest), ()
        self.largest = [max(a, abs(b)) for a, b in zip(self.largest, self.now, strict=True)]
        self._forget_poles()
        return flag

    def _forget_poles(self) -> None:
        """What stands at a pole says nothing of sizes."""
        for i in self._leaps:
            self.largest[i] = self._earlier[1][i]

    def begin(self, t: float) -> None:
        """The run begins: sizes seen while its start was searched for say nothing of it."""
        self.largest = [0.0] * len(self.largest)
        self._start = t

    def noise(self, t: float, y: Sequence[float]) -> list[float]:
        """Sizes up to which the zero functions may be errors of rounding. The workspace is that
        at (t, y) afterwards."""
        self.kernel.roots(t, y, now := list(self.now))
        found = self._rounding.bounds(t - self._start)
        self.kernel.roots(t, y, now)
        return [SAFETY * size for size in found]

    def _listen(self, t: float, y: Sequence[float]) -> None:
        """Remember the noise here until the next event: asking costs as much as a hundred steps."""
        self.heard = list(map(max, self.heard, self.noise(t, y)))

    def quiet(self) -> float:
        """The size below which it pays to ask for the noise."""
        return QUIET * max(1.0, *(abs(self.kernel.w[slot]) for slot in self._unknowns))

    def truths_at_start(self, t: float, y: Sequence[float]) -> list[bool]:
        """Truths where nothing was before: what may be a rounding error alone counts as zero."""
        quiet = self.quiet()
        for i in self.touches:
            if abs(self.now[i]) <= quiet:
                self.now[i] = 0.0
        small = [
            0 < abs(g) <= quiet and not r.time_only
            for g, r in zip(self.now, self.program.relations, strict=True)
        ]
        noise = self.noise(t, y) if any(small) else self.now
        self.now = [
            0.0 if may and abs(g) <= n else g
            for g, may, n in zip(self.now, small, noise, strict=True)
        ]
        return list(map(self.sign, range(len(self.now))))

    def sign(self, i: int) -> bool:
        """The truth that the value of zero function i stands for."""
        return self.now[i] < 0 or (self.now[i] == 0 and not self.program.relations[i].strict)

    def missed(self, t: float, y: Sequence[float]) -> dict[int, bool]:
        """Relations whose stored truth no longer agrees with their zero function."""
        if not self.now or self.evaluate(t, y) != 0:
            return {}
        wrong = {}
        for i, relation in enumerate(self.program.relations):
            if abs(self.now[i]) > 1e3 * NOISE * self.largest[i]:
                truth = self.now[i] < 0
                if truth != (self.kernel.w[relation.slot] != 0) and i not in self.beyond:
                    wrong[i] = truth
        if wrong and min(abs(self.now[i]) for i in wrong) <= 1e3 * self.quiet():
            if any(abs(self.now[i]) > 1e3 * self.heard[i] for i in wrong if i not in self.touches):
                self._listen(t, y)
            wrong = {
                i: truth for i, truth in wrong.items() if abs(self.now[i]) > 1e3 * self.heard[i]
            }
        return wrong

    def rises(
        self, t: float, y: Sequence[float], bent: bool = False, further: float = 1.0
    ) -> list[float] | None:
        """How far each zero function moves within a short time from here, or so many times as
        long, to first order; `bent`: to the second."""
        self._ahead = max(self._least, 4 * room(t))
        ahead = further * self._ahead
        ydot = [0.0] * len(y)
        if self.kernel.rhs(t, y, ydot) != 0 or self.evaluate(t, y) != 0:
            return None
        later = [a + ahead * d for a, d in zip(y, ydot, strict=True)]
        if bent:
            last = [0.0] * len(y)
            if self.kernel.rhs(t + ahead, later, last) != 0:
                return None
            half = ahead / 2
            later = [a + half * (b + c) for a, b, c in zip(y, ydot, last, strict=True)]
        self._later = (t + ahead, later)
        found = list(self.now)
        if self.kernel.roots(*self._later, found) != 0:
            return None
        return [b - a for a, b in zip(self.now, found, strict=True)]

    def real(
        self,
        directions: Sequence[int],
        rises: list[float] | None,
        t: float,
        y: Sequence[float],
    ) -> dict[int, bool]:
        """The crossings among those that an integrator reports, with the truth that follows.

        A function that rises where it was seen to fall has not crossed: the integrator saw
        the errors of its own first steps; far from zero it went across a pole. One that neither
        rises nor falls (the speed of what is stuck), not even where one looks further, has none
        but rounding errors, unless it came to be zero exactly (a value at its limit); should it
        leave zero, `missed` tells.
        In `rises` stands the pace at which it was seen to cross.
        """
        found = {i: d < 0 for i, d in enumerate(directions) if d}
        if rises is None:
            return found
        self._leaps = {i for i, truth in found.items() if self._leaps_over(i, truth)}
        self._forget_poles()
        quiet, size = self.quiet(), self.largest
        stays = {
            i
            for i, truth in found.items()
            if rises[i] == 0 and abs(self.now[i]) <= EXACT and self.sign(i) == truth
        }
        doubtful = {i for i in found if size[i] <= quiet or abs(rises[i]) > SUDDEN * size[i]}

        def least(i: int) -> float:
            return 4 * max(NOISE * size[i], self.heard[i] if i in doubtful else 0.0)

        def crosses(i: int) -> bool:
            return directions[i] * rises[i] > least(i) or (i in stays and self.heard[i] == 0)

        if any(crosses(i) for i in (stays | doubtful) - self.touches):
            self._listen(*self._later)
            self._listen(t, y)
        crossing = {i for i in found if i in self._leaps or crosses(i)}
        slow = [i for i in found if i not in stays and 0 <= directions[i] * rises[i] <= least(i)]
        crossing |= self._slowly(directions, slow, rises, t, y)
        noise = (i for i in found if i not in crossing and abs(rises[i]) <= least(i))
        crossing.update([i for i in noise if self._leaves(i, least(i))])
        return {i: truth for i, truth in found.items() if i in crossing}

    def _leaps_over(self, i: int, truth: bool) -> bool:
        """Whether a function has the other sign and is far from zero, as 1/x is beside its pole."""
        return self.sign(i) == truth and abs(self.now[i]) > SUDDEN * self.largest[i]

    def _leaves(self, i: int, least: float) -> bool:
        """Whether function i has gone further than noise does; until then, its side is widened."""
        band, widest = self._bands.get(i, 0.0), WIDEST * least
        self._bands[i] = min(max(band * WIDER, least), widest)
        return band >= widest

    def _slowly(
        self,
        directions: Sequence[int],
        slow: Sequence[int],
        rises: list[float],
        t: float,
        y: Sequence[float],
    ) -> set[int]:
        """The functions among the slow ones that cross by more than noise where one looks further;
        how fast stands in `rises` then."""
        crossing: set[int] = set()
        for further in FURTHER if slow else ():
            far = self.rises(t, y, bent=True, further=further)
            if far is None:
                break

            def crosses(i: int, far: Sequence[float] = far) -> bool:
                return directions[i] * far[i] > 4 * max(NOISE * self.largest[i], self.heard[i])

            if any(map(crosses, slow)):
                if not self.touches.issuperset(slow):
                    self._listen(*self._later)
                crossing.update(filter(crosses, slow))
                for i in crossing.intersection(slow):
                    rises[i] = far[i] / further
                slow = [i for i in slow if i not in crossing]
        return crossing

    def amplitude(self, i: int, rise: float, since: float) -> float:
        """The height of a bounce that took the time `since`, as a part of the largest seen."""
        return abs(rise) / self._ahead * since / 4 / max(self.largest[i], 1e-300)


@once
def unknowns(program: Program) -> tuple[int, ...]:
    """The slots of the time and of the unknowns of blocks of the top."""
    tears = (x for b in program.blocks if not b.height for x in b.tears)
    return (0, *(program.slots[repr(x)] for x in tears))
