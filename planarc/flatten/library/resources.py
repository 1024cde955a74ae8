"""Files that belong to libraries: `modelica://Library.Package/path`.

The path begins at the folder of the package that the URI names, or of the nearest one
around it that is a folder. `modelica:/` is the older form. `file:///` and plain names mean
files of the user's machine.

Reference: Modelica Language Specification 3.6, section 13.5.
"""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.nearest import did_you_mean
from planarc.core.source import Span
from planarc.flatten.library.library import Library, split_name

_URI = r"(?i:modelica):/{1,2}(?P<name>[^/#]*)/?(?P<path>[^#]*)"


def resource_path(uri: str, library: Library, span: Span) -> str:
    """The absolute path of the file that a URI or a file name means.

    Raises PlanarcError when a URI of a library names no file.
    """
    match = re.fullmatch(_URI, uri)
    if match is None:
        library.looked.names.add(uri)
        plain = re.sub(r"^file://(localhost)?", "", uri, flags=re.IGNORECASE)
        return Path(unquote(plain) if plain != uri else uri).absolute().as_posix()
    folder = _folder(match["name"], library)
    if folder is None:
        message = f"`{uri}` names no package of a library"
        hint = "write `modelica://Library/path`, and give the library with `--library`"
        raise error("F278", message, span, hint=hint)
    path = folder / unquote(match["path"])
    library.looked.names.add(str(path))
    if not path.exists():
        raise _missing(uri, path, span)
    return path.absolute().as_posix()


def _folder(name: str, library: Library) -> Path | None:
    """The folder of a package, or of the nearest one around it that is one."""
    names = split_name(name)
    if library.entry(name) is None:
        return None
    for count in range(len(names), 0, -1):
        entry = library.entry(".".join(names[:count]))
        assert entry is not None
        if entry.folder is not None:
            return entry.folder
    top = library.entry(names[0])
    assert top is not None
    file = top.definition.span.source.path
    return None if file is None else file.parent


def _missing(uri: str, path: Path, span: Span) -> PlanarcError:
    siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    hint = did_you_mean(path.name, siblings, most=1) or f"there is no `{path}`"
    return error("F278", f"there is no file `{uri}`", span, hint=hint)
