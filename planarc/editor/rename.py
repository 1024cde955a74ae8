"""A declared name changed wherever it is used: `Refusal` where that would mean something else.

In:   Session, Meaning, the new name
Out:  Renaming   edits of texts, and the files that must be called differently

Refused are reserved words, names that something in sight has already, what a library declares,
and elements that `inner` and `outer` tie to declarations in a library.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.editor.meaning import Meaning, meaning_of
from planarc.editor.mentions import Kind, mentions_of
from planarc.editor.references import Use, uses_of
from planarc.editor.shelf import Shelf, is_own, is_writable
from planarc.editor.texts import Text
from planarc.editor.view import View
from planarc.flatten.library.library import EXTENSIONS
from planarc.flatten.tree import lookup, predefined, sight
from planarc.flatten.typing import builtins
from planarc.ir import syntax
from planarc.parse.language import load_language

_NAME = re.compile(r"[A-Za-z_]\w*|'(?:[^'\\\n]|\\.)+'")


class Refusal(Exception):
    """A renaming that cannot be, with the reason in words."""


class Renaming(Data):
    edits: tuple[tuple[Text, tuple[Span, ...]], ...]
    files: tuple[tuple[Path, Path], ...] = ()


def check_name(name: str) -> None:
    """Raise Refusal for what is no name."""
    if _NAME.fullmatch(name) is None:
        raise Refusal(f"`{name}` is no name: it begins with a letter, letters and digits follow")
    if name in load_language().terminals.keywords or name in predefined.NAMES:
        raise Refusal(f"`{name}` is a reserved word: choose another name")
    if builtins.is_name(name) or name in ("der", "initial", "pure", "time"):
        raise Refusal(f"`{name}` is built in: choose another name")


def check_place(shelf: Shelf, meaning: Meaning | None) -> Meaning:
    """What can be renamed. Raises Refusal."""
    if meaning is None or meaning.key is None:
        raise Refusal("nothing that a text declares stands here")
    path = meaning.span.source.path
    if path is not None and shelf.texts.get(path) is None and not is_writable(path):
        raise Refusal(f"`{meaning.name}` is declared in a library, which is not changed")
    if path is not None and (is_own(path) or _is_in(path, shelf.libraries)):
        raise Refusal(f"`{meaning.name}` is declared in a library, which is not changed")
    return meaning


def rename(shelf: Shelf, folders: Sequence[Path], found: Meaning | None, name: str) -> Renaming:
    """The edits. Raises Refusal."""
    check_name(name)
    meaning = check_place(shelf, found)
    if name == meaning.name:
        return Renaming(())
    uses = list(uses_of(shelf, folders, meaning))
    uses += _partners(shelf, folders, meaning)
    _check_files(shelf, uses)
    _check_free(shelf, uses, meaning, name)
    edits: dict[Path, tuple[Text, dict[int, Span]]] = {}
    for use in uses:
        spans = edits.setdefault(use.text.path, (use.text, {}))[1]
        spans[use.mention.span.start] = use.mention.span
    ordered = tuple((text, tuple(s for _, s in sorted(d.items()))) for text, d in edits.values())
    return Renaming(ordered, _files(meaning, name))


def _is_in(path: Path, folders: Sequence[Path]) -> bool:
    return any(path.is_relative_to(folder) for folder in folders)


def _check_files(shelf: Shelf, uses: Sequence[Use]) -> None:
    for use in uses:
        path = use.text.path
        if _is_in(path, shelf.libraries) or (path.is_absolute() and not is_writable(path)):
            raise Refusal(f"it is used in `{path.name}`, which is not to be changed")


def _check_free(shelf: Shelf, uses: Sequence[Use], meaning: Meaning, name: str) -> None:
    """No place where the name is used sees something else of the new name."""
    declared = meaning.declared
    for use in uses:
        mention = use.mention
        if len(mention.path) > 1 and mention.kind is Kind.REFERENCE:
            continue  # behind a dot only the members of one class are seen
        if mention.kind is Kind.MODIFIER:
            continue
        view = View(shelf, use.text)
        scope = view.scope_of(mention.owner)
        try:
            other = lookup.find(scope, name)
        except PlanarcError:
            continue
        if other is not None and other[0].definition is not declared:
            raise Refusal(f"`{name}` means something else where `{meaning.name}` is used")
    element = meaning.element
    if element is None:
        return
    try:
        taken = lookup.member(element.scope.instance, name)
    except PlanarcError:
        return
    if taken is not None:
        raise Refusal(f"`{element.scope.instance.cls.name}` has a `{name}` already")


def _partners(shelf: Shelf, folders: Sequence[Path], meaning: Meaning) -> list[Use]:
    """The uses of `outer` declarations that an `inner` one is met by, and the other way round."""
    node = meaning.declared
    if not isinstance(node, syntax.Component | syntax.ClassDef):
        return []
    if not (node.prefixes.inner or node.prefixes.outer):
        return []
    if _is_outer_in_library(shelf, meaning):
        raise Refusal(f"`{meaning.name}` is met by `outer {meaning.name}` in a library")
    found: list[Use] = []
    for text in shelf.texts:
        view = View(shelf, text)
        for mention in mentions_of(text, meaning.name):
            other = mention.declared
            if mention.kind is not Kind.DECLARATION or other is node:
                continue
            prefixes = getattr(other, "prefixes", None)
            if prefixes is not None and (prefixes.inner or prefixes.outer):
                partner = meaning_of(view, mention)
                if partner is not None:
                    found += uses_of(shelf, folders, partner)
    return found


def _is_outer_in_library(shelf: Shelf, meaning: Meaning) -> bool:
    """True where the class of an `inner` component is a library's, whose parts ask for it."""
    if meaning.element is None:
        return False
    try:
        path = sight.class_behind(meaning.element).definition.span.source.path
    except PlanarcError:
        return False
    return path is not None and (is_own(path) or _is_in(path, shelf.libraries))


def _files(meaning: Meaning, name: str) -> tuple[tuple[Path, Path], ...]:
    """The file or folder that is called as the class."""
    path = meaning.span.source.path
    if path is None or not isinstance(meaning.declared, syntax.ClassDef):
        return ()
    if meaning.element is None or meaning.element.entry is None:
        return ()
    entry = meaning.element.entry
    if entry.folder is not None:
        return ((entry.folder, entry.folder.with_name(name)),)
    if entry.file is not None and path.stem == meaning.name and path.suffix in EXTENSIONS:
        return ((path, path.with_name(name + path.suffix)),)
    return ()
