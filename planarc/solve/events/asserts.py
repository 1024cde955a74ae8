"""Assertions of the model, checked at every row.

Conditions are evaluated for many new rows at once, over whole columns: a model may
hold hundreds of assertions, and nearly all of them always hold. Those of parameters
alone are looked at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from msgspec import Struct
from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic
from planarc.ir.dae import Assertion
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel, Taker
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.runtime.texts import formatted
from planarc.solve.messages.text import Reader, taker_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.core.arrays import Vector


class Rows(Protocol):
    """The rows of a recorder: `count` of them, and the column of each slot."""

    time: Vector
    data: Vector
    stored: dict[int, int]

    @property
    def count(self) -> int: ...


#: Rows that are gathered before they are looked at.
ENOUGH = 200


class _Broken(Struct):
    """A warning, with the stretches of time during which it applied."""

    first: Diagnostic
    stretches: int = 0
    seconds: float = 0.0
    last: float = -math.inf  # the last row at which it applied
    end: float = -math.inf  # the last row that was looked at

    def add(self, time: Vector, broken: NDArray[np.bool_]) -> None:
        """Rows in their order; rows side by side that are both broken make a stretch."""
        previous = bool(self.stretches) and self.last == self.end
        for t, bad in zip(time.tolist(), broken.tolist(), strict=True):
            if bad:
                if previous:
                    self.seconds += t - self.last
                else:
                    self.stretches += 1
                self.last = t
            previous = bad
        self.end = float(time[-1])

    def told(self) -> Diagnostic:
        if self.seconds == 0.0:
            return self.first
        times = "once" if self.stretches == 1 else f"{self.stretches} times"
        message = f"{self.first.message} ({times}, {self.seconds:.3g} s in all)"
        return replace(self.first, message=message)


class AssertWatch:
    """The assertions of a run. `slots` are those that the recorder must store for the conditions'
    sake."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self._program, self._kernel = program, kernel
        self._warned: dict[int, _Broken] = {}
        self._checked = 0
        self._varying, self._constant, self.slots = _sorted_out(program)
        self._judged = _judged(program)
        self._active: Sequence[int] | None = None  # not looked at yet

    def check(self, recorder: Rows, all_rows: bool) -> tuple[list[Diagnostic], int]:
        """Failures in the new rows, and the row of the first error; warnings are gathered.

        Unless `all_rows` are to be looked at, a few new ones wait for more.
        """
        last = recorder.count
        first = min(self._checked, last)  # rows behind a failure were taken back
        if self._active is None and first < last:
            # What parameters alone break is the reason of what else is broken.
            self._active = (*self._broken_constants(), *self._varying)
        if not self._active or first == last or not (all_rows or last - first >= ENOUGH):
            return [], last
        import numpy as np

        self._checked = last
        found: list[Diagnostic] = []
        end: tuple[int, Diagnostic] | None = None
        columns = _Columns(self._program, self._kernel, recorder, first, last)
        active, self._active = self._active, self._varying
        for i in active:
            assertion = self._program.assertions[i]
            holds = np.broadcast_to(np.asarray(columns(assertion.condition)), (last - first,))
            if np.all(holds):
                continue
            row = int(np.argmin(holds.astype(bool)))
            if assertion.warning:
                if i not in self._warned:
                    self._warned[i] = _Broken(self._diagnostic(assertion, columns, row))
                self._warned[i].add(columns.time, ~holds.astype(bool))
                continue
            diagnostic = self._diagnostic(assertion, columns, row)
            if end is None or first + row < end[0]:
                end = first + row, diagnostic
        if end is not None:
            found.append(end[1])
        return found, end[0] if end else last

    def _broken_constants(self) -> list[int]:
        """The assertions of parameters alone that do not hold, or have no value. The last judgement
        is good as long as these have their values."""
        take, known = self._judged
        if take is None:
            return self._judge_constants()
        values = take(self._kernel.w)
        found = known.get(values)
        if found is None:
            known.clear()
            found = known[values] = self._judge_constants()
        return found

    def _judge_constants(self) -> list[int]:
        read = Reader(self._program, self._kernel, 0.0)
        found = []
        for i in self._constant:
            try:
                holds = read(self._program.assertions[i].condition)
            except (ArithmeticError, ValueError):
                holds = False
            if not holds:
                found.append(i)
        return found

    def forget(self, count: int) -> None:
        """The rows from `count` on were taken back."""
        self._checked = min(self._checked, count)

    def warnings(self) -> list[Diagnostic]:
        """Assertions of the level warning that did not hold: since when, and how long in all."""
        return [self._warned[i].told() for i in sorted(self._warned)]

    def _diagnostic(self, assertion: Assertion, columns: _Columns, row: int) -> Diagnostic:
        import numpy as np

        from planarc.solve.messages.assertion import assertion_diagnostic

        def value(e: Expr) -> float:
            found = np.atleast_1d(columns(e))
            return float(found[row if len(found) > 1 else 0])  # what does not change has one row

        parts = [
            part if isinstance(part, str) else formatted(value(part[0]), part[1])
            for part in assertion.message.parts
        ]
        t = float(columns.time[row])
        return assertion_diagnostic(
            self._program, t, assertion, "".join(parts), self._kernel, value
        )


def of_parameters(program: Program) -> tuple[int, ...]:
    """The assertions that a run cannot change."""
    return _sorted_out(program)[1]


@once
def _sorted_out(program: Program) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
    """The assertions that may change during a run; the others; the slots that the first ones
    need stored."""
    constant = {c.slot for c in program.columns if c.constant}
    constant |= {p.slot for p in program.parameter_slots}
    needed: dict[int, None] = {}
    varying, others = [], []
    for i, assertion in enumerate(program.assertions):
        if any(_varies(e, program, constant) for e in postorder((assertion.condition,))):
            varying.append(i)
        else:
            others.append(i)
        texts = (p[0] for p in assertion.message.parts if not isinstance(p, str))
        for e in postorder((assertion.condition, *texts)):
            if not e.args and e.op not in (Op.CONST, Op.TIME):
                slot = program.slots.get(repr(e))
                if slot is not None and slot not in constant:
                    needed[slot] = None
    return tuple(varying), tuple(others), tuple(needed)


@once
def _judged(program: Program) -> tuple[Taker | None, dict[tuple[float, ...], list[int]]]:
    """What takes the parameters that assertions of these alone ask, and which of these were broken
    by such values; None where functions are called that may look at more."""
    conditions = [program.assertions[i].condition for i in _sorted_out(program)[1]]
    return taker_of(program.slots, conditions), {}


def impossible_parameters(
    program: Program, kernel: Kernel, t: float, warnings: bool = False
) -> Diagnostic | None:
    """The first error, or warning, among the assertions on parameters alone, before there is a
    start.

    Where a start cannot be found, this is the reason: a radius of zero, a rod without length.
    """
    constant = {c.slot for c in program.columns if c.constant}
    constant |= {p.slot for p in program.parameter_slots}
    read = Reader(program, kernel, t)
    for assertion in program.assertions:
        nodes = postorder((assertion.condition,))
        if assertion.warning is not warnings or any(_varies(e, program, constant) for e in nodes):
            continue
        try:
            holds = bool(read(assertion.condition))
        except (ArithmeticError, ValueError):
            continue
        if not holds:
            from planarc.solve.messages.assertion import assertion_diagnostic

            parts = (
                part if isinstance(part, str) else formatted(float(read(part[0])), part[1])
                for part in assertion.message.parts
            )
            return assertion_diagnostic(program, t, assertion, "".join(parts), kernel, read)
    return None


def _varies(e: Expr, program: Program, constant: set[int]) -> bool:
    """Whether a leaf changes during the run."""
    if e.op is Op.TIME:
        return True
    return not e.args and e.op is not Op.CONST and program.slots.get(repr(e)) not in constant


class _Columns:
    """Values of expressions over the rows `first` to `last`."""

    def __init__(
        self, program: Program, kernel: Kernel, recorder: Rows, first: int, last: int
    ) -> None:
        from planarc.evaluate.rows import RowValues

        self.time = recorder.time[first:last]
        self._rows = recorder.data[first:last]
        self._stored, self._slots = recorder.stored, program.slots
        self._read = Reader(program, kernel, 0.0)
        self._values = RowValues(self._leaf)  # conditions share much

    def __call__(self, root: Expr) -> Any:
        import numpy as np

        with np.errstate(all="ignore"):
            return self._values(root)

    def _leaf(self, e: Expr) -> float | Vector:
        if e.op is Op.TIME:
            return self.time
        slot = self._slots.get(repr(e))
        if slot in self._stored:
            return self._rows[:, self._stored[slot]]
        return self._read.leaf(e)
