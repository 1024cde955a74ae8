"""`planarc linearize`: the linear model at a point, and its modes."""

from __future__ import annotations

from typing import Annotated

from planarc.cli import console
from planarc.cli.analysis import (
    number,
    number_or_word,
    open_model,
    say_json,
    say_table,
    with_settings,
)
from planarc.cli.arguments import (
    AsJson,
    ClassName,
    Libraries,
    RedundantJoints,
    Settings,
    Target,
    offers,
)
from planarc.cli.line import Option
from planarc.core.options import Redundant
from planarc.core.prose import counted, listed


def linearize(
    target: Target,
    class_name: ClassName = None,
    at: Annotated[
        str, Option(metavar="WHERE", help="`start`, `equilibrium`, or a time: 0.5 or 500ms.")
    ] = "start",
    outputs: Annotated[
        list[str] | None,
        Option(
            "--output-of",
            metavar="NAME",
            help="A variable as output. Repeatable.",
            autocompletion=offers("variables"),
        ),
    ] = None,
    settings: Settings = None,
    library: Libraries = None,
    redundant: RedundantJoints = Redundant.REFUSE,
    as_json: AsJson = False,
) -> int:
    """Linearize a model at a point, and show its modes.

    With --json also the matrices A, B, C, D, with the names of their rows and columns.
    """  # fmt: skip
    model = open_model(target, class_name, library, redundant=redundant)
    model, values, starts = with_settings(model, settings)
    point = number_or_word(at)
    found = model.linearize(point, parameters=values, start=starts, outputs=outputs)
    modes = [
        {
            "eigenvalue": [m.eigenvalue.real, m.eigenvalue.imag],
            "natural_frequency": m.natural_frequency,
            "frequency": m.frequency,
            "damping": m.damping,
            "shape": {n: [z.real, z.imag] for n, z in m.shape.items()},
        }
        for m in found.modes
    ]
    console.complain(found.warnings)
    if as_json:
        matrices = {n: getattr(found, n).tolist() for n in "ABCD"}
        names = {n: list(getattr(found, n)) for n in ("states", "inputs", "outputs")}
        known = {n: found.values[n] for n in found.states if n in found.values}
        say_json(
            {"model": model.name, "time": found.time, "point": known, "stable": found.stable}
            | {"derivatives": found.derivatives, "holding": list(found.holding)}
            | names | matrices | {"modes": modes}
        )  # fmt: skip
        return 0
    rows = [
        (
            f"{m.eigenvalue.real:.6g} {'+' if m.eigenvalue.imag >= 0 else '-'} "
            f"{abs(m.eigenvalue.imag):.6g}i",
            number(m.natural_frequency),
            number(m.frequency),
            number(m.damping),
            m.mostly,
        )
        for m in found.modes
    ]
    states = counted(len(found.states), "state")
    held = f"; others are held by {listed(found.holding)}" if found.holding else ""
    console.say(f"{model.name} at t = {found.time:.6g} s: {states}{held}")
    say_table(("eigenvalue [1/s]", "natural [rad/s]", "damped [Hz]", "damping", "mostly"), rows)
    return 0
