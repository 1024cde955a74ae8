"""A model written as an FMU, as C or as a page, from Python, as `planarc export` writes it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from msgspec.structs import replace

from planarc.api.choices import backend_of
from planarc.compiler import compile_model, run
from planarc.core.diagnostic import usage_error
from planarc.core.options import Backend, RunOptions
from planarc.core.unknown import refuse_unknown
from planarc.view.storage import with_ending, write_bytes, write_folder, write_text

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.compiled import Compiled

#: A regular expression that matches anywhere in a name, or names.
Names: TypeAlias = "str | re.Pattern[str] | Sequence[str]"


def export_fmu(
    model: Model,
    path: Any,
    fmi: int,
    outputs: Names | None,
    inputs: Sequence[str],
    parameters: Names | None,
    platforms: Sequence[str] | None,
    stiff: bool,
    source: bool,
) -> Path:
    """See `Model.export_fmu`."""
    from planarc.export.fmu import make_fmu
    from planarc.export.wishes import Wishes

    place = _place(path, ".fmu")
    compiled = _compiled(model, inputs)
    wishes = Wishes(
        fmi,
        *_patterns(compiled, outputs, parameters),
        None if platforms is None else _several("platforms", platforms),
        bool(stiff),
        bool(source),
    )
    write_bytes(place, make_fmu(compiled, wishes).data)
    return place


def export_c(
    model: Model,
    path: Any,
    outputs: Names | None,
    inputs: Sequence[str],
    parameters: Names | None,
    stiff: bool,
) -> Path:
    """See `Model.export_c`."""
    from planarc.export.c.source import make_source
    from planarc.export.wishes import Wishes

    place = Path(_checked(path, ""))
    compiled = _compiled(model, inputs)
    patterns = _patterns(compiled, outputs, parameters)
    made = make_source(compiled, Wishes(3, *patterns, None, bool(stiff)))
    write_folder(place, made.files)
    return place


def export_page(model: Model, path: Any, inputs: Sequence[str], stiff: bool) -> Path:
    """See `Model.export_page`."""
    from planarc.export.page.held import taken
    from planarc.export.page.page import make_page

    place = _place(path, ".html")
    compiled = _compiled(model, inputs)
    taken(compiled.program)  # before it runs
    rows = run(compiled, RunOptions()) if inputs else model.simulate().rows
    write_text(place, make_page(compiled, rows, bool(stiff)).text)
    return place


def _compiled(model: Model, inputs: Sequence[str]) -> Compiled:
    """The model with its inputs, and the name that it has in Python."""
    backend = backend_of(Backend.NATIVE)
    wanted = _several("inputs", inputs)
    if not wanted:
        return model.compiled(backend)
    found = compile_model(replace(model.request, inputs=wanted), backend)
    return replace(found, program=replace(found.program, name=model.program.name))


def _patterns(
    compiled: Compiled, outputs: Names | None, parameters: Names | None
) -> tuple[re.Pattern[str] | None, re.Pattern[str] | None]:
    program = compiled.program
    return (
        _pattern("outputs", outputs, [c.name for c in program.columns]),
        _pattern("parameters", parameters, [p.name for p in program.parameter_slots]),
    )


def _place(path: Any, ending: str) -> Path:
    return with_ending(Path(_checked(path, ending)), ending)


def _checked(path: Any, ending: str) -> Any:
    if not isinstance(path, str | os.PathLike):
        raise usage_error("C202", f"a file has a path, not {path!r}", hint=f'give "crank{ending}"')
    return path


def _several(keyword: str, names: Any) -> tuple[str, ...]:
    if isinstance(names, str):
        return (names,)
    found = tuple(names) if isinstance(names, Iterable) else (names,)
    if all(isinstance(n, str) for n in found):
        return found
    raise usage_error("C202", f"`{keyword}` takes names, not `{names!r:.40}`")


def _pattern(keyword: str, wanted: Any, known: Sequence[str]) -> re.Pattern[str] | None:
    if wanted is None or isinstance(wanted, re.Pattern):
        return wanted
    if isinstance(wanted, str):
        try:
            return re.compile(wanted)
        except re.error as problem:
            told = f"`{keyword}={wanted!r}` is no regular expression: {problem}"
            raise usage_error("C114", told) from None
    names = _several(keyword, wanted)
    if not names:
        hint = f"leave it out for the {keyword} that the model has"
        raise usage_error("C202", f"`{keyword}` names none", hint=hint)
    refuse_unknown(keyword.removesuffix("s"), names, known)
    return re.compile("|".join(f"^{re.escape(name)}$" for name in names))
