"""Moving pictures of components, made by running the models that show them.

In:   ClassPage   of a library
Out:  Motions     a picture for each model, and which model shows which class

A picture is kept on disk under what its model was compiled to. A model that cannot be run, draws
nothing or takes too long shows nothing: `planarc check` and `planarc simulate` tell why.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from msgspec import field

from planarc.catalog.handbook.pages import ClassPage
from planarc.catalog.handbook.shown import Shows, find, models_that_show
from planarc.core import cache
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import RunOptions, fastest_backend
from planarc.core.processes import Crew, Lost, cores
from planarc.flatten.library.library import Library
from planarc.remembered import identity
from planarc.request.request import Request

#: Width of a picture in pixels, and the wall seconds that one may take.
WIDTH, LIMIT = 280, 20.0
_KINDS = ("model", "block")


class Motions(Data):
    """`pictures` in SVG; `shown`: of a class the model and its number among the pictures."""

    pictures: tuple[bytes, ...] = ()
    shown: dict[str, tuple[Shows, int]] = field(default_factory=dict)


def motions_of(
    library: Library,
    pages: Sequence[ClassPage],
    asked: Request,
    progress: Callable[[int, int, str], None] | None = None,
) -> Motions:
    """Pictures for the models and blocks among these pages."""
    models = models_that_show(library, pages, asked)
    wanted = {p.name: find(p.name, models) for p in pages if p.kind in _KINDS}
    found = {name: shows for name, shows in wanted.items() if shows is not None}
    drawn = _draw_all([*dict.fromkeys(s.request for s in found.values())], progress)
    numbers = {request: i for i, request in enumerate(drawn)}
    shown = {n: (s, numbers[s.request]) for n, s in found.items() if s.request in numbers}
    return Motions(tuple(drawn.values()), shown)


def _draw_all(
    requests: Sequence[Request], progress: Callable[[int, int, str], None] | None
) -> dict[Request, bytes]:
    """The pictures that can be had, in the order of the requests."""
    known = {request: _recall(request) for request in requests}
    unknown = [request for request, picture in known.items() if picture is None]
    crew: Crew[Request, bytes] = Crew(_draw, cores(), LIMIT)
    crew.add(unknown)
    for done, (request, picture) in enumerate(crew, 1):
        known[request] = b"" if isinstance(picture, Lost) else picture
        if progress is not None:
            progress(done, len(unknown), request.class_name or "")
    return {request: picture for request, picture in known.items() if picture}


def _draw(request: Request) -> bytes:
    """The picture of one model, empty where there is none."""
    from planarc import compiler
    from planarc.view.picture.make import PictureOptions, write_picture

    try:
        compiled = compiler.compile_model(request, fastest_backend())
        result = compiler.run(compiled, RunOptions(backend=compiled.backend))
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / "motion.svg"
            write_picture(path, result, PictureOptions(width=WIDTH))
            picture = path.read_bytes()
    except PlanarcError:
        picture = b""
    key = _key(request)
    if key is not None:
        cache.store("pages", key, picture)
    return picture


def _recall(request: Request) -> bytes | None:
    key = _key(request)
    return None if key is None else cache.load("pages", key)


def _key(request: Request) -> str | None:
    own = identity(request, fastest_backend())
    return None if own is None else cache.key("motion", own, str(WIDTH))
