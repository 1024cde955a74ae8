"""Which integrator runs, and why.

A solver's name says which module makes it (`core.options.Solver.home`), by a function
`make(solver, kernel, states, settings)` that may raise `Unavailable`.
"""

from __future__ import annotations

from importlib import import_module

from planarc.core.diagnostic import error
from planarc.core.options import Solver
from planarc.ir.kernel import Kernel
from planarc.solve.solvers.integrator import Integrator, Settings
from planarc.solve.solvers.sundials import Unavailable


def make_integrator(
    wanted: Solver,
    kernel: Kernel,
    states: int,
    settings: Settings,
    known: Integrator | None = None,
) -> tuple[Integrator, str]:
    """The integrator and the reason for it: the `known` one of another run, where that can go on
    with this one. Raises R450 where the one asked for is missing."""
    if states == 0:
        from planarc.solve.solvers.stateless import Stateless

        return Stateless(kernel, settings), "the model has no states"
    try:
        renewed = known is not None and known.renew(wanted, settings)
        integrator = known if known and renewed else _made(wanted, kernel, states, settings)
    except Unavailable as problem:
        if wanted is Solver.AUTO:
            return _made(Solver.LSODA, kernel, states, settings), f"no CVODE: {problem}"
        raise error(
            "R450",
            f"the solver `{wanted}` cannot be used here: {problem}",
            hint="choose `auto`, `lsoda` or `scipy-bdf`",
        ) from None
    reason = "BDF suits ordinary mechanisms" if wanted is Solver.AUTO else "asked for"
    return integrator, reason + integrator.remark


def _made(solver: Solver, kernel: Kernel, states: int, settings: Settings) -> Integrator:
    module = import_module(f"planarc.solve.solvers.{solver.home}")
    integrator: Integrator = module.make(solver, kernel, states, settings)
    return integrator
