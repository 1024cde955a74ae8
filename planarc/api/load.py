"""A model from what a user names: a file, a class of a library, or a text."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from msgspec.structs import replace

from planarc.api.choices import backend_of, treatment_of
from planarc.api.model import Model
from planarc.core.diagnostic import usage_error
from planarc.core.options import Redundant
from planarc.core.unknown import telling_keywords
from planarc.request.request import Request, names_class

_TEXT = re.compile(r"[\n;]")
#: Endings of files that planarc writes, and that hold no model.
_RESULTS = (".csv", ".mat", ".html")


@telling_keywords
def load(
    source: str | Path,
    class_name: str | None = None,
    *,
    libraries: Sequence[str | Path] = (),
    backend: str | None = None,
    redundant: str | Redundant = Redundant.REFUSE,
) -> Model:
    """A model from a file, a class of a library (`PlanarMultiBody.Examples...`), or a text.

    `class_name` names the class in a file or text that holds several; `libraries` are folders to
    look in first; `backend` is `native` or `numpy` (by default native where llvmlite is installed).
    `redundant="accept"`: joints may hold the same motion more than once, as a third parallel bar
    does; of their forces, in N and N.m at all frames of all joints, those of least squares are
    taken.

    Raises UsageError where there is no such file (C101) or class (C103), or where the text is no
    model (C206), and PlanarcError with all diagnostics when the model is wrong.
    """
    if not isinstance(class_name, str | None):
        raise usage_error("C202", f"the name of a class is a text, not {class_name!r}")
    given = (libraries,) if isinstance(libraries, str | Path) else libraries
    if not isinstance(given, Iterable) or not all(isinstance(p, str | Path) for p in given):
        raise usage_error("C202", f"`libraries` takes folders, not {libraries!r}")
    folders = tuple(Path(p) for p in given)
    if isinstance(source, Path):
        request = Request(source, class_name, folders)
    elif not isinstance(source, str):
        raise usage_error(
            "C206", f"a model is a file, a class or a text, not {type(source).__name__}"
        )
    elif not source.strip():
        raise usage_error("C206", "a model is a file, a class or a text, not nothing")
    elif _TEXT.search(source):
        request = Request(None, class_name, folders, text=source)
    elif class_name is None and names_class(source):
        request = Request(None, source, folders)
    else:
        request = Request(Path(source), class_name, folders)
    if request.file is not None and request.file.suffix.lower() in _RESULTS:
        raise usage_error(
            "C206",
            f"`{request.file}` is a result, not a model",
            hint=f"`planarc view {request.file}` shows it; load the model that made it",
        )
    return Model(replace(request, redundant=treatment_of(redundant)), backend_of(backend))
