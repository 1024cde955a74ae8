"""What a user chooses by a word: back ends, solvers, treatments."""

from __future__ import annotations

from enum import StrEnum
from typing import Any, TypeVar

from msgspec.structs import replace

from planarc.api.values import finite
from planarc.core.diagnostic import usage_error
from planarc.core.options import (
    Backend,
    Contacts,
    Redundant,
    RunOptions,
    Solver,
    fastest_backend,
)
from planarc.core.unknown import unknown_name

C = TypeVar("C", bound=StrEnum)


def treatment_of(redundant: str | Redundant) -> Redundant:
    return chosen(Redundant, "treatment of redundant joints", redundant)


def chosen(kind: type[C], name: str, value: str) -> C:
    """The member of an enum; UnknownName with those that there are."""
    try:
        return kind(value)
    except ValueError:
        raise unknown_name(name, str(value), [k.value for k in kind]) from None


def backend_of(value: str | Backend | None) -> Backend:
    best = fastest_backend()
    found = best if value is None else chosen(Backend, "back end", value)
    if found is Backend.NATIVE and best is not found:
        raise usage_error("C207", "the native back end needs `llvmlite`, which is not installed")
    return found


def integrated(
    options: RunOptions,
    solver: str | Solver,
    fixed_step: float | None,
    contact: str | Contacts | None,
    backend: str | Backend | None,
    **checked: Any,
) -> RunOptions:
    """The options with the choices that a run and a stepper share; `fixed_step` in s. And with more
    options that were checked already."""
    return replace(
        options,
        **checked,
        backend=options.backend if backend is None else backend_of(backend),
        solver=chosen(Solver, "solver", solver),
        contact=None if contact is None else chosen(Contacts, "treatment of contacts", contact),
        fixed_step=None if fixed_step is None else finite("fixed_step", fixed_step, "s"),
    )
