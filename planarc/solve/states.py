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

Example: a crank-slider with the slider's s as its state. At a dead centre
d(crank.phi)/ds grows without bound; when it passes WORST, crank.phi takes over.

Reference: M. Gu, S. C. Eisenstat, SIAM J. Sci. Comput. 17(4), 1996, 848-869
           (the exchange criterion).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, error
from planarc.ir.dae import Reinit
from planarc.ir.flat import StateSelect
from planarc.ir.program import BlockCode, Kernel, Program

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

#: The greatest sensitivity of a determined candidate to a state that is accepted.
WORST = 20.0
#: With a state that must stay one, the run goes on until this.
LOST = 1000.0
#: A pivot of a better class may be smaller by this.
GIVE_WAY = 0.05
#: Checks to let pass after an exchange, unless the integrator fails.
REST = 3


@dataclass(frozen=True, slots=True)
class Lost:
    """A state that must stay one is about to be determined by the others."""

    candidate: int
    determines: int


class Selector:
    """Chooses states and watches over the choice."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self._program, self._kernel = program, kernel
        self._forced = _forced(program)
        slots = {c.slot: i for i, c in enumerate(program.candidates)}
        self._derivative = {
            i: slots[c.derivative]
            for i, c in enumerate(program.candidates)
            if c.derivative in slots
        }
        self._scale: dict[int, Matrix] = {}
        self._rest = 0
        self._leader = _leaders(program)
        #: Blocks with a choice to make of their own.
        self.open = [
            i
            for i, b in enumerate(program.blocks)
            if b.height > 0 and b.residuals and b.free > 0 and i not in self._leader
        ]
        self._determined: dict[int, list[int]] = {}

    def choose(self) -> list[int]:
        """At the workspace's values, without regard to an earlier choice. Raises R423."""
        for i, block in enumerate(self._program.blocks):
            if block.height > 0 and i not in self._leader:
                self._determined[i] = self._pivot(i, block) if block.residuals else []
        return self.selection()

    def selection(self) -> list[int]:
        chosen: list[int] = []
        for i, block in enumerate(self._program.blocks):
            if block.height > 0:
                out = set(self._determined_of(i))
                chosen.extend(block.first + j for j in range(len(block.tears)) if j not in out)
        return chosen

    def _determined_of(self, i: int) -> list[int]:
        """Of a block that follows another one: the derivatives of what is determined there."""
        if i not in self._leader:
            return self._determined[i]
        leader, places = self._leader[i]
        return [places[j] for j in self._determined_of(leader)]

    def check(self, urgent: bool = False) -> tuple[bool, Lost | None]:
        """Whether the choice was changed, and a state that cannot go on being one.

        At an accepted point. `urgent`: the integrator failed, so nothing is put off.
        """
        if self._rest > 0 and not urgent:
            self._rest -= 1
            return False, None
        changed, lost = False, None
        for i in self.open:
            exchanged, trouble = self._exchange(i, WORST / 4 if urgent else WORST)
            changed |= exchanged
            lost = lost or trouble
        if changed:
            self._rest = REST
        return changed, lost

    # One block

    def _jacobian(self, i: int) -> Matrix:
        """Scaled so that a unit of every candidate moves the constraints alike.

        The measure is the largest seen, lest a column that vanishes be blown up.
        """
        import numpy as np

        g = np.array(self._kernel.jacobian(i), dtype=float)
        size = np.sqrt((g * g).sum(axis=0))
        known = self._scale.get(i)
        scale = size if known is None else np.maximum(known, size)
        self._scale[i] = scale
        return g / np.where(scale > 0, scale, 1.0)  # type: ignore[no-any-return]

    def _class(self, block: BlockCode, j: int) -> int:
        """Low: should be determined. High: should be a state."""
        program = self._program
        family = [block.first + j]
        while (child := self._derivative.get(family[-1])) is not None:
            family.append(child)
        if any(c in self._forced for c in family):
            return 2 * StateSelect.ALWAYS
        return max(2 * program.candidates[c].select + program.candidates[c].fixed for c in family)

    def _must_stay(self, block: BlockCode, j: int) -> bool:
        return self._class(block, j) == 2 * StateSelect.ALWAYS

    def _pivot(self, i: int, block: BlockCode) -> list[int]:
        import numpy as np

        a = self._jacobian(i)
        m, n = a.shape
        classes = np.array([self._class(block, j) for j in range(n)])
        top = 2 * StateSelect.ALWAYS
        rows, left, out = list(range(m)), list(range(n)), []
        for _ in range(m):
            r, j = _best_pivot(a, rows, left, classes, top)
            if classes[j] == top:
                raise self._too_many(block)
            if a[r, j] != 0.0:
                for k in rows:
                    if k != r:
                        a[k] -= a[k, j] / a[r, j] * a[r]
            rows.remove(r)
            left.remove(j)
            out.append(j)
        return sorted(out)

    def _too_many(self, block: BlockCode) -> Exception:
        forced = [
            self._program.candidates[block.first + j]
            for j in range(len(block.tears))
            if self._must_stay(block, j)
        ]
        names = " and ".join(f"`{c.display}`" for c in forced)
        return error(
            "R423",
            f"{names} cannot all be states: constraints tie them together"
            if len(forced) > 1
            else f"{names} cannot be a state here: the other coordinates determine it",
            forced[0].span if forced else None,
            hint="take `stateSelect = StateSelect.always` or a `reinit` away from one of them, "
            "or start in another position",
        )

    def _exchange(self, i: int, worst: float) -> tuple[bool, Lost | None]:
        import numpy as np

        block = self._program.blocks[i]
        g = self._jacobian(i)
        if not np.all(np.isfinite(g)):
            return False, None
        out = list(self._determined[i])
        changed = False
        for _ in range(g.shape[1]):
            free = [j for j in range(g.shape[1]) if j not in out]
            try:
                x = np.abs(np.linalg.solve(g[:, out], g[:, free]))
            except np.linalg.LinAlgError:
                return self._replace(i, block, changed)
            movable = [k for k, j in enumerate(free) if not self._must_stay(block, j)]
            a, b = _largest(x[:, movable]) if movable else (0, -1)
            if b < 0 or x[a, movable[b]] <= worst:
                break
            out[a] = free[movable[b]]
            changed = True
        self._determined[i] = sorted(out)
        stuck = [k for k, j in enumerate(free) if self._must_stay(block, j)]
        if stuck:
            a, b = _largest(x[:, stuck])
            if x[a, stuck[b]] > LOST:
                return changed, Lost(block.first + free[stuck[b]], block.first + out[a])
        return changed, None

    def _replace(self, i: int, block: BlockCode, changed: bool) -> tuple[bool, Lost | None]:
        """The present choice is exactly singular: take the best one, if it is not as bad."""
        before = self._determined[i]
        after = self._pivot(i, block)
        self._determined[i] = after
        return changed or after != before, None


def _leaders(program: Program) -> dict[int, tuple[int, dict[int, int]]]:
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


def _best_pivot(
    a: Matrix, rows: Sequence[int], left: Sequence[int], classes: Matrix, top: int
) -> tuple[int, int]:
    """Row and column of the largest entry in the lowest class that need not give way."""
    import numpy as np

    columns = np.array(left)
    size = np.abs(a[np.ix_(rows, left)]).max(axis=0)
    allowed = classes[columns] < top
    best = float(size[allowed].max()) if np.any(allowed) else -1.0
    if best < 0:
        return rows[0], int(columns[0])
    good = allowed & (size >= GIVE_WAY * best) & (size > 0 if best > 0 else True)
    lowest = classes[columns][good].min()
    eligible = columns[good & (classes[columns] == lowest)]
    # Equal but for rounding counts as equal, so that the order decides and not the machine.
    entry = np.abs(a[np.ix_(rows, eligible)])
    r, c = np.argwhere(entry >= entry.max() * (1 - 1e-9))[0]
    return rows[int(r)], int(eligible[int(c)])


def _largest(x: Matrix) -> tuple[int, int]:
    import numpy as np

    a, b = np.unravel_index(int(np.argmax(x)), x.shape)
    return int(a), int(b)


def _forced(program: Program) -> frozenset[int]:
    """Candidates that must be states: StateSelect.always, and those that reinit names."""
    slots = {
        program.slots.get(repr(action.symbol))
        for when in program.whens
        for _, _, actions in when.branches
        for action in actions
        if isinstance(action, Reinit)
    }
    return frozenset(
        i
        for i, c in enumerate(program.candidates)
        if c.select is StateSelect.ALWAYS or c.slot in slots
    )


def lost_diagnostic(program: Program, t: float, lost: Lost) -> Diagnostic:
    state, other = program.candidates[lost.candidate], program.candidates[lost.determines]
    return Diagnostic(
        "R423",
        f"at t = {t:.6g} s `{state.display}` can no longer be a state: in this position it "
        f"hardly moves while `{other.display}` does (a dead centre)",
        state.span,
        hint=f"let `{other.display}` be the state: take `StateSelect.always` or the `reinit` "
        f"away from `{state.display}`",
    )
