"""Each part of a reference stands where its text is, in every class of the library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from planarc.core.source import Source, Span, model_files
from planarc.ir import syntax
from planarc.parse.parser import parse_file, parse_text

STDLIB = Path(__file__).parents[3] / "stdlib"


def references(node: object) -> Iterator[syntax.Ref]:
    if isinstance(node, tuple) and not isinstance(node, Span):
        for inner in node:
            yield from references(inner)
    elif isinstance(node, syntax.Node):
        if isinstance(node, syntax.Ref):
            yield node
        for name in node.__struct_fields__:
            yield from references(getattr(node, name))


def check_parts(ref: syntax.Ref) -> int:
    for part in ref.parts:
        assert ref.span.covers(part.span)
        assert part.span.text == part.name or (
            part.subscripts and part.span.text.startswith(part.name)
        )
    return len(ref.parts)


def test_parts_of_references_stand_where_they_are_written() -> None:
    lengths = [
        check_parts(ref)
        for file in model_files(STDLIB, below=True)
        for ref in references(parse_file(file))
    ]
    assert len(lengths) > 10_000
    assert max(lengths) > 3


def test_a_dotted_type_with_a_comment_inside() -> None:
    text = "model M\n  .A . /* B */ B.'C d'[2] c;\nend M;\n"
    first, *_ = references(parse_text(Source("m", text)).classes)
    assert [part.span.text for part in first.parts] == ["A", "B", "'C d'"]
    assert first.span.text == ".A . /* B */ B.'C d'"
