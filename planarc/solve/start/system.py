"""The conditions at the start, as one function of all candidates, and its derivatives.

In:   Program, Kernel (parameters and start values set), the time, the measure of lengths
Out:  System    rows: the residuals of the blocks below the top, the initial equations, and
                the variables held that are no candidates

Candidates, rows and other variables are numbers in the mechanism's own measure (`solve.measure`),
so that what is near, small or independent does not depend on its size.

A native kernel makes a Jacobian by differences in one call; with another one the same
differences are made from Python, one evaluation each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.begin import JOINT, OTHER, WRITTEN
from planarc.ir.flat import StateSelect
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.once import once
from planarc.ir.program import BlockCode, CandidateSlot, FixedSlot, Program
from planarc.solve.measure import sizes_of_candidates, sizes_of_rows, sizes_of_slots
from planarc.solve.rescue.rescue import Rescue

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Rows (m, m2) below which a mechanism is nearly assembled.
ASSEMBLED = 1e-4
#: Choices of given start values of which it is remembered what asks to be held.
MOST_GIVEN = 64
#: Rows, and the candidates that they are solved for.
Stage: TypeAlias = tuple[list[int], list[int]]


class System:
    """The equations of the start. `conditions` are the fixed variables that are no candidates, and
    `others` that are held. `follow`: the guess is near an assembly that was good before."""

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        t: float,
        given: frozenset[int] = frozenset(),
        others: Sequence[FixedSlot] = (),
        rescue: Rescue | None = None,
        follow: bool = False,
        length: float = 1.0,
    ) -> None:
        """`length` is the measure of lengths in m."""
        import numpy as np

        self.follow, self.length = follow, length
        self.program, self.kernel, self.t, self.given = program, kernel, t, given
        self.rescue = Rescue(program, kernel) if rescue is None else rescue
        form = form_of(program)
        self.blocks, self.block_rows = form.blocks, form.block_rows
        self.initial_rows, self.conditions = form.initial_rows, (*form.fixed, *others)
        count = self.initial_rows.stop
        self.fixed_rows = range(count, count + len(self.conditions))
        self.rows = self.fixed_rows.stop
        #: Rows and candidates of each level, positions first, then of everything.
        self.stages = _stages(program, form, self.conditions) if self.conditions else form.stages
        #: All that asks to be held: fixed candidates (by number), then all that was written, by
        #: StateSelect and declaration; and the variables among these that are no candidates.
        self.asking, self.asking_besides = asking_of(program, given)
        self._form = kernel.capabilities.start
        self._r = [math.nan] * max(1, self.initial_rows.stop)
        self._slots = tuple(f.slot for f in self.conditions)
        #: What a candidate of 1, and a row of 1, are in SI units.
        self.units = sizes_of_candidates(program, length)
        self.parts = np.concatenate(
            [sizes_of_rows(program, length), sizes_of_slots(program, length, self._slots)]
        )
        wanted = np.array([float(kernel.w[f.start]) for f in self.conditions])
        self._wanted = wanted / self.parts[self.fixed_rows.start :]
        #: Whether a place counts where forces and accelerations have no value.
        self.forceless = False
        #: All derivatives at the last place where they were wanted, and of which variables.
        self._known: tuple[bytes, tuple[int, ...], Vector] | None = None
        #: The place that the workspace was left at, and all rows there; None of any other place.
        self._last: tuple[bytes, Vector] | None = None

    def holding(self, others: Sequence[FixedSlot]) -> System:
        """The system with some more variables held."""
        if not others:
            return self
        given = self.program, self.kernel, self.t, self.given
        return System(*given, others, self.rescue, self.follow, self.length)

    def of_loops(self) -> System:
        """The loops alone, at any place, whatever forces and accelerations are there."""
        bare = replace(self.program, fixed=(), initial_residuals=())
        given = bare, self.kernel, self.t, self.given
        system = System(*given, rescue=self.rescue, length=self.length)
        system.forceless = True
        return system

    def written(self, start: CandidateSlot | FixedSlot) -> bool:
        """Whether the user has said where it starts, in the model or for this run."""
        return is_written(start, self.given)

    # Values

    def evaluate_flag(self, u: Vector) -> int:
        self._last = None
        there = u * self.units
        if (
            self._form is not None
            and self._form.differences(self.t, there, (), (), False) is not None
        ):
            return 0
        given = there.tolist()
        return self.rescue.overcome(self.t, lambda: self.kernel.residuals(self.t, given, self._r))

    def finite(self, u: Vector) -> bool:
        rates = form_of(self.program).rates(self.kernel.w)
        return all(map(math.isfinite, u.tolist())) and all(map(math.isfinite, rates))

    def __call__(self, u: Vector) -> Vector | None:
        """All rows; None where one is not finite."""
        found = self.values(u, ())
        self._last = None if found is None else (u.tobytes(), found)
        return found

    def again(self, u: Vector) -> Vector | None:
        """The same, known already where it was asked for this place last and nothing else since."""
        last = self._last
        return last[1] if last is not None and last[0] == u.tobytes() else self(u)

    def values(self, u: Vector, slots: tuple[int, ...]) -> Vector | None:
        """All rows, then the values of some variables. The workspace is left at `u`. None where
        these have no values, or forces and accelerations have none: but an assembled place
        counts all the same, since redundant bars leave forces open at all of them."""
        import numpy as np

        asked, self._last = (*self._slots, *slots), None
        if self._form is not None:
            there = u * self.units
            found = self._form.differences(self.t, there, (), asked, False)
            if found is None and self.evaluate_flag(u) == 0:  # with help
                found = self._form.differences(self.t, there, (), asked, False)
            whole = found is not None
            if found is None and self._is_below(asked):
                found = self._form.differences(self.t, there, (), asked, True)
            if found is None:
                return None
            values: Vector = found[0]
        else:
            self._r[:] = [math.nan] * len(self._r)
            whole = self.evaluate_flag(u) == 0
            if not whole and not self._is_below(asked):
                return None
            w = self.kernel.w
            values = np.concatenate([self._r[: self.initial_rows.stop], [w[s] for s in asked]])
            if not np.isfinite(values).all():
                return None
        values = values / self._sizes(slots)
        if not (whole or self.forceless) and abs(values).max(initial=0.0) > ASSEMBLED:
            return None
        if self._slots:
            values[self.fixed_rows.start : self.rows] -= self._wanted
        return values

    def root(self, u: Vector, rows: Sequence[int], columns: Sequence[int]) -> Vector | None:
        """A point beside `u` at which some rows vanish, with as many candidates moved; None where
        none is found straight on."""
        import numpy as np

        if self._form is None or len(rows) != len(columns) or self.length != 1.0:
            return None
        wanted, self._last = np.zeros(self.rows), None
        wanted[self.fixed_rows.start :] = self._wanted
        return self._form.root(self.t, u, tuple(columns), self._slots, rows, wanted)

    def motions(self, u: Vector, part: float) -> Vector | None:
        """`newton.kernel_of` all conditions, where machine code tells it."""
        self._last = None
        if self._form is None or self.length != 1.0:
            return None
        return self._form.motions(self.t, u, self._slots, part)

    # Derivatives

    def slopes(
        self, u: Vector, columns: Sequence[int] | None = None, slots: tuple[int, ...] = ()
    ) -> Vector | None:
        """Derivatives of what `values` gives, by all candidates or by some."""
        place, known = u.tobytes(), self._known
        if known is not None and known[0] == place and set(slots) <= set(known[1]):
            rows = [*range(self.rows), *(self.rows + known[1].index(s) for s in slots)]
            chosen: Vector = known[2].take(rows, 0)
            return chosen if columns is None else chosen.take(columns, 1)
        asked = range(len(u)) if columns is None else columns
        found = self._differences(u, tuple(asked), slots)
        if found is not None and columns is None:
            self._known = place, slots, found
        return found

    def jacobian(self, i: int) -> Sequence[Sequence[float]]:
        """The matrix of a block where the workspace is."""
        found = self.kernel.jacobian(i)
        if self.length == 1.0:
            return found
        rows, block = self.block_rows[i], self.program.blocks[i]
        units = self.units[block.first : block.first + len(block.tears)].tolist()
        parts = self.parts[rows.start : rows.stop].tolist()
        return [
            [e * unit / part for e, unit in zip(row, units, strict=True)]
            for row, part in zip(found, parts, strict=True)
        ]

    def _differences(
        self, u: Vector, columns: tuple[int, ...], slots: tuple[int, ...]
    ) -> Vector | None:
        self._last = None
        if self._form is not None and self.length == 1.0:
            asked = (*self._slots, *slots)
            found = self._form.differences(self.t, u, columns, asked, self._is_below(asked))
            return None if found is None else found[1:].T
        full = u.copy()
        chosen = list(columns)

        def moved(z: Vector) -> Vector | None:
            full[chosen] = z
            return self.values(full, slots)

        from planarc.solve.start import newton

        here = self.values(u, slots)
        return None if here is None else newton.differences(moved, u[chosen], here)

    def _sizes(self, slots: tuple[int, ...]) -> Vector:
        """What rows of 1 are in SI units, and then some variables."""
        import numpy as np

        own = sizes_of_slots(self.program, self.length, slots)
        return np.concatenate([self.parts, own]) if slots else self.parts

    def _is_below(self, asked: Sequence[int]) -> bool:
        """Whether all rows are known before accelerations and forces are."""
        return not (self.initial_rows or asked)


class Form(Data):
    """What the systems of a program have in common."""

    blocks: tuple[tuple[int, BlockCode], ...]  # below the top, with their numbers
    block_rows: dict[int, range]
    initial_rows: range
    fixed: tuple[FixedSlot, ...]  # the fixed variables that are no candidates
    starts: Taker  # of the start values of candidates
    rates: Taker  # of the derivatives of candidates
    stages: list[Stage]  # without conditions


@once
def form_of(program: Program) -> Form:
    blocks = tuple((i, b) for i, b in enumerate(program.blocks) if b.height > 0)
    rows, count = dict[int, range](), 0
    for i, block in blocks:
        rows[i] = range(count, count + len(block.residuals))
        count += len(block.residuals)
    initial = range(count, count + len(program.initial_residuals))
    fixed = tuple(f for f in program.fixed if f.fixed)
    candidates = program.candidates
    starts, rates = taker([c.start for c in candidates]), taker([c.derivative for c in candidates])
    form = Form(blocks, rows, initial, fixed, starts, rates, [])
    form.stages.extend(_stages(program, form, ()))
    return form


def _stages(program: Program, form: Form, conditions: Sequence[FixedSlot]) -> list[Stage]:
    """Rows and candidates of each level, positions first, then of everything."""
    found: list[Stage] = []
    heights = sorted({b.height for _, b in form.blocks}, reverse=True)
    for height in heights:
        rows: list[int] = []
        columns: list[int] = []
        for i, block in form.blocks:
            if block.height == height:
                rows.extend(form.block_rows[i])
                columns.extend(range(block.first, block.first + len(block.tears)))
        numbered = enumerate(conditions, form.initial_rows.stop)
        rows.extend(row for row, f in numbered if f.height == height)
        found.append((rows, columns))
    if form.initial_rows or conditions or len(heights) > 2:
        every = range(form.initial_rows.stop + len(conditions))
        found.append((list(every), list(range(len(program.candidates)))))
    return found


def asking_of(
    program: Program, given: frozenset[int]
) -> tuple[list[int | FixedSlot], list[FixedSlot]]:
    known = _asked(program)
    found = known.get(given)
    if found is None:
        if len(known) > MOST_GIVEN:
            known.clear()
        order = [item for item, start, said in _ranked(program) if said or start.start in given]
        found = known[given] = order, [f for f in order if isinstance(f, FixedSlot)]
    return found


@once
def _asked(program: Program) -> dict[frozenset[int], tuple[list[int | FixedSlot], list[FixedSlot]]]:
    """What asks to be held, for the start values that are given."""
    return {}


@once
def _ranked(program: Program) -> list[tuple[int | FixedSlot, CandidateSlot | FixedSlot, bool]]:
    """All that may ask to be held, in the order in which it is: candidates by number. Last stands
    whether the model says where it starts."""
    places, last = declared(program), len(program.columns)

    def rank(start: CandidateSlot | FixedSlot, fixed: bool) -> tuple[bool, int, int]:
        return not fixed, -start.select, places.get(start.display, last)

    found: list[tuple[tuple[bool, int, int], int | FixedSlot, CandidateSlot | FixedSlot]] = []
    found += [(rank(c, c.fixed), i, c) for i, c in enumerate(program.candidates)]
    found += [(rank(f, False), f, f) for f in program.fixed if not f.fixed]
    order = sorted(found, key=lambda entry: entry[0])
    return [(item, start, _says(start)) for _, item, start in order]


def is_written(start: CandidateSlot | FixedSlot, given: frozenset[int]) -> bool:
    """Whether the user has said where it starts, in the model or for this run."""
    return start.start in given or _says(start)


def weight_of(start: CandidateSlot | FixedSlot, written: bool) -> float:
    """The weight of a start value as a guide (`branch`)."""
    return WRITTEN if written else JOINT if start.select >= StateSelect.PREFER else OTHER


def _says(start: CandidateSlot | FixedSlot) -> bool:
    """Whether the model says where it starts."""
    return start.fixed or (start.written if isinstance(start, FixedSlot) else start.start_written)


@once
def declared(program: Program) -> dict[str, int]:
    """The place of each variable in the order of declaration."""
    return {c.name: i for i, c in reversed(list(enumerate(program.columns)))}


def are_velocities(program: Program, columns: Sequence[int]) -> bool:
    """Whether some candidates are all derivatives of others."""
    derivatives = {c.derivative for c in program.candidates}
    return all(program.candidates[c].slot in derivatives for c in columns)


def gradients(system: System, point: Vector, others: Sequence[FixedSlot]) -> Vector:
    """The derivatives of other variables by the candidates; zeros where they have none."""
    import numpy as np

    found = system.slopes(point, None, tuple(f.slot for f in others)) if others else None
    return np.zeros((len(others), len(point))) if found is None else found[system.rows :]
