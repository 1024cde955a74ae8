"""`planarc check`: look for mistakes without running."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from msgspec.structs import replace

from planarc.cli import console
from planarc.cli.arguments import AsJson, ClassName, Libraries, Target, make_request
from planarc.cli.exits import Exit
from planarc.cli.line import Option
from planarc.cli.outcome import Outcome
from planarc.core.diagnostic import usage_error
from planarc.core.options import Units

if TYPE_CHECKING:
    from planarc.ir.mechanism import Mechanism, Mobility


def check(
    target: Target,
    class_name: ClassName = None,
    library: Libraries = None,
    every: Annotated[
        bool,
        Option(
            "--all",
            help="Check every class of a package, a folder or a file, on all processor cores.",
        ),
    ] = False,
    start: Annotated[
        bool,
        Option(
            "--start",
            help="Make it an error where the model cannot be put together at the start.",
        ),
    ] = False,
    units: Annotated[
        Units, Option("--units", help="What becomes of units that differ.", show_default=True)
    ] = Units.WARN,
    as_json: AsJson = False,
) -> int:
    """Check a model without running it.

    Names, types, connections, and the count of equations and unknowns; of a mechanism its bodies,
    joints, loops, mobility by count and by rank, and redundant joints.
    """
    if every:
        return _check_all(target, class_name, library, units, as_json)
    from planarc.core.clock import Clock
    from planarc.probe.check import check_model, summary_of

    clock = Clock()
    request = replace(make_request(target, class_name, library), units=units)
    found = check_model(request, clock, start)
    warnings = found.warnings
    if found.mobility is not None and found.mobility.redundant is not None:
        warnings += (found.mobility.redundant,)
    if as_json:
        seconds = {**clock.seconds, "total": sum(clock.seconds.values())}
        sizes = (found.equations_before, found.equations_after)
        outcome = Outcome(True, found.name, sizes, seconds=seconds, diagnostics=warnings)
        outcome.mechanism = _counts(found.mechanism, found.mobility)
        console.say(outcome.as_json())
        return 0
    console.complain(warnings)
    for line in summary_of(found):
        console.say(line)
    return 0


def _counts(mechanism: Mechanism | None, mobility: Mobility | None) -> dict[str, int | None] | None:
    if mechanism is None:
        return None
    m, rank = mechanism, None if mobility is None else mobility.rank
    counted = {"bodies": m.bodies, "joints": m.pairs, "loops": m.loops, "mobility": m.mobility}
    return {**counted, "mobility_by_rank": rank}


def _check_all(
    target: str, class_name: str | None, library: list[Path] | None, units: Units, as_json: bool
) -> int:
    from planarc.catalog.survey import survey
    from planarc.cli.progress import counting_line
    from planarc.cli.survey_text import as_text, to_json

    if class_name is not None:
        raise usage_error(
            "C118",
            f"`--all` checks all of `{target}`, not only `{class_name}`",
            hint="leave out the class, or leave out `--all`",
        )
    request = replace(make_request(target, None, library), units=units)
    with counting_line() as progress:
        found = survey(request, progress=progress)
    if as_json:
        console.say(to_json(found))
    else:
        causes, table = as_text(found)
        console.warn(causes)
        console.say(table)
    return Exit.MODEL if found.total.bad else Exit.DONE
