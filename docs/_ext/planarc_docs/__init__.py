"""What this site adds to Sphinx: pictures of mechanisms, and pages made from planarc itself.

In:   the pages of `docs/`, the libraries, the commands, the codes of diagnostics
Out:  directives `motion`, `curves`, `measured`, `papers`; folders `library`, `commands`, `codes`

A block ```` ```modelica NAME ```` is a file of its page, and is shown with that name.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, Any]:
    """Entry point of Sphinx."""
    from planarc_docs.measured import Measured
    from planarc_docs.papers import Papers
    from planarc_docs.pictures import Curves, Motion

    own = {"motion": Motion, "curves": Curves, "measured": Measured, "papers": Papers}
    for name, directive in own.items():
        app.add_directive(name, directive)
    app.connect("builder-inited", _make_pages)
    app.connect("source-read", _name_files)
    app.connect("autodoc-process-docstring", _mark_code)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _make_pages(app: Sphinx) -> None:
    from planarc_docs.codes import code_pages
    from planarc_docs.commands import command_pages
    from planarc_docs.library import library_pages
    from planarc_docs.written import write_folder

    makers = {"library": library_pages, "commands": command_pages, "codes": code_pages}
    for folder, pages in makers.items():
        write_folder(Path(app.srcdir) / folder, dict(pages()))


def _name_files(_app: Sphinx, _name: str, source: list[str]) -> None:
    from planarc_docs.blocks import with_captions

    source[0] = with_captions(source[0])


def _mark_code(
    _app: Sphinx, _what: str, _name: str, _: Any, _options: Any, lines: list[str]
) -> None:
    """Let what is indented below a paragraph of a docstring be Python."""
    for at in range(len(lines) - 1, 0, -1):
        if lines[at].startswith("    ") and not lines[at - 1].strip():
            lines[at:at] = [".. code-block:: python", ""]
