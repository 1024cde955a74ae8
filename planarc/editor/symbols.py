"""The outline of a text, and the classes of the workspace by name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from planarc.core.data import Data
from planarc.core.source import Source, Span, decode, model_files
from planarc.editor.complete import Sort, sort_of
from planarc.editor.texts import Text, Texts
from planarc.ir import syntax

#: The most symbols of a workspace in one answer, and the most files that are looked at.
_MOST, _FILES = 200, 5000
_CLASS = re.compile(
    r"^\s*(?:(?:final|inner|replaceable|redeclare|encapsulated|partial|pure|impure|operator|"
    r"expandable)\s+)*(model|class|block|record|connector|type|package|function)\s+"
    r"(?:extends\s+)?([A-Za-z_]\w*)",
    re.MULTILINE,
)


class Symbol(Data):
    name: str
    sort: Sort
    detail: str
    whole: Span
    place: Span
    inside: tuple[Symbol, ...] = ()


class Found(Data):
    name: str
    kind: str
    place: Span


def outline(text: Text) -> tuple[Symbol, ...]:
    """The classes of a text with what they declare."""
    return tuple(_class(c) for c in text.tree.classes)


def _class(node: syntax.ClassDef) -> Symbol:
    composition = node.composition
    elements: Iterable[syntax.Element] = () if composition is None else composition.elements
    inside = [
        _class(e) if isinstance(e, syntax.ClassDef) else _component(e)
        for e in elements
        if isinstance(e, syntax.ClassDef | syntax.Component) and e.name
    ]
    if isinstance(node.body, syntax.Enumeration):
        inside += [
            Symbol(e.name, Sort.LITERAL, "", e.span, Span(e.span.source, e.span.start, e.span.end))
            for e in node.body.literals or ()
        ]
    return Symbol(
        node.name or "?", sort_of(node), node.kind.value, node.span, node.name_span, tuple(inside)
    )


def _component(node: syntax.Component) -> Symbol:
    place = Span(node.span.source, node.span.start, node.span.start + len(node.name))
    return Symbol(node.name, sort_of(node), str(node.type), node.span, place)


def search(texts: Texts, folders: Sequence[Path], query: str) -> Iterator[Found]:
    """Classes whose names hold the letters of a query in their order, found without parsing."""
    letters = re.compile(".*".join(map(re.escape, query)), re.IGNORECASE)
    count = 0
    for path in _paths(texts, folders):
        text = texts.get(path)
        try:
            source = text.source if text else Source(str(path), decode(path.read_bytes()), path)
        except OSError:
            continue
        for match in _CLASS.finditer(source.text):
            if letters.search(match[2]):
                yield Found(match[2], match[1], Span(source, match.start(2), match.end(2)))
                count += 1
                if count >= _MOST:
                    return


def _paths(texts: Texts, folders: Sequence[Path]) -> Iterator[Path]:
    seen = {text.path for text in texts}
    yield from sorted(seen)
    for folder in folders:
        for path in model_files(folder, below=True)[:_FILES] if folder.is_dir() else ():
            if path not in seen:
                seen.add(path)
                yield path
