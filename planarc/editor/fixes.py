"""Quick fixes: what a diagnostic's hint says, as an edit.

In:   Text, Diagnostic
Out:  Fix   the edit, or the redundancy that a run is to accept

    `frame_z` ... did you mean `frame_b` or `frame_a`?     two fixes, each a name in its place
    expected `;` after the declaration                     `;` put in
    ... write `each` before it                             `each` before the modifier
    no `inner World world` is declared                     the declaration, as the first one
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import Span
from planarc.editor.edits import Edit
from planarc.editor.texts import Text
from planarc.ir import syntax

_TICKED = re.compile(r"`([^`]+)`")
_NAME = r"(?<![\w.']){}(?![\w'])"
_EXPECTED = re.compile(r"expected `([;,)\]}]|then|loop)` (?:after|before)")
_INNER = re.compile(r"declare `(inner [^`;]+;)` in `")
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
    hint, message = diagnostic.hint or "", diagnostic.message
    if "did you mean" in hint:
        yield from _names(span, message, _TICKED.findall(hint[hint.index("did you mean") :]))
    expected = _EXPECTED.match(message)
    if expected is not None:
        put = expected[1] if len(expected[1]) == 1 else f" {expected[1]}"
        yield Fix(f"Put in `{expected[1]}`", (_insert(span, span.start, put),))
    if "`each`" in hint:
        yield from _each(span)
    inner = _INNER.match(hint)
    if inner is not None:
        yield from _declare(text, span, inner[1])
    elif "declared without `inner`" in message:
        yield from _make_inner(text, span)
    if diagnostic.code.startswith("P") and hint.startswith("write `"):
        yield from _instead(span, _TICKED.findall(hint)[0])
    if "`--redundant accept`" in f"{message} {hint}":
        yield Fix("Run with redundant joints accepted", accepts=text.class_at(span.start))


def _insert(span: Span, at: int, text: str) -> Edit:
    return Edit(Span(span.source, at, at), text)


def _names(span: Span, message: str, meant: list[str]) -> Iterator[Fix]:
    """Each name that may be meant in the place of the wrong one."""
    wrong = [
        n for n in _TICKED.findall(message) if re.search(_NAME.format(re.escape(n)), span.text)
    ]
    wrong += [
        last
        for n in _TICKED.findall(message)
        if re.search(rf"\b{re.escape(last := n.rpartition('.')[2])}\b", span.text)
    ]
    if not wrong:
        return
    place = list(re.finditer(rf"(?<![\w']){re.escape(wrong[0])}(?![\w'])", span.text))[-1]
    start, end = span.start + place.start(), span.start + place.end()
    for name in meant:
        new = name.rpartition(".")[2] if "." in name and "." not in wrong[0] else name
        if name.count(".") and span.text[: place.start()].endswith("."):
            new = name.rpartition(".")[2]
        elif "." in name and "." not in span.text:
            new = name
        yield Fix(f"Write `{new}`", (Edit(Span(span.source, start, end), new),))


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


def _instead(span: Span, new: str) -> Iterator[Fix]:
    """A token in the place of another; `end B` tells the name after `end`."""
    if new.startswith("end ") and not span.text.startswith("end"):
        new = new.removeprefix("end ")
    if " " not in span.text.strip() and len(new.split()) == 1:
        yield Fix(f"Write `{new}`", (Edit(span, new),))
