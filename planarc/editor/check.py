"""A text's models checked, one after the other, by the stages that `planarc check` calls.

In:   Shelf, Text
Out:  Finding   of each model: its diagnostics, and what it was made to, for `facts`

A class that is broken is only searched for wrong names and types, in its mended text: what was
left out of it makes equations too few. What its mistakes of syntax hide is not told twice.
A component with connectors of its own is flattened, but not solved alone: it is for others. So is a
block of a package; one that stands by itself is solved as the command does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from enum import Enum

from msgspec.structs import replace

from planarc import stages
from planarc.core.clock import Clock
from planarc.core.data import Data, without_collection
from planarc.core.diagnostic import (
    Diagnostic,
    Miscounted,
    PlanarcError,
    Related,
    Severity,
    Ungiven,
    mistake,
)
from planarc.core.source import Span
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text
from planarc.ir import syntax
from planarc.probe.check import Seen, judge, look_at
from planarc.remembered import Checked
from planarc.request.request import Target
from planarc.request.uses import check_versions

_MODELS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK)

Wanted = Callable[[], bool]
#: Called with the name of a model, and what it was made to.
Watch = Callable[[str, Seen], None]


class Overtaken(Exception):
    """A later edition makes this work superfluous."""


def ask(wanted: Wanted) -> None:
    if not wanted():
        raise Overtaken


class Finding(Data):
    name: str
    diagnostics: tuple[Diagnostic, ...] = ()
    checked: Checked | None = None
    seen: Seen | None = None  # until its facts are told

    @property
    def ok(self) -> bool:
        return all(d.severity is not Severity.ERROR for d in self.diagnostics)


def models_of(text: Text) -> tuple[str, ...]:
    """The classes of a text that can be checked by themselves."""
    return tuple(n for n, c in text.classes.items() if c.kind in _MODELS and not c.partial)


def check_text(
    shelf: Shelf, text: Text, wanted: Wanted, first: str = "", watch: Watch = lambda *_: None
) -> Iterator[Finding]:
    """The finding of each model, that of `first` first. Raises Overtaken.

    `watch` is called with what is seen of a model as soon as its equations are sorted.
    """
    names = sorted(models_of(text), key=lambda n: n != first)
    try:
        steady = shelf.target(text)
        mended = shelf.target(text, steady=False) if text.broken else steady
    except PlanarcError as problem:
        yield Finding("", tuple(_placed(d, text, None) for d in problem.diagnostics))
        return
    for name in names:
        ask(wanted)
        broken = name in text.broken
        target = replace(mended if broken else steady, class_name=name)
        found = _check(target, broken, wanted, watch)
        told = (d for d in found.diagnostics if not broken or _is_sure(d, text.good.get(name)))
        yield replace(found, diagnostics=tuple(_of_text(told, text, name)))


def _check(target: Target, broken: bool, wanted: Wanted, watch: Watch) -> Finding:
    name, ends = target.class_name, set[End]()
    try:
        warnings = tuple(check_versions(target.library, name))
        target = replace(target, warnings=warnings)
        with without_collection():
            ends = set(_connectors(target))
            if broken or End.FLANGE in ends or (ends and "." in name):
                told = stages.flatten(target, Clock(watch=lambda: ask(wanted))).warnings
                return Finding(name, () if broken else _for_users(told))
            clock = Clock(watch=lambda: ask(wanted))
            seen = look_at(target, clock)
            watch(name, seen)
            checked = judge(seen, clock)
        redundant = None if checked.mobility is None else checked.mobility.redundant
        told = (*checked.warnings, *(() if redundant is None else (redundant,)))
        return Finding(name, _for_users(told) if ends else told, checked, seen)
    except PlanarcError as problem:
        return Finding(name, _for_users(problem.diagnostics) if ends else problem.diagnostics)
    except Overtaken:
        raise
    except Exception as problem:
        return Finding(name, (mistake(problem),))


def _for_users(told: tuple[Diagnostic, ...]) -> tuple[Diagnostic, ...]:
    """Messages of a component, which gets the rest where it is used."""
    return tuple(d for d in told if not isinstance(d, Ungiven))


def _is_sure(diagnostic: Diagnostic, good: syntax.ClassDef | None) -> bool:
    """True for what is wrong whatever the broken part of a class was to say."""
    if diagnostic.severity is not Severity.ERROR or isinstance(diagnostic, Miscounted):
        return False
    composition = None if good is None else good.composition
    elements = () if composition is None else composition.elements
    known = {e.name for e in elements if isinstance(e, syntax.Component | syntax.ClassDef)}
    word = "" if diagnostic.span is None else diagnostic.span.text.partition(".")[0]
    return word not in known


class End(Enum):
    """The kinds of public connectors: one with several variables, or a signal."""

    FLANGE = 0
    SIGNAL = 1


def _connectors(target: Target) -> Iterator[End]:
    """The kinds of a class's own public connectors, to which its user connects."""
    from planarc.editor.view import LENIENT
    from planarc.flatten.pipeline import open_session
    from planarc.flatten.tree import lookup
    from planarc.flatten.tree.nodes import CONNECTOR_KINDS
    from planarc.flatten.tree.sight import open_class, opened, scope_of

    cls = open_class(open_session(target.library, LENIENT), target.class_name)
    if cls is None:
        return
    for _, element in lookup.components(scope_of(cls).instance):
        if element.protected:
            continue
        try:
            layout = opened(element).layout
        except PlanarcError:
            continue
        if layout.kind in CONNECTOR_KINDS:
            yield End.FLANGE if layout.builtin is None else End.SIGNAL


def _of_text(found: Iterable[Diagnostic], text: Text, name: str) -> Iterator[Diagnostic]:
    """Diagnostics with places in this text; those of last good trees of it are left out."""
    definition = text.classes.get(name)
    wrong = {e.span.line for e in text.errors if e.span}
    for diagnostic in found:
        span = diagnostic.span
        in_text = span is not None and span.source.path == text.path
        if in_text and span and (span.source is not text.source or span.line in wrong):
            continue
        yield _placed(diagnostic, text, definition)


def _placed(diagnostic: Diagnostic, text: Text, definition: syntax.ClassDef | None) -> Diagnostic:
    """A diagnostic that stands in the text; what lies elsewhere is told at the model's name."""
    span = diagnostic.span
    if span is not None and span.source is text.source:
        return diagnostic
    here = Span(text.source, 0, 0) if definition is None else definition.name_span
    there = () if span is None else (Related("here", span),)
    return replace(diagnostic, span=here, related=(*there, *diagnostic.related))


def all_of(text: Text, findings: list[Finding]) -> tuple[Diagnostic, ...]:
    """The diagnostics of a text, each once, in the order of the text."""
    every = (*text.errors, *(d for f in findings for d in f.diagnostics))
    unique = {(d.code, d.message, d.span and d.span[1:]): d for d in every}
    return tuple(sorted(unique.values(), key=lambda d: d.span.start if d.span else 0))
