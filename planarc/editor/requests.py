"""The protocol's questions, each answered by one call of ours and turned by `convert`.

A place that is nowhere, or in a file that is gone, has no answer; the client gets `null`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from lsprotocol import types as lsp

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.editor import commands, convert, tokens
from planarc.editor.complete import complete, told_of
from planarc.editor.edits import formatted
from planarc.editor.fixes import fixes_of
from planarc.editor.folds import folds_of
from planarc.editor.hints import hints_of, lenses_of
from planarc.editor.hover import hover
from planarc.editor.meaning import Meaning, meaning_at
from planarc.editor.peer import Peer, RequestFailed
from planarc.editor.references import uses_in, uses_of
from planarc.editor.rename import Refusal, Renaming, check_place, rename
from planarc.editor.signature import signature_at
from planarc.editor.symbols import outline, search
from planarc.editor.view import View
from planarc.flatten.tree import sight


def register(peer: Peer) -> None:
    """Let a peer answer."""
    for method, (handler, options) in _ANSWERS.items():
        peer.answer(method, handler, options)
    for method, slow in _SLOW.items():
        options = lsp.RenameOptions(True) if method == lsp.TEXT_DOCUMENT_RENAME else None
        peer.answer_slowly(method, slow, options)
    commands.register(peer)


def place(peer: Peer, params: Any) -> tuple[View, int]:
    """The view of a position's text, and the character. Raises OSError."""
    text = peer.text_at(params.text_document.uri)
    return peer.session.view(text), peer.units.offset(text.source, params.position)


def _meaning(peer: Peer, params: Any) -> tuple[View, Meaning] | None:
    view, offset = place(peer, params)
    found = meaning_at(view, offset)
    return None if found is None or found[1] is None else (view, found[1])


def _meaning_apart(peer: Peer, params: Any) -> Meaning | None:
    """The meaning, looked up for another thread: a view is of one thread."""
    text = peer.text_at(params.text_document.uri)
    offset = peer.units.offset(text.source, params.position)
    found = meaning_at(View(peer.session.shelf, text), offset)
    return None if found is None else found[1]


def _location(peer: Peer, span: Span) -> lsp.Location | None:
    path = span.source.path
    return None if path is None else lsp.Location(peer.uri(path), peer.units.range(span))


def _hover(peer: Peer, params: lsp.HoverParams) -> lsp.Hover | None:
    view, offset = place(peer, params)
    facts = peer.session.facts(view.text.path, view.class_at(offset))
    found = hover(view, offset, facts)
    if found is None:
        return None
    content = lsp.MarkupContent(lsp.MarkupKind.Markdown, found.markdown)
    return lsp.Hover(content, peer.units.range(found.span))


def _definition(peer: Peer, params: lsp.DefinitionParams) -> lsp.Location | None:
    found = _meaning(peer, params)
    return None if found is None or found[1].key is None else _location(peer, found[1].span)


def _type_definition(peer: Peer, params: lsp.TypeDefinitionParams) -> lsp.Location | None:
    found = _meaning(peer, params)
    if found is None or found[1].element is None:
        return None
    return _location(peer, sight.class_behind(found[1].element).span)


def _highlight(
    peer: Peer, params: lsp.DocumentHighlightParams
) -> list[lsp.DocumentHighlight] | None:
    found = _meaning(peer, params)
    if found is None:
        return None
    return [lsp.DocumentHighlight(peer.units.range(m.span)) for m in uses_in(*found)]


def _references(peer: Peer, params: lsp.ReferenceParams) -> list[lsp.Location] | None:
    found = _meaning_apart(peer, params)
    if found is None:
        return None
    session = peer.session
    uses = uses_of(session.shelf, session.folders, found)
    if not params.context.include_declaration:
        uses = (u for u in uses if not u.declares)
    return [lsp.Location(peer.uri(u.text.path), peer.units.range(u.mention.span)) for u in uses]


def _prepare_rename(peer: Peer, params: lsp.PrepareRenameParams) -> lsp.Range | None:
    view, offset = place(peer, params)
    found = meaning_at(view, offset)
    if found is None:
        return None
    try:
        check_place(peer.session.shelf, found[1])
    except Refusal as refusal:
        raise RequestFailed(str(refusal)) from None
    return peer.units.range(found[0].span)


def _rename(peer: Peer, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    session = peer.session
    try:
        meant = _meaning_apart(peer, params)
        renaming = rename(session.shelf, session.folders, meant, params.new_name)
        return _workspace_edit(peer, renaming, params.new_name)
    except Refusal as refusal:
        raise RequestFailed(str(refusal)) from None


def _workspace_edit(peer: Peer, renaming: Renaming, name: str) -> lsp.WorkspaceEdit:
    edits = {
        peer.uri(text.path): [lsp.TextEdit(peer.units.range(s), name) for s in spans]
        for text, spans in renaming.edits
    }
    if not renaming.files:
        return lsp.WorkspaceEdit(edits)
    workspace = peer.client_capabilities.workspace
    able = workspace.workspace_edit if workspace else None
    if not able or not able.document_changes or not able.resource_operations:
        old, new = renaming.files[0]
        raise Refusal(f"the editor cannot rename `{old.name}` to `{new.name}` along with it")
    changes: list[Any] = [
        lsp.TextDocumentEdit(lsp.OptionalVersionedTextDocumentIdentifier(uri), list(e))
        for uri, e in edits.items()
    ]
    changes += [
        lsp.RenameFile(convert.uri_of(old), convert.uri_of(new)) for old, new in renaming.files
    ]
    return lsp.WorkspaceEdit(document_changes=changes)


def _completion(peer: Peer, params: lsp.CompletionParams) -> lsp.CompletionList:
    view, offset = place(peer, params)
    context, items = complete(view, offset)
    span = Span(view.text.source, context.start, offset)
    written = peer.units.range(span)
    here = {"uri": params.text_document.uri, "at": offset}
    made = (
        convert.completion(i, written, {**here, "path": [*context.before, i.name]}) for i in items
    )
    return lsp.CompletionList(is_incomplete=False, items=list(made))


def _resolve(peer: Peer, item: lsp.CompletionItem) -> lsp.CompletionItem:
    """An item with what its class tells, whose file was not read for a list."""
    given: Any = item.data
    if isinstance(given, dict):
        view = peer.session.view(peer.text_at(given["uri"]))
        told = told_of(view, given["at"], given["path"])
        if told is not None:
            item.detail, item.documentation = told
    return item


def _signature(peer: Peer, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
    found = signature_at(*place(peer, params))
    if found is None:
        return None
    inputs = [lsp.ParameterInformation(n, documentation=words) for n, words in found.inputs]
    told = lsp.SignatureInformation(found.label, found.description, inputs)
    return lsp.SignatureHelp([told], 0, min(found.active, max(len(inputs) - 1, 0)))


def _outline(peer: Peer, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    text = peer.text_at(params.text_document.uri)
    return [convert.symbol(s, peer.units) for s in outline(text)]


def _search(peer: Peer, params: lsp.WorkspaceSymbolParams) -> list[lsp.WorkspaceSymbol]:
    session = peer.session
    folders = (*session.folders, *session.shelf.libraries)
    return [
        lsp.WorkspaceSymbol(where, found.name, convert.KINDS.get(found.kind, lsp.SymbolKind.Class))
        for found in search(session.texts, folders, params.query)
        if (where := _location(peer, found.place)) is not None
    ]


def _tokens(peer: Peer, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
    text = peer.text_at(params.text_document.uri)

    def placed() -> Iterator[tuple[int, int, int, tokens.Token]]:
        for token in tokens.tokens_of(text):
            start = peer.units.position(text.source, token.span.start)
            yield start.line, start.character, peer.units.count(token.span.text), token

    return lsp.SemanticTokens(tokens.encoded(placed()))


def _folds(peer: Peer, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
    text = peer.text_at(params.text_document.uri)
    return [
        lsp.FoldingRange(f.first - 1, f.last - 1, kind=lsp.FoldingRangeKind(f.kind))
        for f in folds_of(text)
    ]


def _format(peer: Peer, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit] | None:
    found = formatted(peer.text_at(params.text_document.uri))
    if found is None:
        return None
    return [lsp.TextEdit(peer.units.range(e.span), e.text) for e in found]


def _fixes(peer: Peer, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    uri = params.text_document.uri
    text = peer.text_at(uri)
    start = peer.units.offset(text.source, params.range.start)
    end = peer.units.offset(text.source, params.range.end)
    found = []
    for diagnostic in peer.session.diagnostics(text.path):
        span = diagnostic.span
        if span is None or span.source is not text.source or span.end < start or span.start > end:
            continue
        told = convert.diagnostic(diagnostic, peer.units, text.source)
        for fix in fixes_of(text, diagnostic):
            found.append(convert.action(fix, told, uri, peer.units))
    return found


def _hints(peer: Peer, params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
    if peer.options.get("inlayHints") is False:
        return []
    text = peer.text_at(params.text_document.uri)
    session = peer.session
    start = peer.units.offset(text.source, params.range.start)
    end = peer.units.offset(text.source, params.range.end)
    known = {n: f for n in text.classes if (f := session.facts(text.path, n)) is not None}
    return [
        lsp.InlayHint(
            peer.units.position(text.source, h.at), h.label, tooltip=h.tip, padding_left=True
        )
        for h in hints_of(text, session.findings(text.path), known, start, end)
        if start <= h.at <= end
    ]


def _lenses(peer: Peer, params: lsp.CodeLensParams) -> list[lsp.CodeLens]:
    uri = params.text_document.uri
    text = peer.text_at(uri)
    return [
        lsp.CodeLens(
            peer.units.range(lens.place),
            lsp.Command(word, f"planarc.{word}", arguments=[{"uri": uri, "class": lens.name}]),
        )
        for lens in lenses_of(text)
        for word in ("simulate", "view", "check")
    ]


def _quiet(handler: Callable[[Peer, Any], Any]) -> Callable[[Peer, Any], Any]:
    """An answer that is nothing where a file is gone or a class cannot be opened."""

    def answer(peer: Peer, params: Any) -> Any:
        try:
            return handler(peer, params)
        except (OSError, ValueError, PlanarcError, RecursionError):
            return None

    return answer


_LEGEND = lsp.SemanticTokensLegend(list(tokens.TYPES), list(tokens.MODIFIERS))
_COMPLETES = lsp.CompletionOptions([".", "(", ",", "="], resolve_provider=True)
_SIGNS = lsp.SignatureHelpOptions(["(", ","])

_ANSWERS: dict[str, tuple[Callable[[Peer, Any], Any], Any]] = {
    lsp.TEXT_DOCUMENT_HOVER: (_quiet(_hover), None),
    lsp.TEXT_DOCUMENT_DEFINITION: (_quiet(_definition), None),
    lsp.TEXT_DOCUMENT_TYPE_DEFINITION: (_quiet(_type_definition), None),
    lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: (_quiet(_highlight), None),
    lsp.TEXT_DOCUMENT_PREPARE_RENAME: (_quiet(_prepare_rename), None),
    lsp.TEXT_DOCUMENT_COMPLETION: (_quiet(_completion), _COMPLETES),
    lsp.COMPLETION_ITEM_RESOLVE: (_quiet(_resolve), None),
    lsp.TEXT_DOCUMENT_SIGNATURE_HELP: (_quiet(_signature), _SIGNS),
    lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: (_quiet(_outline), None),
    lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: (_quiet(_tokens), _LEGEND),
    lsp.TEXT_DOCUMENT_FOLDING_RANGE: (_quiet(_folds), None),
    lsp.TEXT_DOCUMENT_FORMATTING: (_quiet(_format), None),
    lsp.TEXT_DOCUMENT_CODE_ACTION: (
        _quiet(_fixes),
        lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix]),
    ),
    lsp.TEXT_DOCUMENT_INLAY_HINT: (_quiet(_hints), None),
    lsp.TEXT_DOCUMENT_CODE_LENS: (_quiet(_lenses), None),
}
#: Answers that may read many files: given by a thread of their own.
_SLOW: dict[str, Callable[[Peer, Any], Any]] = {
    lsp.TEXT_DOCUMENT_REFERENCES: _quiet(_references),
    lsp.TEXT_DOCUMENT_RENAME: _rename,
    lsp.WORKSPACE_SYMBOL: _quiet(_search),
}
