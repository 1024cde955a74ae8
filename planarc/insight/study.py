"""The whole insight into a run's mechanism, in one call."""

from __future__ import annotations

from planarc.core.arrays import Vector
from planarc.insight.drives import find_drives
from planarc.insight.energy import Energies, find_energies
from planarc.insight.facts import closeness_facts, energy_facts, mechanism_facts
from planarc.insight.formulas import formula_series
from planarc.insight.kinematics import find_layers
from planarc.insight.peaks import find_peaks
from planarc.insight.rank import Closeness, find_closeness
from planarc.insight.values import Values
from planarc.ir.insight import DRIVES, Insight, Series
from planarc.ir.kernel import Kernel
from planarc.ir.result import Result


def study(result: Result, kernel: Kernel | None = None, peaks: bool = True) -> Insight:
    """The insight into a run; ranks only with a kernel, whose workspace is changed.

    Without `peaks`, which cost time and only a table shows, there are none.
    """
    mechanism, values = result.program.mechanism, Values(result)
    closeness = None if kernel is None else find_closeness(result, kernel)
    energies = find_energies(result, mechanism, values)
    facts = [] if mechanism is None else mechanism_facts(mechanism)
    if kernel is not None:
        facts += closeness_facts(result, mechanism, closeness)
    facts += energy_facts(energies)
    drives = find_drives(result, values)
    power = [Series(f"{d.name} power", "W", "put in by it", d.power) for d in drives]
    energy, dead = _energy_series(energies), _nearness_series(closeness)
    driving = (*(name for d in drives for name in d.efforts), *(s.name for s in power))
    return Insight(
        tuple(facts),
        (*power, *energy, *dead, *formula_series(result)),
        (
            (DRIVES, driving, True),
            ("Energy", tuple(s.name for s in energy), True),
            ("Dead points", tuple(s.name for s in dead), False),
        ),
        find_layers(result, mechanism, values),
        find_peaks(result, mechanism, drives, values) if peaks else (),
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


def _nearness_series(found: Closeness | None) -> list[Series]:
    """How near loops are to losing a condition, and states to a dead point: up means danger."""
    if found is None:
        return []
    about = "powers of ten by which forces grow: 0 is far from it, 3 a thousandfold"
    rows = [Series("nearness to dependent loops", "1", about, _nearness(found.loops))]
    if found.states:
        held = f"{about}, with {', '.join(found.states)} held"
        rows.append(Series("nearness to a dead point", "1", held, _nearness(found.held)))
    return rows


def _nearness(distance: Vector) -> Vector:
    """-log10 of a distance that is 1 far away and 0 where it is lost, to the limit of numbers."""
    import numpy as np

    nearness: Vector = -np.log10(np.clip(distance, 1e-12, 1.0))
    return nearness
