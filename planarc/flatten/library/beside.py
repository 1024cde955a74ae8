"""Packages that lie where a user's file does, though no library holds them.

In:   the place of a text
Out:  the error of a `within` that names no package; the folder of a package beside the file

Example: `Machines/package.pmo` and `Machines/Crank.pmo`. The file `Crank.pmo` stands in `Machines`,
and beside `Machines` a model finds it with `--library .`.
"""

from __future__ import annotations

from pathlib import Path

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span

_PACKAGES = ("package.pmo", "package.mo")


def unknown_within(within: str, span: Span) -> PlanarcError:
    """The error of a package that `within` names and no library holds."""
    message = f"the package `{within}` that `within` names is not in any library"
    hint = "remove `within` if the model belongs to no package, else give the folder that holds "
    hint += "the package with `--library`"
    if real := package_of(span):
        message += f", and this file stands in the package `{real}`"
        hint = f"write `within {real};`"
    return error("F204", message, span, hint=hint)


def package_of(span: Span) -> str:
    """The full name of the package in whose folder the file of a text stands; empty for none."""
    path, names = span.source.path, list[str]()
    folder = path.resolve().parent if path is not None else None
    while folder is not None and _is_package(folder) and folder.parent != folder:
        names.insert(0, folder.name)
        folder = folder.parent
    return ".".join(names)


def package_beside(span: Span, name: str) -> str | None:
    """The folder, as it is written on the command line, that holds a package and the file of a
    text; None where there is no such package."""
    path = span.source.path
    if path is None or not _is_package(path.parent / name):
        return None
    return str(path.parent)


def _is_package(folder: Path) -> bool:
    return any((folder / file).is_file() for file in _PACKAGES)
