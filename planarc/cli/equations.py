"""`planarc equations`: the sorted model, block by block."""

from __future__ import annotations

from planarc.cli import console
from planarc.cli.arguments import ClassName, Libraries, Target, make_request


def equations(target: Target, class_name: ClassName = None, library: Libraries = None) -> int:
    """Print the sorted blocks of equations.

    Each with its unknowns, torn variables, states, and source lines.
    """
    from planarc import stages
    from planarc.ir.text.sorted import sorted_text
    from planarc.request.request import open_target

    flat = stages.flatten(open_target(make_request(target, class_name, library)))
    model = stages.to_sorted(stages.to_dae(flat))
    console.complain((*flat.warnings, *model.dae.warnings))
    console.say(sorted_text(model))
    return 0
