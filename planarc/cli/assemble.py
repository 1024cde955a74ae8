"""`planarc assemble`: all ways to put a mechanism together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.analysis import open_model, say_json, say_table, with_settings
from planarc.cli.arguments import AsJson, ClassName, Libraries, RedundantJoints, Settings, Target
from planarc.cli.line import Option
from planarc.core.options import Redundant

if TYPE_CHECKING:
    from planarc.api.model import Model

#: Guesses from which the assemblies of a loop or two are found.
TRIES = 200


def assemble(
    target: Target,
    class_name: ClassName = None,
    tries: Annotated[int, Option(help="Guesses to start from.")] = TRIES,
    settings: Settings = None,
    library: Libraries = None,
    redundant: RedundantJoints = Redundant.REFUSE,
    as_json: AsJson = False,
) -> int:
    """Find all assemblies of a mechanism, as start values.

    The first is the nearest to the start values in the model.
    """
    model = open_model(target, class_name, library, redundant=redundant)
    return tell_assemblies(model, settings, as_json, tries)


def tell_assemblies(
    model: Model, settings: Sequence[str] | None, as_json: bool, tries: int = TRIES
) -> int:
    """Print the start values of each assembly, as a table or as JSON."""
    model, values, starts = with_settings(model, settings)
    found = model.assemble(parameters=values, start=starts, tries=tries)
    if as_json:
        listed = [{"start": dict(a.start), "distance": a.distance} for a in found]
        say_json({"model": model.name, "assemblies": listed})
        return 0
    if not found:
        console.say(f"{model.name} has no states: there is nothing to put together")
        return 0
    ways = "one way" if len(found) == 1 else f"{len(found)} ways"
    console.say(f"{model.name} goes together in {ways}")
    names = list(found[0].start)
    head = ("start value", *(str(i) for i in range(1, len(found) + 1)))
    say_table(head, [(n, *(f"{a.start[n]:.8g}" for a in found)) for n in names])
    return 0
