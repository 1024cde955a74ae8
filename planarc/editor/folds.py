"""The parts of a text that an editor can fold: classes, sections, blocks, annotations, comments."""

from __future__ import annotations

import re
from collections.abc import Iterator

from planarc.core.data import Data
from planarc.editor.texts import Text
from planarc.ir import syntax
from planarc.ir.syntaxwalk import nodes_of

_COMMENT = re.compile(
    r'"(?:[^"\\]|\\.)*"|/\*.*?\*/|(?:^[ \t]*//[^\n]*\n){2,}', re.DOTALL | re.MULTILINE
)
_BLOCKS = (
    syntax.ClassDef | syntax.EquationSection | syntax.AlgorithmSection | syntax.IfEquation
    | syntax.ForEquation | syntax.WhenEquation | syntax.IfStatement | syntax.ForStatement
    | syntax.WhileStatement | syntax.WhenStatement | syntax.Annotation | syntax.Component
)  # fmt: skip


class Fold(Data):
    """Lines from 1; `kind` as the protocol calls it."""

    first: int
    last: int
    kind: str = "region"


def folds_of(text: Text) -> tuple[Fold, ...]:
    found = {f.first: f for f in (*_comments(text), *_blocks(text)) if f.last > f.first}
    return tuple(sorted(found.values(), key=lambda f: f.first))


def _blocks(text: Text) -> Iterator[Fold]:
    source = text.source
    for node in nodes_of(text.tree):
        if isinstance(node, _BLOCKS) and node.span.source is source:
            last = source.position(max(node.span.end - 1, node.span.start))[0]
            keeps_end = not isinstance(node, syntax.EquationSection | syntax.AlgorithmSection)
            yield Fold(node.span.line, last - 1 if keeps_end else last)
    imports = [n for n in nodes_of(text.tree) if isinstance(n, syntax.Import)]
    if imports:
        yield Fold(imports[0].span.line, imports[-1].span.line, "imports")


def _comments(text: Text) -> Iterator[Fold]:
    source = text.source
    for match in _COMMENT.finditer(source.text):
        if not match[0].startswith('"'):
            last = max(match.end() - (2 if match[0].endswith("\n") else 1), match.start())
            yield Fold(source.position(match.start())[0], source.position(last)[0], "comment")
