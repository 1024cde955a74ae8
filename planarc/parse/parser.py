"""From text to syntax tree: `machine` runs the grammar, `build` makes the nodes.

In:   Source              one text
Out:  StoredDefinition    its tree, or `PlanarcError` with every syntax error

Example:

    model M Real x; equation x = 1; end M;
    StoredDefinition(classes=(ClassDef(name="M", kind=ClassKind.MODEL, ...),))

Promises:  ends in a tree or in `PlanarcError` for every text; annotations are
           not read until `parse_annotation` is asked; a text that was parsed
           before comes from the cache, without lark.
Reference: Modelica Language Specification 3.6, appendix A.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planarc.core import cache
from planarc.core.data import Data, without_collection
from planarc.core.diagnostic import Diagnostic, Once, PlanarcError
from planarc.core.files import read_plain
from planarc.core.source import Source, Span, decode
from planarc.ir import syntax
from planarc.parse.stored import load_tree, store_tree

if TYPE_CHECKING:
    from planarc.parse.language import Language


def parse_text(source: Source) -> syntax.StoredDefinition:
    """The tree of a whole file; `PlanarcError` with every syntax error in it."""
    whole = Span(source, 0, len(source.text))
    tree: syntax.StoredDefinition = _parse_or_load("stored_definition", whole)
    return tree


def parse_file(path: Path, name: str | None = None) -> syntax.StoredDefinition:
    """The tree of a file, under the name that messages show."""
    return parse_text(Source(name or str(path), decode(read_plain(path)), path))


def parse_expression(text: str) -> syntax.Expression:
    """The tree of one expression that stands in no file."""
    whole = Span(Source("<expression>", text), 0, len(text))
    tree: syntax.Expression = _parse_or_load("expression_text", whole)
    return tree


def parse_annotation(annotation: syntax.Annotation) -> tuple[syntax.Argument, ...]:
    """The arguments of an annotation, which the parse of its file only skipped."""
    return _parse_annotation(annotation.span)


@lru_cache(maxsize=4096)
def _parse_annotation(span: Span) -> tuple[syntax.Argument, ...]:
    part: Any = _parse_or_load("annotation_text", span)
    arguments: tuple[syntax.Argument, ...] = part
    return arguments


def _parse_or_load(start: str, span: Span) -> Any:
    key = cache.key(start, str(span.start), span.text)
    with without_collection():
        tree = load_tree(span.source, key)
        if tree is None:
            tree = _parse(start, span)
            store_tree(key, tree)
    return tree


def _parse(start: str, span: Span) -> Any:
    found = read(start, span)
    if found.errors:
        raise PlanarcError(found.errors)
    return found.tree


class Reading(Data):
    """A text as far as it can be read. `tree` is None where nothing of it can."""

    tree: Any | None
    errors: tuple[Diagnostic, ...] = ()


def read(start: str, span: Span) -> Reading:
    """The tree of a text, its slips mended, with every syntax error; no cache is asked."""
    from planarc.parse.grammar.lexer import scan
    from planarc.parse.grammar.machine import run
    from planarc.parse.language import load_language

    nul = span.source.text.find("\0", span.start, span.end)
    if nul >= 0:
        message = "this is no text: it holds NUL characters"
        wide = span.source.text[:2] in ("ÿþ", "þÿ")
        hint = "save the file as UTF-8: it is in UTF-16" if wide else None
        at = Span(span.source, nul, nul + 1)
        return Reading(None, (Diagnostic("P100", message, at, hint=hint),))
    language = load_language()
    with language.lock:
        tokens, lexical = scan(span.source, language.terminals, span.start, span.end)
        language.build.begin(span)
        tree = run(language.table, language.reductions, start, tokens)
        errors = language.build.errors
        if tree is None:
            from planarc.parse.repair.recover import find_errors
            from planarc.parse.repair.salvage import leaves_out, salvage

            errors, mended = find_errors(language, start, tokens, lexical)
            language.build.begin(span)
            tree = run(language.table, language.reductions, start, [*mended, tokens[-1]])
            errors = [*errors, *_errors_beside(language, [*errors, *lexical])]
            if tree is None or leaves_out(tokens, mended):
                language.build.begin(span)
                whole = salvage(language.table, start, tokens, mended)
                tree = run(language.table, language.reductions, start, whole)
    lexical = [e for e in lexical if not _in_text(e, errors)]
    found = sorted((*lexical, *errors), key=lambda e: e.span.start if e.span else 0)
    every: dict[tuple[object, ...], Diagnostic] = {}
    for e in found:
        every.setdefault((e.code, e.kind if isinstance(e, Once) else (e.message, e.span)), e)
    return Reading(tree, tuple(every.values()))


def _in_text(error: Diagnostic, errors: Sequence[Diagnostic]) -> bool:
    """Whether a character stands in a text that only lacks its quotes."""
    from planarc.parse.repair.quotes import Unquoted

    texts = [e.span for e in errors if isinstance(e, Unquoted) and e.span]
    return any(error.span and t.start <= error.span.start < t.end for t in texts)


def _errors_beside(language: Language, errors: list[Diagnostic]) -> list[Diagnostic]:
    """The errors beside those of the grammar, found by building the mended text."""
    from planarc.parse.build.build import WrongEnd

    lines = {error.span.line for error in errors if error.span}
    return [
        error
        for error in language.build.errors
        if not isinstance(error, WrongEnd) and error.span and error.span.line not in lines
    ]
