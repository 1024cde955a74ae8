"""Refusals that are told apart by what is done about them, each an exception of its own.

    UnknownValue   a loop around it may be written out instead
    TooLarge       going on would find the same again and again
    NotThere       a connection to it is left out
    OutOfRange     a branch of an `if` that does not count may hold it

Parts of the language that planarc does not have are refused by name, never ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from planarc.core.diagnostic import Diagnostic, Once, PlanarcError, Ungiven, Varies, error
from planarc.core.source import Span


class UnknownValue(PlanarcError):
    """A value that shapes the model is not known when the model is compiled (F281)."""


class TooLarge(PlanarcError):
    """A class that contains itself, or a model that is too large (F251, F252)."""


class NotThere(PlanarcError):
    """A conditional component whose condition is false (F215)."""


class TurnOnce(Once):
    """An index in one turn of a loop, told of one of the arrays that have it."""


class OutOfRange(PlanarcError):
    """An index that an array does not have (F219)."""


def unknown_value(message: str, span: Span) -> UnknownValue:
    return UnknownValue(Ungiven("F281", message, span))


def variable_for_value(message: str, name: str, span: Span) -> UnknownValue:
    return UnknownValue(
        Varies("F281", message, span, hint=f"declare `{name}` as a parameter", kind=name)
    )


def too_large(message: str, span: Span | None) -> TooLarge:
    return TooLarge(Diagnostic("F252", message, span))


def joined(problems: Sequence[PlanarcError]) -> PlanarcError:
    """All diagnostics in one error, which is of the kind that decides what is done."""
    diagnostics = [d for problem in problems for d in problem.diagnostics]
    for kind in (UnknownValue, TooLarge):
        if any(isinstance(problem, kind) for problem in problems):
            return kind(diagnostics)
    for common in (NotThere, OutOfRange):
        if all(isinstance(problem, common) for problem in problems):
            return common(diagnostics)
    return PlanarcError(diagnostics)


def unsupported(feature: str, section: str, span: Span | None) -> PlanarcError:
    """The diagnostic for a feature, with the section of the specification that defines it."""
    message = f"planarc does not support {feature} (Modelica specification, section {section})"
    return error("F299", message, span)


Part = TypeVar("Part")
Result = TypeVar("Result")


def for_each(parts: Iterable[Part], do: Callable[[Part], Result]) -> list[Result]:
    """`do` of every part. Raises one PlanarcError with the diagnostics of all that fail."""
    found: list[Result] = []
    wrong: list[PlanarcError] = []
    for part in parts:
        try:
            found.append(do(part))
        except PlanarcError as problem:
            wrong.append(problem)
    if wrong:
        raise joined(wrong)
    return found
