"""Energy that a run lost by its steps, where the model loses none.

In:   Result, the tolerance
Out:  a warning (R429), or None

The integrator's formulas damp what turns round within few of their steps. Each step may be wrong by
the tolerance, so a run of N steps loses some N times the tolerance of its energy: only where
that is much are energies added up, which takes longer than many a run.

Example: 1 kg on 1e6 N/m for 2 s at 1e-6 takes 15,000 steps and loses 3 % of its energy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: Steps times the tolerance below which no loss is looked for.
_LEAST_STEPS = 3e-3
#: The least loss that is told, as a part of all energy exchanged.
_NOTABLE = 1e-2
#: Multiple of what the model itself takes and gives that a loss is: integrals over rows err.
_CLEAR = 2.0


def judge_losses(result: Result, tolerance: float) -> Diagnostic | None:
    """The warning of a loss of energy that no component declares."""
    if result.ended is not None or result.statistics.steps * tolerance < _LEAST_STEPS:
        return None
    if not any(d.kind == "energy" for d in result.program.declared):
        return None
    import numpy as np

    from planarc.insight.energy import find_energies

    energies = find_energies(result, result.program.mechanism)
    if energies is None:
        return None
    lost = -float(energies.balance[-1] - energies.untold[-1])
    own = sum(float(np.ptp(e)) for e in (energies.dissipated, energies.supplied, energies.untold))
    if not lost > max(_NOTABLE * energies.exchanged, _CLEAR * own):
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
