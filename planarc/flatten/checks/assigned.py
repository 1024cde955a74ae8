"""Variables that have a value for all times where they are declared, and that an algorithm sets.

In:   the algorithms and variables of a model
Out:  errors F320

    Real sum = 0;                           is an equation: `sum` is 0 for ever
  algorithm
    for i in 1:3 loop sum := sum + m[i]; end for;

Reference: Modelica Language Specification 3.6, section 11.1.2.
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.core.diagnostic import Diagnostic, Related
from planarc.flatten.tree.nodes import Session
from planarc.ir import flat
from planarc.ir.flatwalk import inside, set_by


def check_assigned(
    algorithms: Iterable[flat.Algorithm], variables: Iterable[flat.Variable], session: Session
) -> None:
    """Report what is given by a declaration and by an algorithm."""
    bound = {v.name: v for v in variables if v.binding is not None}
    for algorithm in algorithms if bound else ():
        for statement in inside(algorithm.statements):
            for target in set_by(statement):
                variable = bound.pop(target.name, None)
                if variable is not None and variable.variability > flat.Variability.PARAMETER:
                    session.errors.append(_given_twice(variable, target, statement))


def _given_twice(
    variable: flat.Variable, target: flat.Reference, statement: flat.Statement
) -> Diagnostic:
    assert variable.binding is not None
    name = target.span.text.partition("[")[0]
    value = " ".join(variable.binding.span.text.split())
    return Diagnostic(
        "F320",
        f"`{variable.name}` is set in an algorithm, but its declaration gives it a value for all "
        "times",
        statement.span,
        hint=f"leave `= {value}` out of the declaration, and begin the algorithm with "
        f"`{name} := {value};`",
        related=(Related(f"`{variable.name}` is declared here", variable.span),),
    )
