"""`planarc flatten`: the flat model as Modelica text."""

from __future__ import annotations

from planarc.cli import console
from planarc.cli.arguments import ClassName, Libraries, Target, Undrawn, make_request


def flatten(
    target: Target,
    class_name: ClassName = None,
    no_drawing: Undrawn = False,
    library: Libraries = None,
) -> int:
    """Print the flat model as Modelica text."""
    from planarc import stages
    from planarc.ir.text.flat import print_model
    from planarc.ir.undrawn import without_drawing
    from planarc.request.request import open_target

    model = stages.flatten(open_target(make_request(target, class_name, library)))
    console.complain(model.warnings)
    console.say(print_model(without_drawing(model) if no_drawing else model))
    return 0
