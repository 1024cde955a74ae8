"""Variables of a result by component, with rates and integrals over its rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from planarc.core.arrays import Vector
from planarc.evaluate.record import whole
from planarc.evaluate.rows import RowValues, applied
from planarc.ir.expr import Expr, Op, symbol_text
from planarc.ir.insight import Track
from planarc.ir.result import Result


class Values:
    """The variables of a run, each worked out once. Rows at one time (an event) are never
    differenced."""

    def __init__(self, result: Result) -> None:
        self.result = result
        self.time = result.time
        self._rates: dict[tuple[int, int], Track] = {}
        self._declared: dict[tuple[str, int], Mapping[str, Mapping[str, Any]]] = {}
        self._evaluated: dict[Expr, Any] = {}
        slots = result.program.slots
        #: the slots of variables whose derivatives the result holds, too
        self._derivatives = {
            slots[name[4:-1]]: slot
            for name, slot in slots.items()
            if name.startswith("der(")
            and name[4:-1] in slots
            and (slot in result.stored or slot in result.constants)
        }

    def declared(self, kind: str, order: int = 0) -> Mapping[str, Mapping[str, Any]]:
        """The declarations of components of one kind, or its derivative: component, name, rows.

        A component of which something cannot be evaluated is left out.
        """
        if (kind, order) not in self._declared:
            self._declared[kind, order] = self._worked_out(kind, order)
        return self._declared[kind, order]

    def _worked_out(self, kind: str, order: int) -> Mapping[str, Mapping[str, Any]]:
        evaluator = _Declared(self, self._evaluated)
        found: dict[str, dict[str, Any]] = {}
        failed = set()
        for d in self.result.program.declared:
            if d.kind == kind:
                try:
                    own = found.setdefault(d.component, {})
                    own[d.name] = evaluator.derivative(d.value, order)
                except _Unknown:
                    failed.add(d.component)
        return {component: values for component, values in found.items() if component not in failed}

    def has(self, owner: str, *names: str) -> bool:
        columns = self.result.columns
        return all(f"{owner}.{name}" in columns for name in names)

    def get(self, name: str) -> Track:
        """A variable: a number where it never changes; KeyError if there is none."""
        return self.rate(name, 0)

    def pair(self, owner: str, name: str) -> tuple[Track, Track]:
        """A vector of the plane, as its two components."""
        return self.get(f"{owner}.{name}[1]"), self.get(f"{owner}.{name}[2]")

    def rate(self, name: str, order: int = 1) -> Track:
        """A derivative: the variable that is one, or else by differences; KeyError if none."""
        column = self.result.columns[name]
        return column.sign * self._rate(column.slot, order)

    def exactness(self, name: str, order: int = 2) -> int:
        """The number of derivatives of a variable, up to an order, that are no differences."""
        slot = self.result.columns[name].slot
        for exact in range(order):
            if slot not in self.result.stored:
                break  # constant
            if slot not in self._derivatives:
                return exact
            slot = self._derivatives[slot]
        return order

    def _rate(self, slot: int, order: int) -> Track:
        result = self.result
        if not order:
            return result.of_slot(slot)
        if slot not in result.stored:
            return 0.0
        if slot in self._derivatives:
            return self._rate(self._derivatives[slot], order - 1)
        if (slot, order) not in self._rates:
            lower = self._rate(slot, order - 1)
            self._rates[slot, order] = self.slope(lower)
        return self._rates[slot, order]

    def slope(self, track: Track) -> Track:
        """The derivative of rows, by differences."""
        return 0.0 if isinstance(track, float) else rate(self.time, track)

    def full(self, value: Track) -> Vector:
        """A value as a row for each of the result's."""
        return value + 0.0 * self.time if isinstance(value, float) else value


class _Unknown(Exception):
    """An expression holds what the result does not tell."""


def _applied(e: Expr, args: Sequence[Any]) -> Any:
    try:
        return applied(e, args)
    except KeyError:  # a function of the user's own that could not be inlined
        raise _Unknown from None


class _Declared(RowValues):
    """The values of expressions; derivatives that the result does not hold are differences."""

    def __init__(self, values: Values, known: dict[Expr, Any]) -> None:
        super().__init__(self._variable, _applied)
        self._rows, self._values = values, known

    def derivative(self, value: Any, order: int) -> Any:
        """The derivative of a value; of a vector that of each component."""
        if isinstance(value, tuple):
            return tuple(self.derivative(item, order) for item in value)
        found = self(value)
        if order and value.is_symbol:
            return self._variable(value, order)
        for _ in range(order):
            found = self._rows.slope(found)
        return found

    def _variable(self, e: Expr, order: int = 0) -> Any:
        result = self._rows.result
        if e.op is Op.TIME:
            return result.time
        if e.op is Op.EVENT:
            raise _Unknown
        name, own = (e.data, 0) if e.op is Op.PRE else e.data
        held = symbol_text(name, own)
        if held not in result:
            held, order = name, order + own
        if held not in result:
            raise _Unknown
        return self._rows.rate(held, order)


@whole("rate")
def rate(time: Vector, values: Vector) -> Vector:
    """d(values)/d(time), second order, on each side of an event by itself."""
    steps = np.diff(time)
    if len(time) > 2 and steps.min() > 0:
        return np.gradient(values, time, edge_order=2)
    # Parabolas through three rows at a time, for all pieces at once: a run may have many events.
    joined = np.concatenate([[False], steps > 0, [False]])  # before and behind each row
    before, behind = joined[:-1], joined[1:]
    chords = np.diff(values) / np.where(steps > 0, steps, 1.0)
    found = np.zeros(len(time))
    inner = np.flatnonzero(before & behind)
    left, right = steps[inner - 1], steps[inner]
    found[inner] = (right * chords[inner - 1] + left * chords[inner]) / (left + right)
    # At an end the chord there, and as much further as the slope in the middle differs from it.
    for ends, chord, neighbour in ((behind & ~before, 0, 1), (before & ~behind, -1, -1)):
        at = np.flatnonzero(ends)
        found[at] = chords[at + chord]
        beyond = at + neighbour
        more = before[beyond] & behind[beyond]
        found[at[more]] = 2 * found[at[more]] - found[beyond[more]]
    return found


def jumps(time: Vector, values: Vector) -> Vector:
    """By how much values jump at each row: at the second one of an instant, 0 elsewhere."""
    found = np.diff(values, prepend=values[:1])
    found[np.diff(time, prepend=-np.inf) > 0] = 0.0
    return found


@whole("integral")
def integral(time: Vector, values: Vector) -> Vector:
    """The integral from the first row, by cubics through values and slopes (order four)."""
    slopes = rate(time, values)
    h = np.diff(time)
    pieces = h / 2 * (values[1:] + values[:-1]) + h**2 / 12 * (slopes[:-1] - slopes[1:])
    return np.concatenate([[0.0], np.cumsum(pieces)])
