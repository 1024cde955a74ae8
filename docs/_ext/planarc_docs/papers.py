"""The papers that planarc's sources cite, behind `Reference:`, with the modules that do so.

    ```{papers}
    ```

What is cited of the specification of the language is left out: it is in nearly every module.
"""

from __future__ import annotations

import re
from pathlib import Path

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

import planarc
from planarc_docs.written import plain

PACKAGE = Path(planarc.__file__).parent
_CITED = re.compile(r"^ *References?: (.*?)(?:\n\s*\n|\"\"\"|\Z)", re.MULTILINE | re.DOTALL)
_AUTHOR = re.compile(r"(?:[A-Z]\. )+[A-Z]\w+")


def cited() -> list[tuple[str, str]]:
    """Each citation with its module, in the order of the modules."""
    found: dict[str, str] = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        module = str(file.relative_to(PACKAGE).with_suffix(""))
        for match in _CITED.finditer(file.read_text("utf-8")):
            text = " ".join(match[1].split())
            if _AUTHOR.search(text):
                found.setdefault(text, module)
    return list(found.items())


class Papers(SphinxDirective):
    """A list of them."""

    def run(self) -> list[nodes.Node]:
        lines = (f"- {plain(text)} (`{module}`)" for text, module in cited())
        return self.parse_text_to_nodes("\n".join(lines) + "\n")
