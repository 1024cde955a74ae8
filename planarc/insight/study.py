"""The whole insight into a run's mechanism, in one call."""

from __future__ import annotations

from planarc.insight.energy import Energies, find_energies
from planarc.insight.facts import closeness_facts, energy_facts, mechanism_facts
from planarc.insight.formulas import formula_series
from planarc.insight.kinematics import find_layers
from planarc.insight.rank import Closeness, find_closeness
from planarc.ir.insight import Insight, Series
from planarc.ir.kernel import Kernel
from planarc.ir.result import Result


def study(result: Result, kernel: Kernel | None = None) -> Insight:
    """The insight into a run; ranks only with a kernel, whose workspace is changed."""
    mechanism = result.program.mechanism
    closeness = None if kernel is None else find_closeness(result, kernel)
    energies = find_energies(result, mechanism)
    facts = [] if mechanism is None else mechanism_facts(mechanism)
    if kernel is not None:
        facts += closeness_facts(result, mechanism, closeness)
    facts += energy_facts(energies)
    series = [*_energy_series(energies), *_closeness_series(closeness)]
    energy = tuple(s.name for s in series if s.unit == "J")
    dead = tuple(s.name for s in series if s.unit != "J")
    return Insight(
        tuple(facts),
        (*series, *formula_series(result)),
        (("Energy", energy, True), ("Dead points", dead, False)),
        find_layers(result, mechanism),
    )


def _energy_series(found: Energies | None) -> list[Series]:
    if found is None or not found.exchanged:
        return []
    every = (
        ("kinetic energy", "of all masses and inertias", found.kinetic),
        ("potential energy", "of gravity and springs", found.potential),
        ("mechanical energy", "kinetic and potential", found.mechanical),
        ("dissipated energy", "turned into heat or lost in impacts", found.dissipated),
        ("supplied energy", "put in by drives and applied forces", found.supplied),
        ("untold energy", "put in by components that declare no energy", found.untold),
    )
    # What stays nothing is no curve; the others are told as they are, be they constant.
    small = 1e-9 * found.exchanged
    shown = [Series(n, "J", about, v) for n, about, v in every if abs(v).max() > small]
    both = abs(found.kinetic).max() > small and abs(found.potential).max() > small
    return [s for s in shown if both or s.name != "mechanical energy"]


def _closeness_series(found: Closeness | None) -> list[Series]:
    if found is None:
        return []
    about = "smallest singular value of the loops' conditions, over the largest"
    rows = [Series("closeness to dependent loops", "1", about, found.loops)]
    if found.states:
        held = f"{about}, with {', '.join(found.states)} held"
        rows.append(Series("closeness to a dead point", "1", held, found.held))
    return rows
