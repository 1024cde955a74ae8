"""Which candidates are states, chosen while running by pivoting the constraint Jacobian.

In:   Program, Kernel (workspace at consistent values)
Out:  a selection: for each state the index of its candidate

Per block below the top, as many candidates as there are constraints are determined
by the others. They are found by elimination with complete pivoting, where a better
class of StateSelect gives way only when its pivot would be much worse. With G the
constraint Jacobian, split into determined and free columns,

    X = G_determined^-1 * G_free = -d(determined)/d(free)

says how errors of the states grow in what they determine. An entry x of X is also
the factor that exchanging the two candidates puts on |det G_determined|. So one
number serves for both: exchange when |x| > WORST, at which point the opposite exchange
is WORST^2 away (hysteresis), and keep the choice where all are equally bad (a point
at which the mechanism itself is singular).

In machine code X is measured at every accepted step (`solvers.watch`). In Python a look
is put off until a coordinate has moved far enough (`outlook`). Where one came too late
all the same, the run goes back to the last place with a good choice
(`Selector.overdue`): with a state that hardly moves any more, nothing says how fast the
others do.

Example: a crank-slider with the slider's s as its state. Towards a dead centre
d(crank.phi)/ds grows without bound; when it passes WORST, crank.phi takes over.

Reference: M. Gu, S. C. Eisenstat, SIAM J. Sci. Comput. 17(4), 1996, 848-869
           (the exchange criterion).

The file is long because judging, exchanging and naming a choice share its numbers.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import cached_property
from operator import mul
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.prose import both
from planarc.ir.begin import MUST_STAY
from planarc.ir.dae import Reinit
from planarc.ir.flat import StateSelect
from planarc.ir.kernel import Kernel
from planarc.ir.newton import NEGLIGIBLE, WORST, WORST_DRIVEN
from planarc.ir.once import once
from planarc.ir.places import declaration
from planarc.ir.program import BlockCode, Program
from planarc.solve.solvers.watch import Watch
from planarc.solve.states.pivoting import choose_columns, largest, sensitivities

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.solve.states.outlook import Outlook

#: A look that finds this many times the accepted sensitivity came too late.
OVERDUE = 1.3
#: Sensitivity up to which the run goes on with a state that must stay one.
LOST = 25.0
#: Factor that is accepted before a state gives way to a lower class of StateSelect,
#: where it does not grow without bound: a preferred state is kept past a place where the
#: others move fast, but leaves before a dead centre, where its errors are multiplied.
PREFERENCE = 1.45
#: Size of a column, beside that of the one in its place, below which it may be made of the errors
#: of a run alone, as for a component of a quaternion that a plane motion leaves at zero; and the
#: factor that is accepted before a state with such a column gives way.
FAINT, FAINTER = 1e-4, 4.0


class Lost(Data):
    """A state that must stay one is about to be determined by the others."""

    candidate: int
    determines: int


class Determined(Data):
    """A choice made in machine code: of each candidate whether the states determine it (1), and the
    size of its column."""

    solved: Sequence[int]
    scales: Sequence[float]


class Selector:
    """Chooses states and watches over the choice. `watch` says when to look again."""

    def __init__(self, program: Program, kernel: Kernel, measured: bool = False) -> None:
        """`measured`: the integrator itself measures the choice at every step."""
        self._program, self._kernel, self._measured = program, kernel, measured
        form = _form_of(program)
        self._leader = form.leaders
        #: Blocks with a choice to make of their own.
        self.open = form.open
        self._class: Sequence[int] = ()  # of each candidate, once its start is known
        #: |X| of blocks at the workspace's values, until it is asked for.
        self._present: dict[int, list[list[float]]] = {}
        self._determined: dict[int, list[int]] = {}
        #: Blocks whose velocities are compared: those of accelerations would say nothing.
        self._paced = form.paced
        self.watch = Watch(form.slots, form.speeds, self.open, len(form.slots))
        self._scale = self._scales()
        #: Blocks whose motion is given.
        self._driven = form.driven
        #: The last look found the choice so bad that what followed from it may be wrong.
        self.overdue = False

    @cached_property
    def outlook(self) -> Outlook:
        from planarc.solve.states.outlook import Outlook

        return Outlook(self._program, self._kernel, self.watch, self._sensitivities)

    def choose(self, held: Collection[int], known: Determined | None = None) -> list[int]:
        """Choose by the workspace's values, whatever was chosen before; or take the choice of a
        start in machine code. Raises R423.

        Of equal candidates those become states that are held at the start.
        """
        classes, key = _classes(self._program), tuple(held)
        if key not in classes:
            classes[key] = classes_of(self._program, held)
        self._class = classes[key]
        for i, block in enumerate(self._program.blocks):
            if block.height > 0 and i not in self._leader:
                self._determined[i] = []
        for i in choosing(self._program):
            block = self._program.blocks[i]
            if known is None:
                self._determined[i] = self._pivot(i, block)
                continue
            own = slice(block.first, block.first + len(block.tears))
            self._determined[i] = [j for j, out in enumerate(known.solved[own]) if out]
            self._scale[i][:] = known.scales[own]
        return self.selection()

    def restore(self, selection: Collection[int]) -> None:
        """Go back to an earlier choice."""
        states = set(selection)
        for i in self._determined:
            block = self._program.blocks[i]
            self._determined[i] = (
                [j for j in range(len(block.tears)) if block.first + j not in states]
                if block.residuals
                else []
            )

    def _scales(self) -> dict[int, Vector]:
        """The largest columns seen, of each block; of the open ones the watch has them, too."""
        import numpy as np

        found, first = {}, 0
        for i, block in enumerate(self._program.blocks):
            n = len(block.tears)
            if i in self.open:
                found[i] = self.watch.scales[first : first + n]
                first += n
            elif block.height > 0 and block.residuals:
                found[i] = np.zeros(n)
        return found

    def selection(self) -> list[int]:
        chosen: list[int] = []
        for i, block in enumerate(self._program.blocks):
            if block.height > 0:
                out = set(self._determined_of(i))
                chosen.extend(block.first + j for j in range(len(block.tears)) if j not in out)
        return chosen

    def _determined_of(self, i: int) -> list[int]:
        """The tears that are determined: where a block follows another one, their derivatives."""
        if i not in self._leader:
            return self._determined[i]
        leader, places = self._leader[i]
        return [places[j] for j in self._determined_of(leader)]

    def check(self, urgent: bool = False) -> tuple[bool, Lost | None]:
        """Whether the choice was changed, and a state that cannot go on being one.

        At an accepted point. `urgent`: the integrator failed, so a choice that is only
        somewhat better is taken.
        """
        changed, lost, worst = False, None, 0.0
        self.overdue = False
        self._present.clear()
        for i in self.open:
            exchanged, trouble, size = self._exchange(i, 2.0 if urgent else self._accepted(i))
            changed |= exchanged
            lost = lost or trouble
            worst = max(worst, size)
        self.watch.bind(worst, changed)
        if not self._measured:
            self.outlook.plan(worst, self.watch.bound, changed, self.paces(), self._single())
        self._present.clear()
        return changed, lost

    def hurry(self) -> None:
        """The last look came too late: look much sooner from here."""
        self.watch.bound = self.watch.least = WORST
        if not self._measured:
            self.outlook.hurry(self.paces())

    def _jams(self, i: int, taker: int, state: int) -> bool:
        """Whether a driven mechanism is about to jam.

        Towards a dead centre of its state that one slows down; where a drive comes to the
        end of a mechanism's reach the others become ever faster: the product of both speeds
        grows. No choice of states helps there, and one of those would even come back from
        beyond.
        """
        if i not in self._driven:
            return False
        w, first = self._kernel.w, self._program.blocks[i].first
        rates = {c.slot: c.derivative for c in self._program.candidates}
        slots = [self._program.candidates[first + j].derivative for j in (taker, state)]
        v, u = (float(w[s]) for s in slots)
        dv, du = (float(w[rates[s]]) if s in rates else 0.0 for s in slots)
        return v * u * (dv * u + v * du) > 0.0

    def _single(self) -> bool:
        """Whether one block alone has a choice to make, of one state."""
        if len(self.open) != 1:
            return False
        (i,) = self.open
        return len(self._program.blocks[i].tears) - len(self._determined[i]) == 1

    def paces(self) -> list[tuple[int, float]]:
        """Velocities in the measure of the sensitivities, the states' first, of each block."""
        found = []
        for i in self._paced:
            first, scale = self._program.blocks[i].first, self._scale[i].tolist()
            out = self._determined[i]
            for j in sorted(range(len(scale)), key=lambda j: j in out):
                weight = scale[j] if scale[j] > 0 else 1.0
                slot = self._program.candidates[first + j].derivative
                found.append((slot, weight if j in out else -weight))
        return found

    def _sensitivities(self) -> list[list[list[float]]]:
        found = []
        for i in self.open:
            if i in self._present:
                found.append(self._present.pop(i))
                continue
            n = len(self._program.blocks[i].tears)
            out = self._determined[i]
            free = [j for j in range(n) if j not in out]
            found.append(sensitivities(self._jacobian(i, keep=False), out, free) or [])
        return found

    # One block

    def _jacobian(self, i: int, keep: bool = True) -> list[list[float]]:
        """Scaled so that a unit of every candidate moves the constraints alike.

        The measure is the largest seen, lest a column that vanishes be blown up.
        """
        g = self._kernel.jacobian(i)
        sizes = [math.hypot(*column) for column in zip(*g, strict=True)]
        sizes = list(map(max, self._scale[i].tolist(), sizes))
        if keep:
            self._scale[i][:] = sizes
        least = NEGLIGIBLE * max(sizes, default=0.0)
        parts = [1 / s if s > least else 0.0 for s in sizes]
        return [list(map(mul, row, parts)) for row in g]

    def _must_stay(self, block: BlockCode, j: int) -> bool:
        return self._class[block.first + j] == MUST_STAY

    def _pivot(self, i: int, block: BlockCode) -> list[int]:
        classes = self._class[block.first : block.first + len(block.tears)]
        chosen = choose_columns(self._jacobian(i), classes, MUST_STAY)
        if chosen is None:
            raise self._too_many(block)
        return chosen

    def _too_many(self, block: BlockCode) -> PlanarcError:
        forced = [
            self._program.candidates[block.first + j]
            for j in range(len(block.tears))
            if self._must_stay(block, j)
        ]
        names = both(c.display for c in forced)
        found = Diagnostic(
            "R423",
            f"{names} cannot all be states: constraints tie them together",
            declaration(self._program, forced[-1].display, forced[-1].span) if forced else None,
            hint="take `stateSelect = StateSelect.always` or a `reinit` away from one of them",
        )
        return PlanarcError(found)

    def _accepted(self, i: int) -> float:
        """The largest sensitivity of a block with which its states go on."""
        return WORST_DRIVEN if i in self._driven else WORST

    def _exchange(self, i: int, worst: float) -> tuple[bool, Lost | None, float]:
        """Whether candidates were exchanged, a state that is lost, the largest sensitivity."""
        block = self._program.blocks[i]
        g = self._jacobian(i)
        if not math.isfinite(sum(map(sum, g))):
            return False, None, math.inf
        n = len(block.tears)
        out, changed, size = list(self._determined[i]), False, 0.0
        free: list[int] = []
        x: list[list[float]] | None = []
        for round_ in range(n):
            free = [j for j in range(n) if j not in out]
            x = sensitivities(g, out, free)
            if round_ == 0:
                late = OVERDUE * self._accepted(i)
                self.overdue |= x is None or largest(x, range(len(free)))[0] > late
                if x is not None:
                    self._present[i] = x
            if x is None:  # exactly singular: begin anew
                again = self._pivot(i, block)
                changed, out = changed or again != out, again
                break
            size = largest(x, range(len(free)))[0]
            if size <= worst:
                break
            movable = [k for k, j in enumerate(free) if not self._must_stay(block, j)]
            weighed, r, c = largest(self._weighed(i, x, out, free), movable)
            if weighed <= worst and not (
                largest(x, movable)[0] > worst and self.outlook.heads_for_dead_centre()
            ):
                break
            if self._jams(i, out[r], free[c]):
                break
            out[r] = free[c]
            changed = True
        self._determined[i] = sorted(out)
        if changed:
            self._present.pop(i, None)
        if x is None or size <= worst:
            return changed, None, size
        stuck = [k for k, j in enumerate(free) if self._must_stay(block, j)]
        if stuck:
            stuck_size, r, c = largest(x, stuck)
            size = max(size, stuck_size)
            if stuck_size > LOST:
                return changed, Lost(block.first + free[c], block.first + out[r]), size
        return changed, None, size

    def _weighed(
        self, i: int, x: list[list[float]], out: list[int], free: list[int]
    ) -> list[list[float]]:
        """Sensitivities, made smaller where the exchange would prefer a lower StateSelect, or
        what has hardly ever moved the constraints."""
        block, scale = self._program.blocks[i], self._scale[i].tolist()
        select = [c // 4 for c in self._class[block.first : block.first + len(block.tears)]]

        def weight(given: int, taken: int) -> float:
            preferred = PREFERENCE if select[given] < select[taken] else 1.0
            return preferred * (FAINTER if scale[taken] < FAINT * scale[given] else 1.0)

        return [
            [e / weight(k, j) for e, j in zip(row, free, strict=True)]
            for k, row in zip(out, x, strict=True)
        ]


@once
def _classes(program: Program) -> dict[tuple[int, ...], list[int]]:
    """The classes of candidates, by those that are held at the start."""
    return {}


def classes_of(program: Program, held: Collection[int]) -> list[int]:
    """The class of each candidate: low ones should be determined, high ones should be states.

    A coordinate and its derivatives are states together, so the highest of them counts.
    """
    slots = {c.slot: i for i, c in enumerate(program.candidates)}
    classes, kinds = [0] * len(program.candidates), kinds_of(program)
    for i, c in reversed(list(enumerate(program.candidates))):
        classes[i] = kinds[i] + (i in held and kinds[i] < MUST_STAY)
        derivative = slots.get(c.derivative)
        if derivative is not None:
            classes[i] = max(classes[i], classes[derivative])
    return classes


def kinds_of(program: Program) -> list[int]:
    """The class of each candidate by itself, of a start value that is not held."""
    forced = _forced(program)
    return [
        MUST_STAY if i in forced else 4 * c.select + 2 * c.fixed
        for i, c in enumerate(program.candidates)
    ]


class _Form(Data):
    """What the choices of a program have in common, as `Selector` has it."""

    leaders: dict[int, tuple[int, dict[int, int]]]
    open: tuple[int, ...]
    slots: tuple[int, ...]  # of the tears of open blocks
    paced: tuple[int, ...]
    speeds: int  # tears of these
    driven: frozenset[int]


@once
def _form_of(program: Program) -> _Form:
    blocks, opened = program.blocks, open_blocks(program)
    tears = {i: program.candidates[blocks[i].first :][: len(blocks[i].tears)] for i in opened}
    paced = tuple(i for i in opened if blocks[i].height > 1)
    return _Form(
        leaders_of(program),
        opened,
        tuple(c.slot for i in opened for c in tears[i]),
        paced,
        sum(len(tears[i]) for i in paced),
        driven_blocks(program),
    )


@once
def leaders_of(program: Program) -> dict[int, tuple[int, dict[int, int]]]:
    """Blocks whose tears are the derivatives of another block's tears follow its choice.

    Gives that block, and for each of its tears the place of the derivative. Their
    Jacobians agree, since the one's constraints are the other's differentiated.
    """
    found: dict[int, tuple[int, dict[int, int]]] = {}
    places = {
        program.candidates[b.first + j].slot: (i, j)
        for i, b in enumerate(program.blocks)
        if b.height > 0
        for j in range(len(b.tears))
    }
    for i, b in enumerate(program.blocks):
        if b.height < 2 or not b.residuals:
            continue
        below = [
            places.get(program.candidates[b.first + j].derivative) for j in range(len(b.tears))
        ]
        follower = below[0][0] if below[0] else -1
        mapping = {j: p[1] for j, p in enumerate(below) if p is not None and p[0] == follower}
        code = program.blocks[follower]
        same = len(mapping) == len(b.tears) == len(code.tears)
        if same and len(code.residuals) == len(b.residuals):
            found[follower] = (i, mapping)
    return found


@once
def choosing(program: Program) -> tuple[int, ...]:
    """Blocks with anything to choose that follow no other one."""
    leaders = leaders_of(program)
    blocks = enumerate(program.blocks)
    return tuple(i for i, b in blocks if b.height > 0 and b.residuals and i not in leaders)


@once
def open_blocks(program: Program) -> tuple[int, ...]:
    """Blocks that have a choice of states to make of their own."""
    return tuple(i for i in choosing(program) if program.blocks[i].free > 0)


@once
def driven_blocks(program: Program) -> frozenset[int]:
    """The open blocks whose velocities are determined: they move as they are driven."""
    homes = {c.slot: c.block for c in program.candidates}
    found = set()
    for i in open_blocks(program):
        block = program.blocks[i]
        rates = [c.derivative for c in program.candidates[block.first :][: len(block.tears)]]
        given = all(program.blocks[homes[r]].free == 0 for r in rates if r in homes)
        if block.height > 1 and given:
            found.add(i)
    return frozenset(found)


@once
def _forced(program: Program) -> frozenset[int]:
    """Candidates that must be states: StateSelect.always, and those that reinit names."""
    named = {
        program.slots.get(repr(action.symbol))
        for when in program.whens
        for _, _, actions in when.branches
        for action in actions
        if isinstance(action, Reinit)
    }
    return frozenset(
        i
        for i, c in enumerate(program.candidates)
        if c.select is StateSelect.ALWAYS or c.slot in named
    )


def lost_diagnostic(program: Program, t: float, lost: Lost) -> Diagnostic:
    state, other = program.candidates[lost.candidate], program.candidates[lost.determines]
    return Diagnostic(
        "R423",
        f"at t = {t:.6g} s `{state.display}` can no longer be a state: in this position it "
        f"hardly moves while `{other.display}` does (a dead centre)",
        declaration(program, state.display, state.span),
        hint=f"let `{other.display}` be the state: take `StateSelect.always` or the `reinit` "
        f"away from `{state.display}`",
    )
