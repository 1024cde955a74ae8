"""Our types as those of the protocol, and back: the only place that knows both.

A place of ours is a character of a text whose lines end with `\\n`; one of the protocol is a line
and a number of units of the encoding that client and server agreed on.
"""

from __future__ import annotations

from pathlib import Path

from lsprotocol import types as lsp
from pygls.uris import from_fs_path, to_fs_path

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.source import Source, Span
from planarc.editor import handbook
from planarc.editor.complete import Item, Sort
from planarc.editor.fixes import Fix
from planarc.editor.symbols import Symbol

_SEVERITIES = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
    Severity.NOTE: lsp.DiagnosticSeverity.Information,
}


def path_of(uri: str) -> Path:
    """The file of an address; an address of another kind stands for itself."""
    path = to_fs_path(uri) if uri.startswith("file:") else None
    return Path(uri if path is None else path)


def uri_of(path: Path) -> str:
    return str(from_fs_path(str(path))) if path.is_absolute() else str(path)


class Units:
    """Characters counted as the client counts them."""

    def __init__(self, encoding: str = "utf-16") -> None:
        self._wide = {"utf-16": "utf-16-le", "utf-8": "utf-8"}.get(encoding)
        self._unit = 2 if encoding == "utf-16" else 1

    def count(self, text: str) -> int:
        if self._wide is None or text.isascii():
            return len(text)
        return len(text.encode(self._wide, "surrogatepass")) // self._unit

    def position(self, source: Source, offset: int) -> lsp.Position:
        line, column = source.position(min(max(offset, 0), len(source.text)))
        start = offset - column + 1
        return lsp.Position(line - 1, self.count(source.text[start:offset]))

    def range(self, span: Span) -> lsp.Range:
        start = self.position(span.source, span.start)
        return lsp.Range(start, self.position(span.source, span.end))

    def location(self, span: Span) -> lsp.Location | None:
        path = span.source.path
        return None if path is None else lsp.Location(uri_of(path), self.range(span))

    def offset(self, source: Source, position: lsp.Position) -> int:
        """The character of a position; one that lies outside means the end of its line."""
        text = source.text
        start = source.start_of(position.line + 1)
        end = text.find("\n", start)
        line = text[start : end if end >= 0 else len(text)]
        if line.isascii() or self._wide is None:
            return start + min(max(position.character, 0), len(line))
        units = 0
        for at, character in enumerate(line):
            if units >= position.character:
                return start + at
            units += self.count(character)
        return start + len(line)


def diagnostic(found: Diagnostic, units: Units, source: Source) -> lsp.Diagnostic:
    message = found.message if found.hint is None else f"{found.message}\nhint: {found.hint}"
    span = found.span or Span(source, 0, 0)
    related = [
        lsp.DiagnosticRelatedInformation(where, r.message)
        for r in found.related
        if r.span is not None and (where := units.location(r.span)) is not None
    ]
    href = handbook.link(found.code)
    return lsp.Diagnostic(
        units.range(span),
        message,
        severity=_SEVERITIES[found.severity],
        code=found.code,
        code_description=None if href is None else lsp.CodeDescription(href),
        source="planarc",
        related_information=related or None,
    )


_ITEMS = {
    Sort.COMPONENT: lsp.CompletionItemKind.Variable,
    Sort.PARAMETER: lsp.CompletionItemKind.Constant,
    Sort.CLASS: lsp.CompletionItemKind.Class,
    Sort.PACKAGE: lsp.CompletionItemKind.Module,
    Sort.FUNCTION: lsp.CompletionItemKind.Function,
    Sort.LITERAL: lsp.CompletionItemKind.EnumMember,
    Sort.KEYWORD: lsp.CompletionItemKind.Keyword,
    Sort.ATTRIBUTE: lsp.CompletionItemKind.Property,
}
_SYMBOLS = {
    Sort.COMPONENT: lsp.SymbolKind.Field,
    Sort.PARAMETER: lsp.SymbolKind.Constant,
    Sort.CLASS: lsp.SymbolKind.Class,
    Sort.PACKAGE: lsp.SymbolKind.Package,
    Sort.FUNCTION: lsp.SymbolKind.Function,
    Sort.LITERAL: lsp.SymbolKind.EnumMember,
}
KINDS = {
    "package": lsp.SymbolKind.Package,
    "function": lsp.SymbolKind.Function,
    "connector": lsp.SymbolKind.Interface,
    "record": lsp.SymbolKind.Struct,
    "type": lsp.SymbolKind.TypeParameter,
}


def completion(item: Item, written: lsp.Range, more: object = None) -> lsp.CompletionItem:
    """An item that takes the place of what is written; `more` is what is needed to read on."""
    return lsp.CompletionItem(
        item.name,
        kind=_ITEMS[item.sort],
        detail=item.detail or None,
        documentation=item.description or None,
        sort_text=f"{item.rank}{item.name}",
        filter_text=item.name,  # without it Neovim shows all that it is given
        text_edit=lsp.TextEdit(written, item.insert or item.name),
        data=more if item.unread else None,
    )


def action(fix: Fix, told: lsp.Diagnostic, uri: str, units: Units) -> lsp.CodeAction:
    kind, title = lsp.CodeActionKind.QuickFix, fix.title
    if fix.accepts:
        accept = {"uri": uri, "class": fix.accepts, "redundant": "accept"}
        command = lsp.Command(title, "planarc.simulate", arguments=[accept])
        return lsp.CodeAction(title, kind, diagnostics=[told], command=command)
    edits = [lsp.TextEdit(units.range(e.span), e.text) for e in fix.edits]
    edit = lsp.WorkspaceEdit({uri: edits})
    return lsp.CodeAction(title, kind, diagnostics=[told], edit=edit)


def symbol(found: Symbol, units: Units) -> lsp.DocumentSymbol:
    return lsp.DocumentSymbol(
        found.name,
        _SYMBOLS[found.sort],
        units.range(found.whole),
        units.range(found.place),
        detail=found.detail,
        children=[symbol(s, units) for s in found.inside],
    )


def apply(text: str, change: lsp.TextDocumentContentChangeEvent, units: Units) -> tuple[str, int]:
    """A text after one change, and the character where that begins."""
    if isinstance(change, lsp.TextDocumentContentChangeWholeDocument):
        return change.text.replace("\r\n", "\n"), 0
    source = Source("", text)
    found = units.offset(source, change.range.start), units.offset(source, change.range.end)
    start, end = min(found), max(found)
    return text[:start] + change.text.replace("\r\n", "\n") + text[end:], start
