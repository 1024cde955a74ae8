"""The result of a run: columns over time, and what happened on the way.

Values of variables that do not change are stored once; variables that are equal
or opposite share one stored column.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.ir.insight import Track
    from planarc.ir.program import Column, Program


class EventRecord(Data):
    """An instant at which something switched. `causes` tells what happened, in words of the
    components that declare these (`insight.happenings`), else the relations; `owners` are the
    components of relations that switched, in their order."""

    time: float
    causes: tuple[str, ...]
    owners: tuple[str, ...] = ()


class StateChoice(Data):
    """The states (user's names) from `time` on."""

    time: float
    states: tuple[str, ...]


class Held(Data):
    """The use of a start value: held exactly, or a guess that moved by `moved`."""

    name: str
    start: float
    value: float
    held: bool


class Statistics(Data):
    solver: str  # the one that ran, e.g. `cvode-bdf (native)`
    backend: str
    steps: int | None = 0  # None where nobody counted them
    rhs_calls: int = 0
    jacobians: int = 0
    error_test_failures: int = 0
    events: int = 0
    reason: str = ""  # why this solver

    @property
    def effort(self) -> str:
        """Steps and events, as a summary tells them."""
        return f"{'not counted' if self.steps is None else self.steps}, events {self.events}"


class Interrupted(Diagnostic):
    """The end of a run at Ctrl-C."""


class Result(Data, dict=True):
    """`data` has a row for each of `time` and a column for each of `stored`, the slots."""

    program: Program
    time: Vector
    data: Vector
    stored: Mapping[int, int]  # slot -> column of data
    constants: Mapping[int, float]  # slot -> value, of slots that never change
    statistics: Statistics
    states: tuple[StateChoice, ...] = ()
    held: tuple[Held, ...] = ()
    events: tuple[EventRecord, ...] = ()
    warnings: tuple[Diagnostic, ...] = ()
    #: why the run ended before its stop time (None: it did not), as an error or a note
    ended: Diagnostic | None = None
    #: a loop came near to a pose in which it can go on in several ways
    near_singular: bool = False

    @cached_property
    def columns(self) -> Mapping[str, Column]:
        return {c.name: c for c in self.program.columns}

    def __getitem__(self, name: str) -> Vector:
        """The values of a variable over `time` (shape: rows); KeyError if there is none."""
        import numpy as np

        if name == "time":
            return self.time
        column = self.columns[name]
        if column.slot in self.stored:
            values: Vector = self.data[:, self.stored[column.slot]]
            return values if column.sign > 0 else -values
        return np.full(len(self.time), column.sign * self.constants[column.slot])

    def of_slot(self, slot: int) -> Track:
        """What a slot holds: a number where it never changes."""
        if slot in self.stored:
            values: Vector = self.data[:, self.stored[slot]]
            return values
        return float(self.constants[slot])

    def track(self, name: str) -> Track:
        """A variable: a number where it never changes; KeyError if there is none."""
        column = self.columns[name]
        values = self.of_slot(column.slot)
        return values if column.sign > 0 else -values

    def __contains__(self, name: str) -> bool:
        return name == "time" or name in self.columns
