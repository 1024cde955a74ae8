"""Whether equations and unknowns fit; why they do not is told by `report`, which is loaded then."""

from __future__ import annotations

from planarc.ir.dae import Dae
from planarc.structure.alias import Elimination
from planarc.structure.graph import Rows
from planarc.structure.matching import match_equations


def check_regular(dae: Dae, elimination: Elimination, rows: Rows) -> None:
    """Raise `report.StructurallySingular` when equations and unknowns cannot be matched."""
    if all(rows):
        matching = match_equations(rows, len(elimination.kept))
        if matching.complete and -1 not in matching.equation:
            return
    from planarc.structure.report import explain_unfit

    raise explain_unfit(dae, elimination, rows)
