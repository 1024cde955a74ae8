"""Where a name is used: in the texts that are open, in the user's folders and in libraries.

In:   Session, Meaning
Out:  Use   each mention with that meaning

A file is read only where it holds the name as a word. What stands in a library is used there,
too; what a user's text declares, no library can name.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from planarc.core.data import Data
from planarc.core.files import read_plain
from planarc.core.source import decode, model_files
from planarc.editor.meaning import Meaning, meaning_of
from planarc.editor.mentions import Mention, mentions_of
from planarc.editor.shelf import Shelf, package_around
from planarc.editor.texts import Text
from planarc.editor.view import View
from planarc.ir import syntax

#: The most files that are searched.
_MOST = 20_000


class Use(Data):
    text: Text
    mention: Mention
    declares: bool


def uses_of(shelf: Shelf, folders: Sequence[Path], meaning: Meaning) -> Iterator[Use]:
    """The uses of what a name means, file by file; the declaration among them."""
    key = meaning.key
    if key is None:
        return
    for path in _files(shelf, folders, meaning):
        text = _text(shelf, path, meaning.name)
        if text is None:
            continue
        view = View(shelf, text)
        for mention in mentions_of(text, meaning.name):
            found = meaning_of(view, mention)
            if found is not None and found.key == key:
                at = (text.path, mention.span.start)
                yield Use(text, mention, at == (key[0], key[1]))


def uses_in(view: View, meaning: Meaning) -> Iterator[Mention]:
    """The uses in one text."""
    for mention in mentions_of(view.text, meaning.name):
        found = meaning_of(view, mention)
        if found is not None and found.key is not None and found.key == meaning.key:
            yield mention


def _files(shelf: Shelf, folders: Sequence[Path], meaning: Meaning) -> Iterator[Path]:
    """The files that may name it, each once."""
    if isinstance(meaning.declared, syntax.Iterator):
        yield Path(meaning.span.source.path or meaning.span.source.name)
        return
    seen: set[Path] = set()
    declared = meaning.span.source.path
    around = None if declared is None else package_around(declared)
    roots = [t.path for t in shelf.texts]
    roots += [folder for folder in folders if folder.is_dir()]
    roots += [around] if around is not None else []
    roots += [declared] if declared is not None else []
    roots += [library for library in shelf.libraries if library.exists()]
    for root in roots:
        files = model_files(root, below=True) if root.is_dir() else [root]
        for path in files[:_MOST]:
            if path not in seen:
                seen.add(path)
                yield path


def _text(shelf: Shelf, path: Path, word: str) -> Text | None:
    """The text of a file that holds a word."""
    text = shelf.texts.get(path)
    if text is None:
        try:
            data = read_plain(path)
        except (OSError, ValueError):
            return None
        if word.encode() not in data:
            return None
        text = Text(path, decode(data))
    return text if re.search(rf"(?<![\w']){re.escape(word)}(?![\w'])", text.source.text) else None
