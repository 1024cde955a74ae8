"""The user's own text: where messages about a model point, and what its parts are called there.

In:   Dae or Program, and the place or component that a message is about
Out:  the declaration in the user's files to which that belongs

The user's are the model's own file, those beside it and those of its package; all others are
libraries'.

Example: `rodB` is a BodyShape, and `rodB.frameTranslation` a part inside of it. An equation of
that part cannot be met: the message points at the line that declares `rodB`, and the equation
comes last, as a note.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Protocol

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.source import NOWHERE, Span
from planarc.ir.flat import Part
from planarc.ir.once import once


class Model(Protocol):
    """What is asked of a model: its own place, and its components with theirs."""

    @property
    def name(self) -> str: ...
    @property
    def span(self) -> Span: ...
    @property
    def parts(self) -> tuple[Part, ...]: ...


class Started(Model, Protocol):
    """A model that knows where start values stand which are not in the line of their part."""

    @property
    def start_places(self) -> tuple[tuple[str, Span], ...]: ...


def is_own(model: Model, span: Span) -> bool:
    """Whether a place is in the user's text."""
    if span is NOWHERE or span.source.name == model.span.source.name:
        return span is not NOWHERE
    path, home = span.source.path, model.span.source.path
    if path is None or home is None:
        return False
    return _is_beside(path, home, model.name.partition(".")[0])


@lru_cache(maxsize=1024)
def _is_beside(path: Path, home: Path, package: str) -> bool:
    """Whether a file is in the same folder as another one, or in the same package."""
    folders = (f for f in home.parents if f.name == package)
    return path.parent == home.parent or any(map(path.is_relative_to, folders))


def own_part(model: Model, component: str) -> Part | None:
    """The innermost component around a name that the user declared."""
    named = _by_name(model.parts)
    while component:
        part = named.get(component)
        if part is not None and is_own(model, part.span):
            return part
        component = component.rpartition(".")[0]
    return None


def declared_part(model: Model, component: str) -> Part | None:
    """The part that a component is, if the user declared it; None for what is inside of one."""
    part = _by_name(model.parts).get(component)
    return part if part is not None and is_own(model, part.span) else None


@once
def _by_name(parts: tuple[Part, ...]) -> dict[str, Part]:
    return {part.name: part for part in parts}


def own_names(model: Model, components: Iterable[str]) -> list[str]:
    """Components as the user knows them, each once."""
    parts = ((own_part(model, c), c) for c in components)
    return list(dict.fromkeys(part.name if part else name for part, name in parts))


def owner(variable: str) -> str:
    """The component that a variable belongs to: `rev` of `rev.phi` and of `der(rev.s)`."""
    return variable.removeprefix("der(").removesuffix(")").rpartition(".")[0]


def declaration(model: Started, variable: str, span: Span) -> Span:
    """The user's declaration of the component of a variable, or the variable's own, `span`; its
    start value, where that has a line of its own."""
    start = dict(model.start_places).get(variable)
    if start is not None:
        return start
    part = own_part(model, owner(variable))
    return part.span if part else span


def point_home(model: Model, found: Diagnostic, component: str, here: str = "") -> Diagnostic:
    """The message at the user's declaration of a component, if it is about a place in a library:
    that one, and other places in libraries, come last, as details. `here` is said of that place."""
    if model.span is NOWHERE:
        return found
    part = own_part(model, component)
    own = tuple(r for r in found.related if r.span is None or is_own(model, r.span))
    foreign = tuple(r for r in found.related if r not in own)
    span = found.span
    if part is not None and (span is None or not is_own(model, span)):
        if span not in (None, NOWHERE) and all(r.span != span for r in foreign):
            foreign += (Related(here or f"this stands in `{part.class_name}`", span),)
        span = part.span
    if span is not None and is_own(model, span):
        foreign = tuple(replace(r, detail=True) for r in foreign)
    return replace(found, span=span, related=own + foreign)
