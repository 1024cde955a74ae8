"""What is asked of a run, checked against the model, with every default filled in.

In:   Program, RunOptions
Out:  Request    times, rows, tolerance, values of parameters, start values by slot

Everything that the user can have misspelt or contradicted is found here, before
anything is computed, and says which names there are.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, UsageError, said
from planarc.core.options import FIXED_STEP, MOST_ROWS, Contacts, RunOptions, Solver
from planarc.core.prose import either, listed, ticked
from planarc.ir.dae import LARGEST_INTEGER, START_TIME, Impact, Kind
from planarc.ir.expr import Op, postorder
from planarc.ir.once import once
from planarc.ir.program import Column, Let, ParameterSlot, Program, literals_of
from planarc.solve.deciding import deciding, given_by, not_to_be_set, start_meant

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.ir.kernel import Kernel

DEFAULT_INTERVALS = 500
#: How a parameter is set whose values make other models.
_FOR_ALL = "give it one value for all runs, with `--set` or, in Python, `parameters={...}`"
#: Steps with contacts in a run, where their length is not given.
DEFAULT_STEPS = 1000


class Request(Data):
    start: float
    stop: float
    grid: Vector  # the times of the rows, from start to stop
    tolerance: float
    solver: Solver
    fixed_step: float | None
    values: Mapping[int, float]  # slot of a parameter -> value
    starts: Mapping[int, float]  # slot of a start value -> value
    near: tuple[float, ...] | None = None  # of the candidates, a good guess
    stepping: bool = False  # contacts by steps of the fixed length

    @property
    def span(self) -> float:
        return self.stop - self.start


def resolve(program: Program, options: RunOptions) -> Request:
    """The request with every default filled in. Raises `UsageError` (R401 to R407)."""
    given = program.experiment
    start = given.start if options.start is None else options.start
    stop = given.stop if options.stop is None else options.stop
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise _usage("R401", f"the times must be finite numbers, not {start:g} and {stop:g}")
    if stop < start:
        raise _usage(
            "R401",
            f"the stop time {stop:g} s lies before the start time {start:g} s",
            "give a stop time after the start time",
        )
    tolerance = given.tolerance if options.tolerance is None else options.tolerance
    if not 1e-14 <= tolerance < 1:
        raise _usage(
            "R402",
            f"the tolerance must lie between 1e-14 and 1, not {tolerance:g}",
            "choose for example 1e-6",
        )
    stepping = _stepping(program, options)
    solver, length = _solver(options, stepping), options.fixed_step
    if stepping and length is None:
        length = (stop - start) / DEFAULT_STEPS or 1.0
    return Request(
        start=start,
        stop=stop,
        grid=_grid(start, stop, given.interval, options),
        tolerance=tolerance,
        solver=solver,
        fixed_step=length,
        values=_start_time(program, start) | _parameter_values(program, options.values),
        starts=_start_values(program, options.starts),
        near=options.near if len(options.near or ()) == len(program.candidates) else None,
        stepping=stepping,
    )


def _stepping(program: Program, options: RunOptions) -> bool:
    """Whether contacts are stepped: where that is asked for, and where a crowd needs it."""
    crowd = _crowd(program)
    if crowd and options.contact is Contacts.EVENTS:
        from planarc.ir.places import own_part

        part = own_part(program, crowd.component)
        message = f"`{crowd.component}` knows no events: a crowd is run step by step"
        hint = "leave `--contact events` out, or write a Contact for each pair"
        raise UsageError(Diagnostic("R483", message, part.span if part else crowd.span, hint=hint))
    return options.contact is Contacts.STEPPING or crowd is not None


@once
def _crowd(program: Program) -> Impact | None:
    """The first body of a crowd."""
    branches = (b for when in program.whens for b in when.branches)
    actions = (a for *_, found in branches for a in found)
    return next((a for a in actions if isinstance(a, Impact) and a.crowd), None)


def _solver(options: RunOptions, stepping: bool) -> Solver:
    """The solver, where a step of fixed length and its method agree."""
    length, solver = options.fixed_step, options.solver
    if stepping and not solver.home and options.contact is None and length is None:
        return solver  # an exported model has the length of its steps
    if stepping and not solver.home:
        raise _usage(
            "R407",
            f"the solver `{solver}` takes contacts as exported models do",
            "leave the fixed step and the treatment of contacts out",
        )
    if stepping and solver is not Solver.AUTO:
        raise _usage(
            "R407",
            f"the solver `{solver}` knows no steps with contacts",
            "leave `--solver` out: stepping has a method of its own",
        )
    if length is None:
        if solver in FIXED_STEP:
            raise _usage(
                "R407",
                f"the solver `{solver}` needs the length of its steps",
                "give one, for example a fixed step of 1e-3 s: `--fixed-step 1e-3`",
            )
        return solver
    if not (math.isfinite(length) and length > 0):
        raise _usage("R407", f"a fixed step must be a time above 0 s, not {length:g}")
    if solver is Solver.AUTO:
        return Solver.RK4
    if solver not in FIXED_STEP:
        raise _usage(
            "R407",
            f"the solver `{solver}` chooses its steps itself",
            f"take {either(f'--solver {s}' for s in FIXED_STEP)} with a fixed step",
        )
    return solver


def _usage(code: str, message: str, hint: str | None = None) -> UsageError:
    return UsageError(Diagnostic(code, message, hint=hint))


def _grid(start: float, stop: float, default: float | None, options: RunOptions) -> Vector:
    import numpy as np

    if options.interval is not None and options.intervals is not None:
        raise _usage("R403", "both an interval and a number of intervals are given", "give one")
    interval = options.interval if options.intervals is None else None
    if options.interval is None and options.intervals is None:
        interval = default
    if stop == start:
        return np.array([start])
    if interval is None:
        count = DEFAULT_INTERVALS if options.intervals is None else options.intervals
        if count < 1:
            raise _usage("R403", f"the number of intervals must be at least 1, not {count}")
        _limit_rows(count)
        return _even(start, stop, count)
    if not (math.isfinite(interval) and interval > 0):
        raise _usage("R403", f"the interval must be a time above 0 s, not {interval:g}")
    _limit_rows((stop - start) / interval)
    count = int((stop - start) / interval + 1e-9)
    times = start + interval * np.arange(count + 1.0)
    if stop - times[-1] > 1e-9 * interval:
        return np.concatenate([times, np.array([stop])])
    times[-1] = stop
    return times


@lru_cache(maxsize=1)
def _even(start: float, stop: float, count: int) -> Vector:
    import numpy as np

    times: Vector = start + (stop - start) / count * np.arange(count + 1.0)
    times[-1] = stop
    return times


def _limit_rows(rows: float) -> None:
    if rows > MOST_ROWS:
        raise _usage("R408", f"{rows:.3g} rows are too many", "choose a longer interval")


def _parameter_values(program: Program, given: Mapping[str, float]) -> dict[int, float]:
    if not given:
        return {}
    known = parameters_of(program)
    settable = ((_settable(known, program, name), value) for name, value in given.items())
    return {p.slot: of_kind(p.name, p.kind, p.literals, value) for p, value in settable}


def _start_time(program: Program, start: float) -> dict[int, float]:
    """The time of the start, where parameters or start values depend on it."""
    slot = program.slots.get(START_TIME)
    return {} if slot is None else {slot: start}


def of_kind(name: str, kind: Kind, literals: Sequence[str], value: float) -> float:
    """The number of a value: a truth value is 0 or 1, a literal of an enumeration its number."""
    number = _finite(name, value)
    match kind:
        case Kind.REAL:
            return number
        case Kind.BOOLEAN if number not in (0, 1):
            raise _usage("R409", f"`{name}` takes true or false, not {number:g}")
        case Kind.INTEGER if number != int(number):
            raise _usage("R409", f"`{name}` takes an integer, not {number:g}")
        case Kind.INTEGER if abs(number) > LARGEST_INTEGER:
            raise _usage("R409", f"`{name}` takes an integer below 2^53, not {number:g}")
        case Kind.ENUMERATION if number not in range(1, len(literals) + 1):
            raise _usage(
                "R409",
                f"`{name}` has no literal number {number:g}",
                f"choose among {ticked(literals)}",
            )
    return number


def _finite(name: str, value: float) -> float:
    if not math.isfinite(value):
        raise _usage("R409", f"`{name}` must be a finite number, not {value:g}")
    return float(value)


def _settable(known: Mapping[str, ParameterSlot], program: Program, name: str) -> ParameterSlot:
    parameter = known.get(name)
    if parameter is None:
        if (reason := not_to_be_set(program, name)) is not None:
            raise _usage("R404", *reason)
        if any(c.name == name for c in program.columns):
            raise _usage(
                "R404",
                f"`{name}` is a variable, not a parameter",
                given_by(program, name) or f"set its start value with `{name}.start`",
            )
        entries = [n for n in known if n.startswith(f"{name}[")]
        if entries:
            raise _usage(
                "R404",
                f"`{name}` is an array of {len(entries)} numbers, not one",
                f"set all of them in braces, or one by its name: `{entries[0]}`",
            )
        if any(c.name.startswith(f"{name}[") for c in program.columns):
            raise _usage(
                "R404",
                f"`{name}` is a vector of variables, and no parameter",
                given_by(program, name)
                or f"set start values of its entries, as with `{name}[1].start`",
            )
        if (meant := start_meant(program, name)) is not None:
            raise _usage("R404", f"there is no parameter `{name}` in the model", meant)
        raise _unknown("R404", "parameter", name, (n for n, p in known.items() if not p.final))
    if parameter.structural:
        raise _usage(
            "R405",
            f"`{name}` is structural: the equations themselves depend on it",
            _FOR_ALL,
        )
    if not parameter.settable:
        sources = _computed_from(program, name, known)
        if sources:
            told = listed(f"`{source}`" for source in sources)
            hint = f"set {either(sources[:3])} instead, or "
            hint += _FOR_ALL if compiles_again(program, parameter) else "change the model"
            raise _usage("R405", f"`{name}` cannot be set: it is computed from {told}", hint)
        raise _usage(
            "R405",
            f"`{name}` cannot be set: it is final, constant, or computed from other parameters",
            "set the parameters that it is computed from, or change the model",
        )
    return parameter


def compiles_again(program: Program, parameter: ParameterSlot) -> bool:
    """Whether another value makes another model: it is structural, or stands in the place of a
    formula of other parameters."""
    if parameter.settable or parameter.structural:
        return parameter.structural
    column = columns_of(program).get(parameter.name)
    public = column is None or not column.protected
    known = parameters_of(program)
    return public and not parameter.final and bool(_computed_from(program, parameter.name, known))


def differs(kernel: Kernel, parameter: ParameterSlot, value: float) -> bool:
    """Whether a value that compiles again is another one; the kernel is at its defaults. What a
    formula gives there it may not give where other parameters are set."""
    return not parameter.structural or bool(kernel.w[parameter.slot] != value)


def _sources(program: Program, name: str) -> list[str]:
    """A parameter that can be set, or those that it is computed from."""
    parameters = parameters_of(program)
    own = parameters.get(name)
    hidden = {c.name for c in program.columns if c.protected}
    if own is not None and own.settable and name not in hidden:
        return [name]
    return _computed_from(program, name, parameters) or [name]


def _computed_from(program: Program, name: str, known: Container[str]) -> list[str]:
    """The parameters in the formula of another one, where it is a formula of these alone."""
    formulas = {repr(s.target): s.value for s in program.parameters if isinstance(s, Let)}
    if name not in formulas:
        return []
    names, waiting = dict[str, None](), [formulas[name]]
    for value in waiting:
        for e in postorder((value,)):
            if e.op is Op.SYMBOL and e.name in known:
                names[e.name] = None
            elif e.op is Op.SYMBOL:  # what several formulas have in common
                if e.name not in formulas:
                    return []
                waiting.append(formulas[e.name])
    return [*dict.fromkeys(source for n in names for source in _sources(program, n))]


def _unknown(code: str, kind: str, name: str, known: Iterable[str]) -> UsageError:
    from planarc.core.nearest import did_you_mean

    return _usage(
        code, f"there is no {kind} `{name}` in the model", said(did_you_mean(name, known))
    )


@once
def startable(program: Program) -> tuple[dict[int, int], dict[str, tuple[int, float]]]:
    """The slots of start values by those of variables, and these by name, with a sign."""
    slots = {c.slot: c.start for c in program.candidates}
    slots |= {d.slot: d.start for d in program.discretes}
    slots |= {f.slot: f.start for f in program.fixed}
    slots |= {program.slots[n]: program.slots[f"start({n})"] for n in program.inputs}
    columns: dict[str, tuple[int, float]] = {c.name: (c.slot, c.sign) for c in program.columns}
    columns |= {c.name: (c.slot, 1) for c in program.candidates if c.name not in columns}
    return slots, columns


@once
def parameters_of(program: Program) -> dict[str, ParameterSlot]:
    return {p.name: p for p in program.parameter_slots}


@once
def columns_of(program: Program) -> dict[str, Column]:
    return {c.name: c for c in program.columns}


def _start_values(program: Program, given: Mapping[str, float]) -> dict[int, float]:
    """Start values by the slot that holds them; a variable's alias carries its sign."""
    if not given:
        return {}
    slots, columns = startable(program)
    result: dict[int, float] = {}
    for name, value in given.items():
        if name not in columns:
            raise _unknown("R406", "variable", name, columns)
        slot, sign = columns[name]
        if slot not in slots:
            near = deciding(program, name)
            raise _usage(
                "R400",
                f"`{name}` follows from other variables: its start value has no effect",
                given_by(program, name)
                or (f"set the start value of {either(near)}" if near else None),
            )
        column = columns_of(program).get(name)
        kind = Kind.REAL if column is None else column.kind
        literals = literals_of(program).get(name, ())
        result[slots[slot]] = sign * of_kind(f"{name}.start", kind, literals, value)
    return result
