"""The conditions at the start, as one function of all candidates, and its derivatives.

In:   Program, Kernel (parameters and start values set), the time
Out:  System    rows: the residuals of the blocks below the top, the initial equations, and
                the variables held that are no candidates

A native kernel makes a Jacobian by differences in one call; with another one the same
differences are made from Python, one evaluation each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from msgspec.structs import replace

from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.start import newton

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Rows (m, m2) below which a mechanism is nearly assembled.
ASSEMBLED = 1e-4
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
    ) -> None:
        import numpy as np

        self.follow = follow
        self.program, self.kernel, self.t, self.given = program, kernel, t, given
        self.rescue = Rescue(program, kernel) if rescue is None else rescue
        self.conditions = (*(f for f in program.fixed if f.fixed), *others)
        self.blocks = [(i, b) for i, b in enumerate(program.blocks) if b.height > 0]
        self.block_rows: dict[int, range] = {}
        count = 0
        for i, block in self.blocks:
            self.block_rows[i] = range(count, count + len(block.residuals))
            count += len(block.residuals)
        self.initial_rows = range(count, count + len(program.initial_residuals))
        count = self.initial_rows.stop
        self.fixed_rows = range(count, count + len(self.conditions))
        self.rows = self.fixed_rows.stop
        self._form = kernel.capabilities.start
        self._r = [math.nan] * max(1, self.initial_rows.stop)
        self._slots = tuple(f.slot for f in self.conditions)
        self._wanted = np.array([float(kernel.w[f.start]) for f in self.conditions])
        #: Whether a place counts where forces and accelerations have no value.
        self.forceless = False
        #: All derivatives at the last place where they were wanted, and of which variables.
        self._known: tuple[bytes, tuple[int, ...], Vector] | None = None

    def holding(self, others: Sequence[FixedSlot]) -> System:
        """The system with some more variables held."""
        if not others:
            return self
        return System(
            self.program, self.kernel, self.t, self.given, others, self.rescue, self.follow
        )

    def of_loops(self) -> System:
        """The loops alone, at any place, whatever forces and accelerations are there."""
        bare = replace(self.program, fixed=(), initial_residuals=())
        system = System(bare, self.kernel, self.t, self.given, rescue=self.rescue)
        system.forceless = True
        return system

    def written(self, start: CandidateSlot | FixedSlot) -> bool:
        """Whether the user has said where it starts, in the model or for this run."""
        said = start.written if isinstance(start, FixedSlot) else start.start_written
        return said or start.fixed or start.start in self.given

    @cached_property
    def asking(self) -> list[int | FixedSlot]:
        """All that asks to be held: fixed candidates (by number), then all that was written, by
        StateSelect and declaration."""
        return [item for item, start in _ranked(self.program) if self.written(start)]

    # Values

    def evaluate_flag(self, u: Vector) -> int:
        given = u.tolist()
        return self.rescue.overcome(self.t, lambda: self.kernel.residuals(self.t, given, self._r))

    def finite(self, u: Vector) -> bool:
        return all(map(math.isfinite, u.tolist())) and all(
            math.isfinite(self.kernel.w[c.derivative]) for c in self.program.candidates
        )

    def __call__(self, u: Vector) -> Vector | None:
        """All rows; None where one is not finite."""
        return self.values(u, ())

    def values(self, u: Vector, slots: tuple[int, ...]) -> Vector | None:
        """All rows, then the values of some variables. The workspace is left at `u`. None where
        these have no values, or forces and accelerations have none: but an assembled place
        counts all the same, since redundant bars leave forces open at all of them."""
        import numpy as np

        asked = (*self._slots, *slots)
        if self._form is not None:
            found = self._form.differences(self.t, u, (), asked, False)
            if found is None and self.evaluate_flag(u) == 0:  # with help
                found = self._form.differences(self.t, u, (), asked, False)
            whole = found is not None
            if found is None and self._is_below(asked):
                found = self._form.differences(self.t, u, (), asked, True)
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
        if not (whole or self.forceless) and abs(values).max(initial=0.0) > ASSEMBLED:
            return None
        if self._slots:
            values[self.fixed_rows.start : self.rows] -= self._wanted
        return values

    def root(self, u: Vector, rows: Sequence[int], columns: Sequence[int]) -> Vector | None:
        """A point beside `u` at which some rows vanish, with as many candidates moved; None where
        none is found straight on."""
        import numpy as np

        if self._form is None or len(rows) != len(columns):
            return None
        wanted = np.zeros(self.rows)
        wanted[self.fixed_rows.start :] = self._wanted
        return self._form.root(self.t, u, tuple(columns), self._slots, rows, wanted)

    def motions(self, u: Vector, part: float) -> Vector | None:
        """`newton.kernel_of` all conditions, where machine code tells it."""
        return None if self._form is None else self._form.motions(self.t, u, self._slots, part)

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

    def _differences(
        self, u: Vector, columns: tuple[int, ...], slots: tuple[int, ...]
    ) -> Vector | None:
        if self._form is not None:
            asked = (*self._slots, *slots)
            found = self._form.differences(self.t, u, columns, asked, self._is_below(asked))
            return None if found is None else found[1:].T
        full = u.copy()
        chosen = list(columns)

        def moved(z: Vector) -> Vector | None:
            full[chosen] = z
            return self.values(full, slots)

        here = self.values(u, slots)
        return None if here is None else newton.differences(moved, u[chosen], here)

    def _is_below(self, asked: Sequence[int]) -> bool:
        """Whether all rows are known before accelerations and forces are."""
        return not (self.initial_rows or asked)

    # Levels

    @cached_property
    def stages(self) -> list[Stage]:
        """Rows and candidates of each level, positions first, then of everything."""
        found: list[Stage] = []
        heights = sorted({b.height for _, b in self.blocks}, reverse=True)
        for height in heights:
            rows: list[int] = []
            columns: list[int] = []
            for i, block in self.blocks:
                if block.height == height:
                    rows.extend(self.block_rows[i])
                    columns.extend(range(block.first, block.first + len(block.tears)))
            conditions = zip(self.fixed_rows, self.conditions, strict=True)
            rows.extend(row for row, f in conditions if f.height == height)
            found.append((rows, columns))
        if self.initial_rows or self.fixed_rows or len(heights) > 2:
            found.append((list(range(self.rows)), list(range(len(self.program.candidates)))))
        return found


@once
def _ranked(program: Program) -> list[tuple[int | FixedSlot, CandidateSlot | FixedSlot]]:
    """All that may ask to be held, in the order in which it is: candidates by number."""
    places, last = declared(program), len(program.columns)

    def rank(start: CandidateSlot | FixedSlot, fixed: bool) -> tuple[bool, int, int]:
        return not fixed, -start.select, places.get(start.display, last)

    found: list[tuple[tuple[bool, int, int], int | FixedSlot, CandidateSlot | FixedSlot]] = []
    found += [(rank(c, c.fixed), i, c) for i, c in enumerate(program.candidates)]
    found += [(rank(f, False), f, f) for f in program.fixed if not f.fixed]
    return [(item, start) for _, item, start in sorted(found, key=lambda entry: entry[0])]


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
