"""The inputs of a model, and what a user gives them: signals, or one value for a whole run.

A Real input follows a signal. Booleans, Integers and enumerations change at events only, of which
a signal tells none: they take one value, as parameters do.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from planarc.api.values import by_name, elements_of, is_sequence, spread, value_of
from planarc.core.diagnostic import usage_error
from planarc.core.unknown import refuse_unknown
from planarc.ir.dae import Kind
from planarc.ir.once import once
from planarc.ir.program import ParameterSlot, Program
from planarc.solve.settings import of_kind

if TYPE_CHECKING:
    from planarc.api.signals import Signal

_Given: TypeAlias = "Mapping[str, Signal | bool | str | Any]"


@once
def held_inputs(program: Program) -> Mapping[str, ParameterSlot]:
    """Those that change at events only, by name, as what a user may set."""
    literals = {n: e.literals for e in program.enumerations for n in e.members}
    return {
        d.name: ParameterSlot(
            d.name, d.slot, d.kind, True, False, literals=literals.get(d.name, ())
        )
        for d in program.discretes
        if d.given is not None
    }


def input_names(program: Program) -> tuple[str, ...]:
    """All inputs of a model, those that follow signals first."""
    return (*program.inputs, *held_inputs(program))


def sort_inputs(
    program: Program, given: _Given | None
) -> tuple[dict[str, float], dict[str, Signal]]:
    """The values of those that are held in a run, and the signals of the others.

    Raises UnknownName, and UsageError (C202, C203, C210, R409) for what an input does not take.
    """
    held, known = held_inputs(program), input_names(program)
    values: dict[str, float] = {}
    signals: dict[str, Signal] = {}
    named = by_name(given, "inputs and their values", "hinge.tau")
    for name, signal in _scalars(named, known).items():
        if name in held:
            values[name] = held_value(held[name], signal)
        else:
            signals[name] = signal
    return values, signals


def held_value(held: ParameterSlot, value: Any) -> float:
    """The number of a value of such an input."""
    if callable(value) or (is_sequence(value) and getattr(value, "shape", None) != ()):
        raise usage_error(
            "C210",
            f"`{held.name}` is {_KINDS[held.kind]}: it takes one value for the whole run, and no"
            " signal",
            hint="set it between the steps of a `stepper`, or let it follow from a Real input",
        )
    return of_kind(held.name, held.kind, held.literals, value_of(held, value))


_KINDS = {
    Kind.BOOLEAN: "a Boolean",
    Kind.INTEGER: "an Integer",
    Kind.ENUMERATION: "an enumeration",
    Kind.REAL: "a discrete Real",
}


def _scalars(given: _Given, known: tuple[str, ...]) -> Mapping[str, Any]:
    """The given signals of scalars; an array may be given one for each of its elements."""
    found: dict[str, Any] = {}
    for name, signal in given.items():
        elements = elements_of(name, known) if isinstance(name, str) and name not in known else {}
        if elements:
            found.update(spread(name, signal, elements))
        else:
            refuse_unknown("input", (name,), known)
            found[name] = signal
    return found
