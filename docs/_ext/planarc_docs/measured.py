"""Tables of measured figures, from the data file that the benchmarks write.

    ```{measured} speed
    ```

`docs/measured.json` holds each table by its name: `head`, `rows`, and the `command` that writes it.
"""

from __future__ import annotations

import json
from pathlib import Path

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from planarc_docs.written import table

DATA = Path(__file__).parents[2] / "measured.json"


class Measured(SphinxDirective):
    """One table, with the command that measures it again."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        self.env.note_dependency(str(DATA))
        found = json.loads(DATA.read_text("utf-8"))[self.arguments[0]]
        text = table(found["head"], found["rows"])
        told = f"Measured on {found['machine']}. `{found['command']}` measures it again."
        return self.parse_text_to_nodes(f"{text}\n{told}\n")
