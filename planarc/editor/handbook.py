"""Pages for a browser, written beside the cache: that of all diagnostic codes, which a diagnostic
links to, and the handbook's page of a class.
"""

from __future__ import annotations

from functools import cache
from html import escape
from typing import TYPE_CHECKING

from planarc.core import cache as disk
from planarc.core.diagnostic import PlanarcError
from planarc.core.version import __version__
from planarc.editor.meaning import meaning_at
from planarc.editor.view import View
from planarc.flatten.tree import sight

if TYPE_CHECKING:
    from planarc.catalog.explanations import Code

_HEAD = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><title>What messages mean</title>'
    "<style>body{max-width:46rem;margin:2rem auto;padding:0 1rem;font:16px/1.5 sans-serif}"
    "pre{background:#8882;padding:.6rem;overflow:auto}:target{background:#fd04}"
    ":root{color-scheme:light dark}</style>"
)


def link(code: str) -> str | None:
    """The address of the section about a code; None where nothing can be written."""
    from planarc.catalog.explanations import Code

    page = _page()
    return None if page is None or code not in Code.__members__ else f"{page}#{code}"


@cache
def _page() -> str | None:
    from planarc.catalog.explanations import Code

    folder = disk.folder()
    if folder is None:
        return None
    file = folder / f"messages-{__version__}.html"
    text = _HEAD + "".join(_section(code) for code in Code)
    try:
        if not file.is_file() or file.read_text("utf-8") != text:
            file.write_text(text, encoding="utf-8", newline="\n")
        return file.absolute().as_uri()
    except OSError:
        return None


def class_at(view: View, offset: int) -> str:
    """The class that a place is about: of a component its class, of a variable the one that
    declares it, else the class around. "" outside of all."""
    found = meaning_at(view, offset)
    element = None if found is None or found[1] is None else found[1].element
    try:
        if element is not None:
            cls = sight.class_behind(element)
            is_part = sight.scope_of(cls).instance.layout.builtin is None
            return cls.name if is_part else element.scope.part.cls.name
    except PlanarcError:
        pass
    return view.class_at(offset)


def class_page(view: View, name: str) -> str | None:
    """The address of the handbook's page of a class and the classes in it; None where there is no
    such class. Raises OSError and UsageError where nothing can be written."""
    from planarc.catalog.handbook.gather import gather
    from planarc.catalog.handbook.page import write_handbook

    folder = disk.folder()
    if folder is None:
        raise OSError("there is no folder of the cache to write the page into")
    pages = gather(view.library, [name])
    if not pages:
        return None
    file = folder / "handbook.html"
    write_handbook(file, name, pages)
    return f"{file.absolute().as_uri()}#{name}"


def _section(code: Code) -> str:
    from planarc.catalog.explanations import explain

    found = explain(code)
    parts = [f'<h2 id="{code.name}">{code.name}: {escape(code.value)}</h2>']
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in found.cause]
    parts += [f"<pre>{escape(text)}</pre>" for _, text in found.example]
    parts.append(f"<p><b>Cure.</b> {escape(found.cure)}</p>")
    return "\n".join(parts) + "\n"
