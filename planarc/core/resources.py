"""The files of planarc that are no Python: the grammar and the library.

In a wheel they lie in `planarc/_data/`; in an editable install beside the package.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


@cache
def resource(folder: str) -> Path:
    """The folder `grammar` or `stdlib`, wherever this installation keeps it."""
    installed = _PACKAGE / "_data" / folder
    return installed if installed.is_dir() else _PACKAGE.parent / folder


def grammar_file() -> Path:
    return resource("grammar") / "modelica.lark"


def table_file() -> Path:
    """The table that lark makes of the grammar."""
    return resource("grammar") / "modelica.json"


@cache
def stdlib() -> Path:
    """The root of the embedded libraries."""
    return resource("stdlib")
