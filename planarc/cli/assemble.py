"""`planarc assemble`: all ways to put a mechanism together."""

from __future__ import annotations

from typing import Annotated

import typer

from planarc.cli import console
from planarc.cli.analysis import Settings, open_model, say_json, say_table, settings_of
from planarc.cli.arguments import AsJson, ClassName, Libraries, Target


def assemble(
    target: Target,
    class_name: ClassName = None,
    tries: Annotated[int, typer.Option(help="Guesses to start from.")] = 200,
    settings: Settings = None,
    library: Libraries = None,
    as_json: AsJson = False,
) -> int:
    """Find all assemblies of a mechanism, as start values.

    The first is the nearest to the start values in the model.
    """
    model = open_model(target, class_name, library)
    values, starts = settings_of(model, settings)
    found = model.assemble(parameters=values, start=starts, tries=tries)
    if as_json:
        listed = [{"start": dict(a.start), "distance": a.distance} for a in found]
        say_json({"model": model.name, "assemblies": listed})
        return 0
    ways = "one way" if len(found) == 1 else f"{len(found)} ways"
    console.say(f"{model.name} goes together in {ways}")
    names = list(found[0].start) if found else []
    head = ("start value", *(str(i) for i in range(1, len(found) + 1)))
    say_table(head, [(n, *(f"{a.start[n]:.8g}" for a in found)) for n in names])
    return 0
