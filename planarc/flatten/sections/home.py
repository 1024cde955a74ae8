"""Errors in libraries' texts, told where the user declares the component that they come from.

In:   errors found while a component was opened or its equations were typed
Out:  the same at the user's declaration, the place in the library as a note

Example: `table[:, columns[j]]` of a table of two columns, with `columns={3}`: the index is wrong in
the library's equation, and the mistake in the modifier of the user's component.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.source import Span
from planarc.flatten.refusal import OutOfRange, TurnOnce
from planarc.flatten.tree.nodes import Instance
from planarc.ir.flat import Part
from planarc.ir.places import is_own


class FromLibrary(Diagnostic):
    """What a library's text says of the values that the user gives."""


class _Home(Data):
    """The user's own model, as places are judged by it."""

    name: str
    span: Span
    parts: tuple[Part, ...] = ()


class ToldAtHome:
    """A while in which errors of an instance are found; a raised one is told at home, too."""

    __slots__ = ("_before", "_instance")

    def __init__(self, instance: Instance) -> None:
        self._instance = instance

    def __enter__(self) -> None:
        self._before = len(self._instance.session.errors)

    def __exit__(self, kind: object, problem: BaseException | None, trace: object) -> None:
        instance, errors = self._instance, self._instance.session.errors
        if len(errors) > self._before:
            errors[self._before :] = [homewards(d, instance) for d in errors[self._before :]]
        if isinstance(problem, PlanarcError) and type(problem) in (PlanarcError, OutOfRange):
            raise PlanarcError(homewards(d, instance) for d in problem.diagnostics) from None


def homewards(found: Diagnostic, instance: Instance) -> Diagnostic:
    """A message about an instance, at the innermost component around that the user declared."""
    around = [i for i in instance.outwards() if i.prefix is not None]
    if found.span is None or not around:
        return found
    root = around[-1].cls
    home = _Home(root.name, root.span)
    if is_own(home, found.span):
        return found
    own = next((i for i in around[:-1] if is_own(home, i.span)), None)
    if own is None:
        return found
    there = Related(f"this stands in `{own.cls.name}`", found.span, detail=True)
    related = (*found.related, there)
    if type(found) not in (Diagnostic, TurnOnce):
        return replace(found, span=own.span, related=related)
    hint = f"check the values and sizes that `{own.name}` is given"
    return FromLibrary(found.code, found.message, own.span, found.severity, hint, related)
