"""Diagnostics: what went wrong, where, and what to do, as data.

Stages raise `PlanarcError` with one or more diagnostics, or collect warnings;
`render` alone turns them into text. Codes are a letter for the stage and three
digits: C usage and files, P parse, F flatten, L lower, S structure,
G code generation, R run, V view.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from planarc.core.source import Span


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Related:
    """A second place that belongs to a diagnostic, with what it shows."""

    message: str
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One message. `message` is lower case, names in backticks; `hint` an imperative."""

    code: str
    message: str
    span: Span | None = None
    severity: Severity = Severity.ERROR
    hint: str | None = None
    related: tuple[Related, ...] = ()


class PlanarcError(Exception):
    """The model, its files or the request are wrong; carries the diagnostics."""

    def __init__(self, diagnostics: Diagnostic | Iterable[Diagnostic]) -> None:
        if isinstance(diagnostics, Diagnostic):
            diagnostics = (diagnostics,)
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("; ".join(f"{d.code} {d.message}" for d in self.diagnostics))


class UsageError(PlanarcError):
    """The request itself is wrong (a missing file, an unknown option value): exit code 2."""


class RunError(PlanarcError):
    """The run failed part-way; what was computed until then is kept: exit code 3."""


def error(
    code: str,
    message: str,
    span: Span | None = None,
    *,
    hint: str | None = None,
    related: Iterable[Related] = (),
) -> PlanarcError:
    """A `PlanarcError` with one diagnostic, ready to raise."""
    return PlanarcError(Diagnostic(code, message, span, hint=hint, related=tuple(related)))
