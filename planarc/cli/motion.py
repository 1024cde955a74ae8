"""The motion that a picture or a plot shows: read from a result, run, or of one mode."""

from __future__ import annotations

from pathlib import Path

from planarc.api.model import Model
from planarc.api.restore import compile_guess, compile_request, find_request, of_origin, restore
from planarc.api.result import Result, RunStopped
from planarc.cli import console
from planarc.cli.analysis import number_or_word, with_settings
from planarc.cli.arguments import make_request
from planarc.compiled import Compiled
from planarc.core.diagnostic import usage_error
from planarc.core.options import Redundant
from planarc.ir.result import Result as Rows
from planarc.request.request import Request
from planarc.view.table.files import read_table
from planarc.view.table.table import Table


def named_output(output: Path | None, example: str) -> Path:
    if output is None:
        raise usage_error("C270", "`--output` is missing", hint=f"write e.g. `{example}`")
    return output


def refuse_run(
    mode: int | None, stop: float | None, settings: list[str] | None, redundant: Redundant
) -> None:
    """Refuse options of a run where its result is shown."""
    accepted = None if redundant is Redundant.REFUSE else redundant
    options = {"--mode": mode, "--stop": stop, "--set": settings, "--redundant": accepted}
    for name, given in options.items():
        if given is not None:
            raise usage_error(
                "C272",
                f"`{name}` needs a model: a result is not run again",
                hint="name the model instead of the result",
            )


def read_result(
    path: Path, model: str | None, class_name: str | None, library: list[Path] | None
) -> Rows:
    """A result that was written before, with the model that says what is drawn."""
    table = read_table(path)
    _, compiled = find_model(path, table, model, class_name, library)
    if compiled is None:
        raise usage_error(
            "C273",
            f"no model is found that made `{path}`: it says what is drawn",
            hint="name it with `--model FILE`",
        )
    return restore(table, path.name, compiled).result


def find_model(
    path: Path,
    table: Table,
    model: str | None = None,
    class_name: str | None = None,
    library: list[Path] | None = None,
) -> tuple[Request | None, Compiled | None]:
    """The model of a result: the one that is named, or one that is called as the result says."""
    if model is not None:
        request = make_request(model, class_name, library)
        return request, compile_request(request)
    if table.origin is not None and class_name is None:
        told = of_origin(table.origin)
        compiled = None if told is None else compile_guess(told, table)
        if compiled is not None:
            return told, compiled
    name = class_name or table.model or path.stem
    guess = find_request(name, (path.parent, Path()), tuple(library or ()))
    return guess, None if guess is None else compile_guess(guess, table)


def run_of(model: Model, settings: list[str] | None, stop: float | None) -> Result:
    """A run of the model; one that ends before its time is told, and taken as far as it went."""
    model, values, starts = with_settings(model, settings)
    try:
        return model.simulate(stop, parameters=values, start=starts)
    except RunStopped as stopped:
        if not len(stopped.result):
            raise
        console.complain(stopped.diagnostics)
        return stopped.result


def motion_of_mode(
    model: Model, settings: list[str] | None, number: int, around: str, amplitude: float
) -> Rows:
    """A small motion of one mode, drawn large."""
    model, values, starts = with_settings(model, settings)
    linear = model.linearize(number_or_word(around), parameters=values, start=starts)
    if not 1 <= number <= len(linear.modes):
        raise usage_error(
            "C271",
            f"there is no mode {number}: the linear model has {len(linear.modes)}",
            hint="`planarc linearize` lists them",
        )
    return linear.motion(number - 1, amplitude).rows
