"""Quick fixes: what a diagnostic lets an editor do, as edits.

In:   Text, Diagnostic
Out:  Fix   the edits, or the redundancy that a run is to accept

    `frame_z` ... did you mean `frame_b` or `frame_a`?     two fixes, each a name in its place
    expected `;` after the declaration                     `;` put in
    ... write `each` before it                             `each` before the modifier
    no `inner World world` is declared                     the declaration, as the first one
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from planarc.core import mend
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import Span
from planarc.editor.edits import Edit
from planarc.editor.texts import Text
from planarc.ir import syntax

_MODIFIER = re.compile(r"(?:final\s+)?(?:[A-Za-z_]\w*|'[^'\n]*')\s*=\s*$")


class Fix(Data):
    """Edits, or the class whose redundant joints a run is to accept."""

    title: str
    edits: tuple[Edit, ...] = ()
    accepts: str = ""


def fixes_of(text: Text, diagnostic: Diagnostic) -> Iterator[Fix]:
    """The fixes of one diagnostic of a text, the likely one first."""
    span = diagnostic.span
    if span is None or span.source is not text.source:
        return
    match diagnostic.mend:
        case mend.Meant(wrong, names):
            yield from _names(span, wrong, names)
        case mend.Write(new):
            yield Fix(f"Write `{new}`", (Edit(span, _apart(span, new)),))
        case mend.Insert(new):
            yield Fix(f"Put in `{new.strip()}`", (_insert(span, span.start, new),))
        case mend.Each():
            yield from _each(span)
        case mend.Declare(declaration):
            yield from _declare(text, span, declaration)
        case mend.MakeInner():
            yield from _make_inner(text, span)
        case mend.Accept():
            yield Fix("Run with redundant joints accepted", accepts=text.class_at(span.start))


def _apart(span: Span, new: str) -> str:
    """A text for a place, with spaces where it would grow together with a word beside it."""
    before, after = span.source.text[span.start - 1 : span.start], span.source.text[span.end :]
    left = " " if before.isalnum() and new[0].isalnum() else ""
    return left + new + (" " if after[:1].isalnum() and new[-1].isalnum() else "")


def _insert(span: Span, at: int, text: str) -> Edit:
    return Edit(Span(span.source, at, at), text)


def _names(span: Span, wrong: str, names: tuple[str, ...]) -> Iterator[Fix]:
    """Each name that may be meant in the place of the wrong one."""
    places = list(re.finditer(rf"(?<![\w']){re.escape(wrong)}(?![\w'])", span.text))
    if not places:
        return
    place = places[-1]
    inside = "." in span.text and "." not in wrong  # what it is a member of stands before it
    for name in names:
        new = name.rpartition(".")[2] if inside else name
        at = Span(span.source, span.start + place.start(), span.start + place.end())
        yield Fix(f"Write `{new}`", (Edit(at, new),))


def _each(span: Span) -> Iterator[Fix]:
    before = span.source.text[max(span.start - 200, 0) : span.start]
    found = _MODIFIER.search(before)
    if found is not None:
        at = span.start - len(before) + found.start()
        yield Fix("Give all elements the value: `each`", (_insert(span, at, "each "),))


def _declare(text: Text, span: Span, declaration: str) -> Iterator[Fix]:
    """A declaration before all others of the class whose name the span is."""
    for definition in text.classes.values():
        if definition.name_span.start != span.start:
            continue
        composition = definition.composition
        elements = () if composition is None else composition.elements
        starts = [_begin(e) for e in elements]
        source = text.source
        if starts and source.position(min(starts))[0] > source.position(span.start)[0]:
            at = source.start_of(source.position(min(starts))[0])
            indent = re.match(r"[ \t]*", source.text[at:])
            put = f"{indent[0] if indent else '  '}{declaration}\n"
        else:
            at, put = _behind_head(definition), f" {declaration}"
        yield Fix(f"Declare `{declaration.rstrip(';')}`", (_insert(span, at, put),))


def _begin(element: syntax.Element) -> int:
    if isinstance(element, syntax.Component):
        return min(element.type.span.start, element.span.start)
    return element.span.start


def _behind_head(definition: syntax.ClassDef) -> int:
    """The place behind the name and the description of a class."""
    text = definition.span.source.text
    found = re.compile(r'\s*"(?:[^"\\]|\\.)*"').match(text, definition.name_span.end)
    return definition.name_span.end if found is None else found.end()


def _make_inner(text: Text, span: Span) -> Iterator[Fix]:
    for definition in text.classes.values():
        composition = definition.composition
        for element in () if composition is None else composition.elements:
            if isinstance(element, syntax.Component) and element.span.start == span.start:
                edit = _insert(span, element.type.span.start, "inner ")
                yield Fix("Declare it `inner`", (edit,))
