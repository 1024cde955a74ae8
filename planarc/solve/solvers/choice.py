"""Which integrator runs, and why."""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.options import FIXED_STEP, Solver
from planarc.ir.program import Kernel
from planarc.solve.solvers.integrator import Integrator, Settings
from planarc.solve.solvers.sundials import Unavailable


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
    if wanted in (Solver.LSODA, Solver.SCIPY_BDF):
        from planarc.solve.solvers.scipy import ScipyIntegrator

        method = "LSODA" if wanted is Solver.LSODA else "BDF"
        return ScipyIntegrator(kernel, states, settings, method), "asked for"
    try:
        if wanted is Solver.IDA:
            from planarc.solve.solvers.ida import IdaIntegrator

            return IdaIntegrator(kernel, states, settings), "asked for"
        from planarc.solve.solvers.cvode import Cvode

        adams = wanted is Solver.CVODE_ADAMS
        integrator = Cvode(kernel, states, settings, adams)
    except Unavailable as problem:
        if wanted is not Solver.AUTO:
            raise PlanarcError(
                Diagnostic(
                    "R450",
                    f"the solver `{wanted}` cannot be used here: {problem}",
                    hint="choose `auto`, `lsoda` or `scipy-bdf`",
                )
            ) from None
        return _fallback(kernel, states, settings, str(problem))
    reason = "BDF suits ordinary mechanisms" if wanted is Solver.AUTO else "asked for"
    if integrator.krylov:
        reason += f", GMRES {states} states"
    return integrator, reason


def _fallback(
    kernel: Kernel, states: int, settings: Settings, problem: str
) -> tuple[Integrator, str]:
    """Where CVODE's library cannot be opened: its Python interface, else scipy."""
    try:
        from planarc.solve.solvers.sksundae import SksundaeIntegrator

        slow = SksundaeIntegrator(kernel, states, settings, "BDF")
    except ImportError:
        from planarc.solve.solvers.scipy import ScipyIntegrator

        return ScipyIntegrator(kernel, states, settings, "LSODA"), f"no CVODE: {problem}"
    return slow, f"CVODE's library cannot be opened directly: {problem}"
