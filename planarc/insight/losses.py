"""Energy that a run lost by its steps, or at a dead point, where the model gives and takes none.

In:   Result, the tolerance
Out:  a warning (R429), or None

The integrator's formulas damp what turns round within few of their steps. Each step may be wrong by
the tolerance, so a run of N steps loses some N times the tolerance of its energy: only where
that is much are energies added up, which takes longer than many a run.

Where a loop comes near to a pose in which it can go on in several ways, accelerations hang on
rounding, and so may all that follows. Mostly a run goes over it within a step; where one ends there
by chance, energy tells.

Examples: 1 kg on 1e6 N/m for 2 s at 1e-6 takes 15,000 steps and loses 3 % of its energy. Of runs of
`Examples.Loops.NFourBar`, parallelograms that are flat 13 times, one in fifty changes its energy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity

if TYPE_CHECKING:
    from planarc.insight.energy import Energies
    from planarc.ir.result import Result

#: Steps times the tolerance below which no loss is looked for.
_LEAST_STEPS = 3e-3
#: The least loss that is told, as a part of all energy exchanged.
_NOTABLE = 1e-2
#: Multiple of what the model itself takes and gives that a loss is: integrals over rows err.
_CLEAR = 2.0
#: The least change of energy that is told of a run that came near to a dead point, as a part of
#: what was exchanged. Steps, as many at least, may each be wrong by several times the tolerance.
_FEWEST, _STEPS, _SEVERAL = 1e-5, 3000, 10


def judge_losses(result: Result, tolerance: float) -> Diagnostic | None:
    """The warning of a change of energy that no component declares."""
    by_steps = (result.statistics.steps or 0) * tolerance >= _LEAST_STEPS
    if result.ended is not None or not (by_steps or result.near_singular):
        return None
    if not any(d.kind == "energy" for d in result.program.declared):
        return None
    from planarc.insight.energy import find_energies

    energies = find_energies(result, result.program.mechanism)
    if energies is None:
        return None
    found = _by_steps(result, energies, tolerance) if by_steps else None
    if found is None and result.near_singular:
        return _at_dead_point(result, energies, tolerance)
    return found


def _by_steps(result: Result, energies: Energies, tolerance: float) -> Diagnostic | None:
    lost = -float(energies.balance[-1] - energies.untold[-1])
    if not lost > max(_NOTABLE * energies.exchanged, _CLEAR * _own(energies)):
        return None
    part = lost / energies.exchanged
    return Diagnostic(
        "R429",
        f"the run lost {lost:.3g} J, {part:.1%} of the energy that was exchanged, which the model "
        f"does not: the {result.statistics.steps:,} steps of the integrator damp what is stiff",
        severity=Severity.WARNING,
        hint=f"lower `--tolerance`, for example to {tolerance / 100:.0e}; or give what is stiff a "
        "damper, or make it rigid",
    )


def _at_dead_point(result: Result, energies: Energies, tolerance: float) -> Diagnostic | None:
    import numpy as np

    change = np.abs(energies.balance - energies.untold)
    most = float(change.max())
    usual = _SEVERAL * max(result.statistics.steps or 0, _STEPS) * tolerance
    least = min(max(usual, _FEWEST), _NOTABLE) * energies.exchanged
    if not most > max(least, _CLEAR * _own(energies)):
        return None
    t, part = float(result.time[np.argmax(change > least / 2)]), most / energies.exchanged
    return Diagnostic(
        "R429",
        f"from about t = {t:.3g} s on the run has {most:.3g} J more or less than the model gives "
        f"and takes, {part:.2g} of the energy that was exchanged: a loop came near to a pose in "
        "which it can go on in several ways, and there accelerations hang on rounding",
        severity=Severity.WARNING,
        hint=f"try another `--tolerance`, for example {tolerance / 2:.0e}: a run no step of which "
        "ends so near to that pose keeps its energy",
    )


def _own(energies: Energies) -> float:
    """What the model itself takes and gives."""
    import numpy as np

    kinds = (energies.dissipated, energies.supplied, energies.untold)
    return sum(float(np.ptp(e)) for e in kinds)
