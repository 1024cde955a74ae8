"""`planarc equilibrium`: where the mechanism rests."""

from __future__ import annotations

from planarc.cli import console
from planarc.cli.analysis import open_model, say_json, say_table, with_settings
from planarc.cli.arguments import AsJson, ClassName, Libraries, RedundantJoints, Settings, Target
from planarc.core.options import Redundant


def equilibrium(
    target: Target,
    class_name: ClassName = None,
    settings: Settings = None,
    library: Libraries = None,
    redundant: RedundantJoints = Redundant.REFUSE,
    as_json: AsJson = False,
) -> int:
    """Find the static equilibrium below the start, as start values.

    The way leads downhill from the start values, so it ends in a stable equilibrium.
    """
    model = open_model(target, class_name, library, redundant=redundant)
    model, values, starts = with_settings(model, settings)
    found = model.equilibrium(parameters=values, start=starts)
    console.complain(found.warnings)
    if as_json:
        told = {"stable": found.stable, "neutral": found.neutral}
        say_json({"model": model.name, **told, "start": found.start, "values": found.values})
        return 0
    if not model.program.state_count:
        console.say(f"{model.name} has no states: nothing in it comes to rest by itself")
        return 0
    article = "an" if found.kind == "unstable" else "a"
    console.say(f"{model.name} rests in {article} {found.kind} equilibrium")
    say_table(("start value", ""), [(n, f"{v:.10g}") for n, v in found.start.items()])
    return 0
