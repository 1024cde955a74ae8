"""The page of all diagnostic codes, which a diagnostic links to: written once, beside the cache."""

from __future__ import annotations

from functools import cache
from html import escape
from importlib.metadata import version
from typing import TYPE_CHECKING

from planarc.core import cache as disk

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
    file = folder / f"messages-{version('planarc')}.html"
    text = _HEAD + "".join(_section(code) for code in Code)
    try:
        if not file.is_file() or file.read_text("utf-8") != text:
            file.write_text(text, encoding="utf-8", newline="\n")
        return file.absolute().as_uri()
    except OSError:
        return None


def _section(code: Code) -> str:
    from planarc.catalog.explanations import explain

    found = explain(code)
    parts = [f'<h2 id="{code.name}">{code.name}: {escape(code.value)}</h2>']
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in found.cause]
    parts += [f"<pre>{escape(text)}</pre>" for _, text in found.example]
    parts.append(f"<p><b>Cure.</b> {escape(found.cure)}</p>")
    return "\n".join(parts) + "\n"
