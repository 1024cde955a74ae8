"""Renaming: the flat model of an example with another name is the same but for that name."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from planarc import stages
from planarc.editor.meaning import meaning_of
from planarc.editor.mentions import Kind, mentions_of
from planarc.editor.rename import Refusal, Renaming, rename
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text, Texts
from planarc.editor.view import View
from planarc.ir.text.flat import print_model
from planarc.request.request import Request, open_target
from tests.editor.conftest import EXAMPLES

ALL = sorted(EXAMPLES.rglob("*.pmo"))
NEW = "renamed_for_the_test"


def flat(path: Path, content: str, class_name: str | None) -> str:
    model = stages.flatten(open_target(Request(path, class_name, text=content)))
    return re.sub(r"  // .*", "", print_model(model))


def applied(text: Text, renaming: Renaming) -> str:
    content = text.source.text
    for _, spans in renaming.edits:
        for span in reversed(spans):
            content = content[: span.start] + NEW + content[span.end :]
    return content


@pytest.mark.parametrize("path", ALL, ids=lambda p: p.stem)
def test_the_flat_model_is_equal_up_to_names(path: Path) -> None:
    texts = Texts()
    text = texts.put(path, path.read_text("utf-8"))
    shelf = Shelf(texts)
    view = View(shelf, text)
    main = next(c.name for c in reversed(text.tree.classes) if c.kind.value == "model")
    before = flat(path, text.source.text, main)
    renamed = 0
    seen = set()
    for mention in list(mentions_of(text)):
        if mention.kind is not Kind.DECLARATION or mention.name in seen:
            continue
        seen.add(mention.name)
        try:
            found = rename(shelf, (), meaning_of(view, mention), NEW)
        except Refusal as refusal:
            assert "outer" in str(refusal)  # the world, for which parts of the library ask
            continue
        new = applied(text, found)
        after = flat(path, new, NEW if mention.name == main else main)
        assert new != text.source.text
        assert re.sub(rf"\b{NEW}\b", mention.name, after) == before
        renamed += 1
    assert renamed > 1


LIBRARY = {
    "package.mo": "package Lib\n  constant Real g=9;\nend Lib;\n",
    "Part.mo": "within Lib;\nmodel Part\n  parameter Real k=1;\n  Real x=k*g;\nend Part;\n",
    "Whole.mo": "within Lib;\nmodel Whole\n  Part p(k=2);\n  Lib.Part q;\n  Real y=p.x+q.k;\n"
    "end Whole;\n",
}


def library(folder: Path) -> Path:
    (folder / "Lib").mkdir()
    for name, content in LIBRARY.items():
        (folder / "Lib" / name).write_text(content, encoding="utf-8")
    return folder / "Lib"


def renamed(folder: Path, file: str, name: str) -> Renaming:
    texts = Texts()
    path = folder / file
    text = texts.put(path, path.read_text("utf-8"))
    shelf = Shelf(texts)
    view = View(shelf, text)
    mention = next(m for m in mentions_of(text, name) if m.kind is Kind.DECLARATION)
    return rename(shelf, (folder.parent,), meaning_of(view, mention), NEW)


def test_uses_in_other_files_are_renamed(tmp_path: Path) -> None:
    found = renamed(library(tmp_path), "Part.mo", "k")
    places = {t.path.name: [s.line for s in spans] for t, spans in found.edits}
    assert places == {"Part.mo": [3, 4], "Whole.mo": [3, 5]}
    assert found.files == ()


def test_the_file_of_a_class_is_called_as_the_class(tmp_path: Path) -> None:
    folder = library(tmp_path)
    found = renamed(folder, "Part.mo", "Part")
    assert found.files == ((folder / "Part.mo", folder / f"{NEW}.mo"),)
    places = {t.path.name: [s.line for s in spans] for t, spans in found.edits}
    assert places == {"Part.mo": [2, 5], "Whole.mo": [3, 4]}


def test_a_library_of_the_settings_is_not_changed(tmp_path: Path) -> None:
    folder = library(tmp_path)
    texts = Texts()
    content = "model M\n  Lib.Part p(k=3);\nend M;\n"
    text = texts.put(tmp_path / "M.mo", content)
    shelf = Shelf(texts, [tmp_path / "Lib"])
    (mention,) = mentions_of(text, "k")
    with pytest.raises(Refusal, match="library"):
        rename(shelf, (), meaning_of(View(shelf, text), mention), NEW)
    assert folder.exists()
