"""Values as a user writes them in Python, made into numbers by name, or refused.

An array parameter takes a sequence: `{"rod.r": [0.5, 0]}` sets `rod.r[1]` and `rod.r[2]`.
Truth values and the names of enumeration literals are taken too, and values with a unit: texts such
as `"20cm"`, and quantities of pint.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from planarc.core.diagnostic import Diagnostic, UsageError, usage_error
from planarc.core.options import Backend, RunOptions
from planarc.core.prose import ticked
from planarc.core.unknown import UnknownName, unknown_name
from planarc.ir.dae import Kind
from planarc.ir.once import once
from planarc.ir.program import ParameterSlot, Program, literals_of
from planarc.solve.deciding import not_to_be_set

#: A number, one with a unit as text (`"20cm"`) or of pint, a truth value, the name of an
#: enumeration literal, or a (nested) sequence of them.
Value: TypeAlias = "float | bool | str | Sequence[Any] | Any"

_START = ".start"
_TRUTH = {"true": 1.0, "false": 0.0}


@once
def slots_of(program: Program) -> Mapping[str, ParameterSlot]:
    """The parameters of a program by name."""
    return {p.name: p for p in program.parameter_slots}


@once
def _variables(program: Program) -> Mapping[str, Any]:
    """The variables that have a start value by name: columns, and candidates that are none."""
    columns = {c.name: c for c in program.columns}
    return columns | {c.name: c for c in program.candidates if c.name not in columns}


@once
def _without_start(program: Program) -> frozenset[str]:
    """Parameters that have a value, not a start; one with `fixed=false` has a start, too."""
    free = {c.display for c in program.candidates} | {f.display for f in program.fixed}
    return frozenset(slots_of(program)) - free


def _unit(variable: Any) -> str:
    return getattr(variable, "unit", "")


def parameter_values(program: Program, given: Mapping[str, Value] | None) -> dict[str, float]:
    """Values by the names of scalar parameters. Raises UsageError (C201 to C203)."""
    known = slots_of(program)
    result: dict[str, float] = {}
    for name, value in _scalars(by_name(given), known, "parameter", program):
        result[name] = value_of(known[name], value)
    return result


def value_of(parameter: ParameterSlot, value: Value) -> float:
    """The number of a value of a parameter, in its unit. Raises UsageError."""
    _refuse_truth(parameter.name, parameter.kind, parameter.literals, value)
    if parameter.kind is Kind.BOOLEAN and isinstance(value, str):
        return _truth(parameter.name, value)
    return _number(parameter.name, value, parameter.literals, parameter.unit)


def plain_value(program: Program, name: Any, value: Any) -> Any:
    """The number of a value with a unit, of a parameter or a start value; any other as it is."""
    from planarc.core.quantity import split

    with_unit = hasattr(value, "to_base_units") or (isinstance(value, str) and split(value))
    if not with_unit or is_sequence(value) or not isinstance(name, str):
        return value
    known: Mapping[str, Any] = slots_of(program)
    if name not in known:
        name, known = name.removesuffix(_START), _variables(program)
    return _number(name, value, (), _unit(known[name])) if name in known else value


def _refuse_truth(name: str, kind: Kind, literals: Sequence[str], value: Any) -> None:
    """Refuse truth values, with which Python counts as with numbers."""
    truth = isinstance(value, bool) or type(value).__name__ in ("bool_", "bool")
    if truth and kind is not Kind.BOOLEAN:
        word = "true" if value else "false"
        wanted = "an integer" if kind is Kind.INTEGER else "a number"
        if literals:
            wanted = f"one of {ticked(literals)}"
        raise usage_error("C202", f"`{name}` takes {wanted}, not {word}")


def _truth(name: str, value: str) -> float:
    """The number of `true` or `false` as a text. Raises UsageError."""
    if value not in _TRUTH:
        meant = value.lower()
        hint = f"write `{meant}`" if meant in _TRUTH else None
        raise usage_error("C202", f"`{name}` takes true or false, not `{value:.60}`", hint=hint)
    return _TRUTH[value]


def start_values(program: Program, given: Mapping[str, Value] | None) -> dict[str, float]:
    """Start values by the names of variables; `x.start` is understood as `x`."""
    known = _variables(program)
    plain = {
        n.removesuffix(_START) if isinstance(n, str) and n not in known else n: v
        for n, v in by_name(given).items()
    }
    _refuse_parameters(plain, program)
    result: dict[str, float] = {}
    for name, value in _scalars(plain, known, "variable", program):
        kind = getattr(known[name], "kind", Kind.REAL)
        literals = literals_of(program).get(name, ())
        own = f"{name}{_START}"
        _refuse_truth(own, kind, literals, value)
        is_word = kind is Kind.BOOLEAN and isinstance(value, str)
        result[name] = (
            _truth(own, value) if is_word else _number(own, value, literals, _unit(known[name]))
        )
    return result


def _refuse_parameters(given: Iterable[str], program: Program) -> None:
    """Refuse start values of parameters that have none."""
    for name in given:
        if name in _without_start(program):
            raise usage_error(
                "C213",
                f"`{name}` is a parameter: it has a value, and no start value",
                hint=f'set it: parameters={{"{name}": ...}}, or `--set {name}=...`',
            )


def finite(name: str, value: Any, unit: str = "") -> float:
    """A number, or UsageError; `unit` is that of numbers, in which other units are taken."""
    return _number(name, value, (), unit)


def count(name: str, value: Any) -> int | None:
    """A whole number, or None where none is given. Raises UsageError."""
    if value is None:
        return None
    number = finite(name, value)
    if number != int(number):
        raise usage_error("C202", f"`{name}` takes an integer, not {number:g}")
    return int(number)


def run_options(
    backend: Backend,
    start_time: Any,
    stop_time: Any,
    tolerance: Any,
    intervals: Any,
    **checked: Any,
) -> RunOptions:
    """The options that a user gives a run, with more options that were checked already."""
    return RunOptions(
        start=None if start_time is None else finite("start_time", start_time, "s"),
        stop=None if stop_time is None else finite("stop_time", stop_time, "s"),
        tolerance=None if tolerance is None else finite("tolerance", tolerance),
        intervals=count("intervals", intervals),
        backend=backend,
        **checked,
    )


def by_name(
    given: Any, what: str = "parameters and start values", example: str = "rod.L"
) -> Mapping[str, Any]:
    """The given values as a mapping, or UsageError."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise usage_error(
            "C202",
            f"{what} are given by name, not as {type(given).__name__}",
            hint=f'write them as {{"{example}": 0.5}}',
        )
    return given


def _scalars(
    given: Mapping[str, Value], known: Mapping[str, Any], kind: str, program: Program
) -> Iterable[tuple[str, Any]]:
    for name, value in given.items():
        if name in known:
            if is_sequence(value) and getattr(value, "shape", None) != ():
                raise _shape(name, "one number", value)
            yield name, value
            continue
        elements = elements_of(name, known) if isinstance(name, str) else {}
        told = not_to_be_set(program, str(name)) if kind == "parameter" else None
        if elements:
            yield from spread(name, value, elements)
        elif told is not None:
            raise UnknownName(Diagnostic("C201", told[0], hint=told[1]))
        elif kind == "parameter" and any(c.name == name for c in program.columns):
            is_input = name in program.inputs or any(
                d.name == name and d.given is not None for d in program.discretes
            )
            hint = f"give its start value: `--set {name}.start=...` (in Python "
            hint += f'`start={{"{name}": ...}}`)'
            if is_input:
                hint = f'in Python give it a number or a signal: `inputs={{"{name}": ...}}`; '
                hint += f"`--set {name}.start=...` gives it one value"
            what = "an input" if is_input else "a variable"
            message = f"`{name}` is {what}, not a parameter"
            raise UnknownName(Diagnostic("C201", message, hint=hint))
        else:
            raise unknown_name(kind, name, known)


def elements_of(name: str, known: Iterable[str]) -> dict[tuple[int, ...], str]:
    """The scalars of an array by their subscripts: `a[1].n[3]` is (1, 3) of `a.n`."""
    parts = (
        p if p.endswith(r"\]") else rf"{p}(?:\[([\d,]+)\])?" for p in re.escape(name).split(r"\.")
    )
    pattern = re.compile(r"\.".join(parts))
    found = ((n, pattern.fullmatch(n)) for n in known)
    return {
        tuple(int(i) for group in match.groups() if group for i in group.split(",")): n
        for n, match in found
        if match
    }


def spread(
    name: str, value: Any, elements: Mapping[tuple[int, ...], str]
) -> Iterable[tuple[str, Any]]:
    """The scalars of an array, by their names. Raises UsageError C203."""
    found: dict[tuple[int, ...], Any] = {}
    stack: list[tuple[tuple[int, ...], Any]] = [((), value)]
    while stack:
        at, item = stack.pop()
        if not is_sequence(item):
            found[at] = item
            continue
        stack.extend(((*at, i), part) for i, part in enumerate(item, 1))
    if found.keys() != elements.keys():
        names, count = list(elements.values()), str(len(elements))
        if len(last := max(elements)) > 1 and math.prod(last) == len(names):
            count = " x ".join(map(str, last))
        raise _shape(name, f"{count} numbers, `{names[0]}` to `{names[-1]}`", value)
    return [(n, found[at]) for at, n in elements.items()]


def is_sequence(value: Any) -> bool:
    if hasattr(value, "to_base_units"):  # a number of pint says that it may be an array
        return getattr(value, "ndim", 0) > 0
    return not isinstance(value, str | bytes) and hasattr(value, "__iter__")


def _shape(name: str, wanted: str, value: Any) -> UsageError:
    given = getattr(value, "shape", None)
    what = f"a value of shape {given}" if given is not None else f"{value!r:.60}"
    if given is None and (sizes := _sizes(value)):
        what = f"{' x '.join(map(str, sizes))}: {what}"
    return usage_error("C203", f"`{name}` takes {wanted}, not {what}")


def _sizes(value: Any) -> tuple[int, ...]:
    """The lengths of nested sequences, as deep as all of one depth have the same."""
    if not isinstance(value, Sequence) or isinstance(value, str | bytes):
        return ()
    inner = {_sizes(item) for item in value if is_sequence(value)}
    return (len(value), *(inner.pop() if len(inner) == 1 else ()))


def _number(name: str, value: Any, literals: Sequence[str], unit: str = "") -> float:
    if type(value) is float and math.isfinite(value):
        return value
    if isinstance(value, str):
        short = {n.rpartition(".")[2]: i for i, n in enumerate(literals, 1)}
        if value.rpartition(".")[2] in short:
            return float(short[value.rpartition(".")[2]])
        if literals:
            raise unknown_name(f"value of `{name}` called", value, short)
    if isinstance(value, str) or hasattr(value, "to_base_units"):
        from planarc.core import quantity

        with_unit = (
            quantity.in_unit(name, value, unit)
            if isinstance(value, str)
            else quantity.of_pint(name, value, unit)
        )
        value = value if with_unit is None else with_unit
    try:
        number = float("" if isinstance(value, str | bytes) else value)
    except OverflowError:
        number = math.inf
    except (TypeError, ValueError):
        point = str(value).replace(",", ".")
        hint = f"write a decimal point: {point}" if re.fullmatch(r"-?\d+\.\d+", point) else None
        message = f"`{name}` takes a number, not `{value!s:.60}`"
        raise usage_error("C202", message, hint=hint) from None
    if not math.isfinite(number):
        raise usage_error("C202", f"`{name}` must be a finite number, not {number:g}")
    return number
