"""Which integrator runs, and why."""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.options import FIXED_STEP, Solver
from planarc.ir.kernel import Kernel
from planarc.solve.solvers.integrator import Integrator, Settings
from planarc.solve.solvers.sundials import Unavailable

#: The method of scipy behind each solver.
_SCIPY = {Solver.LSODA: "LSODA", Solver.SCIPY_BDF: "BDF"}


def make_integrator(
    wanted: Solver, kernel: Kernel, states: int, settings: Settings
) -> tuple[Integrator, str]:
    """The integrator and the reason for it. Raises R450 where the one asked for is missing."""
    if states == 0:
        from planarc.solve.solvers.stateless import Stateless

        return Stateless(kernel, settings), "the model has no states"
    if wanted in FIXED_STEP and settings.fixed_step is not None:
        from planarc.solve.solvers.fixed import FixedStep

        fixed = FixedStep(kernel, states, settings, wanted.value, settings.fixed_step)
        return fixed, "a fixed step was asked for"
    if wanted in _SCIPY:
        return _scipy(kernel, states, settings, _SCIPY[wanted]), "asked for"
    try:
        if wanted is Solver.IDA:
            from planarc.solve.solvers.ida import IdaIntegrator

            return IdaIntegrator(kernel, states, settings), "asked for"
        from planarc.solve.solvers.cvode import Cvode

        integrator = Cvode(kernel, states, settings, wanted is Solver.CVODE_ADAMS)
    except Unavailable as problem:
        if wanted is Solver.AUTO:
            return _scipy(kernel, states, settings, "LSODA"), f"no CVODE: {problem}"
        raise PlanarcError(
            Diagnostic(
                "R450",
                f"the solver `{wanted}` cannot be used here: {problem}",
                hint="choose `auto`, `lsoda` or `scipy-bdf`",
            )
        ) from None
    reason = "BDF suits ordinary mechanisms" if wanted is Solver.AUTO else "asked for"
    if integrator.krylov:
        reason += f", GMRES {states} states"
    return integrator, reason


def _scipy(kernel: Kernel, states: int, settings: Settings, method: str) -> Integrator:
    from planarc.solve.solvers.scipy import ScipyIntegrator

    return ScipyIntegrator(kernel, states, settings, method)
