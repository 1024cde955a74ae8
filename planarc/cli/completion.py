"""What a shell offers while a command is typed: files, classes, variables, layers.

Each function takes what is typed so far and gives whole words. What cannot be read offers nothing:
a shell has no place for a message. Where nothing is offered, the shell offers files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import typer

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import SUFFIXES

if TYPE_CHECKING:
    from planarc.flatten.library.library import Library
    from planarc.ir.program import Program

_RESULTS = (".csv", ".mat")
_Offer: TypeAlias = "Callable[[typer.Context, str], list[str]]"


def _quietly(offer: Callable[[typer.Context, str], Iterable[str]]) -> _Offer:
    @wraps(offer)
    def answer(ctx: typer.Context, incomplete: str) -> list[str]:
        try:
            return [word for word in offer(ctx, incomplete) if word.startswith(incomplete)]
        except (PlanarcError, OSError, ValueError):
            return []

    return answer


@_quietly
def models(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """Model files, and the classes of libraries."""
    return (*_files(incomplete, SUFFIXES), *_library_classes(ctx, incomplete))


@_quietly
def results(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """Results and models."""
    both = (*_RESULTS, *SUFFIXES)
    return (*_files(incomplete, both), *_library_classes(ctx, incomplete))


@_quietly
def classes(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """The models of the file that is named."""
    from planarc.request.request import Request, models_inside, open_library

    file = Path(_named(ctx)[0])
    library, _, names = open_library(Request(file, None, _libraries(ctx)))
    inside = (entry.full_name for entry in models_inside(library, names))
    return dict.fromkeys((*names, *inside))


@_quietly
def variables(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """The variables and parameters of the result or model that is named."""
    file = Path(_named(ctx)[0])
    if file.suffix.lower() in _RESULTS:
        from planarc.view.table.files import read_table

        return _stepwise(read_table(file).columns, incomplete)
    return _stepwise((c.name for c in _program(ctx).columns), incomplete)


@_quietly
def parameters(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """The parameters that a run can set."""
    slots = _program(ctx).parameter_slots
    return _stepwise((p.name for p in slots if p.settable or p.structural), incomplete)


@_quietly
def settings(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """Parameters, and start values, each with the sign behind which its value comes."""
    program = _program(ctx)
    known = [p.name for p in program.parameter_slots if p.settable or p.structural]
    known += [f"{c.display}.start" for c in program.candidates]
    return _stepwise((f"{name}=" for name in known), incomplete)


@_quietly
def metrics(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """Variables, alone or in what is made of them."""
    from planarc.study.metric import KINDS

    head, bracket, begun = incomplete.rpartition("(")
    names = _stepwise((c.name for c in _program(ctx).columns if not c.constant), begun)
    if bracket:
        return [f"{head}({name}" + ")" * (not name.endswith(".")) for name in names]
    return [*(f"{kind}(" for kind in KINDS), *names]


@_quietly
def layers(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    """The layers that a picture lays over the mechanism."""
    return ("forces", "contacts", "velocities", "accelerations", "paths", "masses", "names")


def _program(ctx: typer.Context) -> Program:
    from planarc.compiler import compile_model
    from planarc.core.options import fastest_backend
    from planarc.request.request import Request, names_class

    target, name, *_ = (*_named(ctx), None)
    is_file = not names_class(target) or Path(target).exists()
    file, wanted = (Path(target), name or None) if is_file else (None, target)
    request = Request(file, wanted, _libraries(ctx))
    return compile_model(request, fastest_backend()).program


def _named(ctx: typer.Context) -> list[str]:
    """The target and its class; where an option still lacks its value, they are not parsed."""
    found = (ctx.params.get("target"), ctx.params.get("class_name"))
    return [str(name) for name in found if name] or [*ctx.args, ""]


def _libraries(ctx: typer.Context) -> tuple[Path, ...]:
    return tuple(ctx.params.get("library") or ())


def _files(incomplete: str, suffixes: Iterable[str]) -> Iterable[str]:
    """Files of these kinds, and folders; nothing where only folders fit, which the shell offers
    without a blank behind them."""
    head, slash, begun = incomplete.rpartition("/")
    folder = Path(head + slash)
    found = sorted(p for p in folder.iterdir() if p.name.startswith(begun))
    files = [head + slash + p.name for p in found if p.suffix.lower() in suffixes and p.is_file()]
    folders = [f"{head}{slash}{p.name}/" for p in found if p.is_dir() and p.name[0] != "."]
    return [*files, *folders] if files else ()


def _library_classes(ctx: typer.Context, incomplete: str) -> Iterable[str]:
    from planarc.request.request import Request, names_class, open_library

    if incomplete and names_class(incomplete + "x"):
        library, _, _ = open_library(Request(None, None, _libraries(ctx)))
        return _classes_in(library, incomplete)
    return ()


def _classes_in(library: Library, incomplete: str) -> list[str]:
    """Classes that begin so; of a single package what it holds, too."""
    package, dot, begun = incomplete.rpartition(".")
    found = [package + dot + n for n in library.class_names(package) if n.startswith(begun)]
    if len(found) == 1:
        found += [f"{found[0]}.{name}" for name in library.class_names(found[0])]
    return found


def _stepwise(names: Iterable[str], incomplete: str) -> list[str]:
    """Names down to their next dot, `crank.` for all in `crank`: thousands help nobody."""
    fitting = [n for n in names if n.startswith(incomplete) and not n.startswith("$")]
    begin = incomplete.rfind(".") + 1
    steps = list(dict.fromkeys(n[: n.find(".", begin) + 1] or n for n in fitting))
    one = len(steps) == 1 and steps[0].endswith(".")  # a shell would put a blank behind it
    return _stepwise(fitting, steps[0]) if one else steps
