"""`planarc check`: look for mistakes without running, and without numerics."""

from __future__ import annotations

from planarc.cli import console
from planarc.cli.arguments import AsJson, ClassName, Libraries, Target, make_request
from planarc.cli.outcome import Outcome


def check(
    target: Target,
    class_name: ClassName = None,
    library: Libraries = None,
    as_json: AsJson = False,
) -> int:
    """Check a model without running it.

    Names, types, connections, and the count of equations and unknowns.
    """
    from planarc import compiler
    from planarc.request import open_target

    clock = compiler.Clock()
    flat = compiler.flatten(open_target(make_request(target, class_name, library)), clock)
    model = compiler.to_sorted(compiler.to_dae(flat, clock), clock)
    warnings = (*flat.warnings, *model.dae.warnings)
    if as_json:
        seconds = {**clock.seconds, "total": sum(clock.seconds.values())}
        sizes = (model.equations_before, model.equations_after)
        outcome = Outcome(True, flat.name, sizes, seconds=seconds, diagnostics=warnings)
        console.say(outcome.as_json())
        return 0
    console.complain(warnings)
    console.say(
        f"{flat.name} is complete: {model.equations_before} equations for as many unknowns, "
        f"{model.equations_after} after reduction, {model.state_count} states"
    )
    return 0
