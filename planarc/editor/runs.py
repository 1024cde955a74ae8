"""The commands of an editor: a model of a text checked or run.

In:   Shelf, Text, the name of a class
Out:  a few words for a message
"""

from __future__ import annotations

from time import perf_counter

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, usage_error
from planarc.core.options import Redundant, RunOptions, fastest_backend
from planarc.core.prose import counted, ticked
from planarc.editor.check import models_of
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text
from planarc.request.request import Request


class Said(Data):
    ok: bool
    text: str


def request_of(
    shelf: Shelf, text: Text, name: str | None, redundant: Redundant = Redundant.REFUSE
) -> Request:
    """The request for a model of a text as it stands in the editor. Raises UsageError."""
    models = models_of(text)
    if name is None:
        like = [n for n in models if _plain(n) == _plain(text.path.stem)] or list(models)
        if len(like) != 1:
            told = f"it holds {ticked(models)}" if models else "it holds no model"
            raise usage_error("C106", f"`{text.path.name}` is not one model: {told}")
        name = like[0]
    return Request(
        text.path, name, shelf.named(text.path), text=text.source.text, redundant=redundant
    )


def _plain(name: str) -> str:
    return name.rpartition(".")[2].replace("_", "").replace("-", "").lower()


def check(request: Request) -> Said:
    """What `planarc check` says of a model."""
    from planarc.probe.check import check_model, summary_of

    try:
        found = check_model(request)
    except PlanarcError as problem:
        return Said(False, str(problem))
    return Said(True, "\n".join(summary_of(found)))


def simulate(request: Request) -> Said:
    """A model run from its start to its end."""
    from planarc.compiler import compile_model, run

    begin = perf_counter()
    try:
        backend = fastest_backend()
        result = run(compile_model(request, backend), RunOptions(backend=backend))
    except PlanarcError as problem:
        return Said(False, str(problem))
    seconds = perf_counter() - begin
    events = f", {counted(len(result.events), 'event')}" if result.events else ""
    told = f"{request.class_name} ran to t = {result.time[-1]:g} s in {seconds:.2f} s: "
    return Said(True, told + f"{counted(len(result.time), 'row')}{events}")
