"""Errors for what both back ends refuse."""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.closing import applied
from planarc.ir.expr import below
from planarc.ir.program import EquationInfo, Program


class NotDifferentiable(PlanarcError):
    """A derivative of an external function is asked for, which only its author could tell."""

    def __init__(self, function: str) -> None:
        self.function = function
        super().__init__(
            Diagnostic(
                "G401",
                f"the external function `{function}` cannot be differentiated",
                hint="call it in a when-clause, or with arguments that change at events only",
            )
        )


def _calls(equation: EquationInfo, function: str) -> bool:
    if isinstance(equation.written, str):
        return function in equation.written
    return any(name == function for e in below(equation.written) for name, *_ in applied(e))


def located(problem: PlanarcError, program: Program) -> PlanarcError:
    """The refusal at the first equation that calls the function."""
    if not isinstance(problem, NotDifferentiable):
        return problem
    for equation in program.equations:
        if _calls(equation, problem.function):
            first = problem.diagnostics[0]
            return PlanarcError(replace(first, span=equation.span))
    return problem
