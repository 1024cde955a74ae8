"""Start values from elsewhere: from a state of rest, one of the assemblies, the end of another run.

In:   Model, RunOptions, the place that a user names
Out:  the model to run there, and start values by name

A place that tells all states is where the run begins, whatever the model's initial equations say:
the model is compiled without them.

Example: `equilibrium`, `assembly 2` (counted as `assemble` lists them, from 1), `FourBar.csv` (its
last row), or what Python holds of these: an Equilibrium, an Assembly, a Result.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from msgspec.structs import replace

from planarc.api.result import Result
from planarc.core.diagnostic import UsageError, usage_error
from planarc.core.nearest import did_you_mean
from planarc.core.options import RunOptions
from planarc.core.prose import be, counted
from planarc.ir.dae import INITIAL
from planarc.ir.program import Let, Program
from planarc.solve.settings import startable
from planarc.view.table.files import SUFFIXES, read_table

if TYPE_CHECKING:
    from planarc.api.analysis.assemble import Assembly
    from planarc.api.analysis.equilibrium import Equilibrium
    from planarc.api.model import Model
    from planarc.api.signals import Signal

#: A place to start from, as a user names it.
Place: TypeAlias = "str | Path | Result | Equilibrium | Assembly"

_ASSEMBLY = re.compile(r"assembly[ :=]?\s*(\d+)")
#: Guesses from which assemblies are looked for, as many as `assemble` takes.
_TRIES = 200
#: A result belongs to a model when it holds at least this part of its start values.
_SHARE = 0.5


def put_at(
    model: Model, options: RunOptions, place: Place, inputs: Mapping[str, Signal] | None = None
) -> tuple[Model, RunOptions]:
    """The model to run at a place, and options with its start values; those given before count
    first. Raises UsageError C215, C290, and PlanarcError where there is no equilibrium or no
    assembly."""
    found = {**_starts(model, options, place, inputs), **options.starts}
    return model_at(model, found), replace(options, starts=found)


def model_at(model: Model, starts: Mapping[str, float]) -> Model:
    """The model to run from these start values: without initial equations, if it has any and the
    values tell all states."""
    program = model.program
    slots, columns = startable(program)
    told = {slots.get(columns[n][0]) for n in starts if n in columns}
    whole = all(c.start in told for c in program.candidates)
    return model.placed() if whole and _has_initial(program) else model


def _has_initial(program: Program) -> bool:
    """Whether there are initial equations of unknowns, or when-clauses that may stand for some."""
    given = [s.value for s in program.discrete if isinstance(s, Let)]
    return bool(program.initial_residuals) or any(e.is_symbol and e.name == INITIAL for e in given)


def _starts(
    model: Model, options: RunOptions, place: Any, inputs: Mapping[str, Signal] | None
) -> Mapping[str, float]:
    if isinstance(place, Result):
        return _last_row(model.program, place.name, place.__contains__, place.__getitem__)
    if isinstance(getattr(place, "start", None), Mapping):  # an Equilibrium or an Assembly
        return _told(model.program, place)
    if not isinstance(place, str | Path):
        raise _no_place(repr(place)[:40])
    text = str(place).strip()
    if Path(text).suffix.lower() in SUFFIXES:
        table = read_table(Path(text))
        return _last_row(model.program, text, table.__contains__, table.__getitem__)
    if text == "equilibrium":
        from planarc.api.analysis.equilibrium import find_equilibrium

        return _told(model.program, find_equilibrium(model, options, inputs))
    if (counting := _ASSEMBLY.fullmatch(text)) is not None:
        return _assembly(model, options, int(counting[1]))
    raise _no_place(text)


def _told(program: Program, place: Equilibrium | Assembly) -> dict[str, float]:
    """Its start values, and the discrete values of a state of rest."""
    known = startable(program)[1]
    discrete = {d.slot for d in program.discretes if not d.name.startswith("$")}
    values: Mapping[str, float] = getattr(place, "values", {})
    found = {n: v for n, v in values.items() if n in known and known[n][0] in discrete}
    return found | {n: v for n, v in place.start.items() if n in known}


def _no_place(text: str) -> UsageError:
    near = did_you_mean(text, ("equilibrium", "assembly 1"))
    return usage_error(
        "C215",
        f"there is no place `{text}` to start from",
        hint=near or "name `equilibrium`, `assembly 2`, or a result (.csv or .mat)",
    )


def _assembly(model: Model, options: RunOptions, number: int) -> Mapping[str, float]:
    from planarc.api.analysis.assemble import assemble

    found = assemble(model, options, _TRIES)
    if not 1 <= number <= len(found):
        raise usage_error(
            "C215",
            f"there is no assembly {number}: {counted(len(found), 'way')} "
            f"{be(len(found))} found to put `{model.name}` together",
            hint="`planarc assemble` lists them, and counts from 1",
        )
    return found[number - 1].start


def _last_row(
    program: Program, name: str, holds: Callable[[str], bool], column: Callable[[str], Any]
) -> dict[str, float]:
    """The start values that a result tells at its end."""
    slots, columns = startable(program)
    names: dict[int, str] = {}
    for variable, (slot, _) in columns.items():
        if slot in slots and holds(variable):
            names.setdefault(slot, variable)
    wanted = {c.slot for c in program.candidates}
    there = len(wanted & names.keys())
    values = {n: column(n) for n in names.values()}
    if there < _SHARE * len(wanted) or not all(len(v) for v in values.values()):
        raise usage_error(
            "C290",
            f"`{name}` is no result of `{program.name}`: it holds {there} of the model's"
            f" {counted(len(wanted), 'start value')}",
            hint="give a result of this model, with all its variables",
        )
    return {n: float(v[-1]) for n, v in values.items()}
