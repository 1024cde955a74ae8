"""Systems of linear equations that a function solves, as equations of the model.

In:   a call of LAPACK's solver whose matrix or right sides change between events
Out:  unknowns, with the equations that they meet

Example:  x = solve({{2, u}, {u, 3}}, {1, 0})   becomes
    2*$solution[1] + u*$solution[2] = 1,  u*$solution[1] + 3*$solution[2] = 0

They can be differentiated, exported and solved in machine code as any others. A call that stands
in one branch only, or at events, stays one: its matrix may be singular elsewhere. So does one in a
turn of a loop, which is no equation of the model.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.core.source import Span
from planarc.ir import dae
from planarc.ir.expr import Expr
from planarc.lower.scope import SOLUTION, Scope
from planarc.lower.values import Value, exprs

#: The function of `runtime.external` that solves them.
SOLVER = "planarc_solution"


def as_unknowns(scope: Scope, given: Sequence[Value], span: Span) -> Iterator[Expr] | None:
    """What the function would give; None where the call is to stay."""
    model = scope.model
    n, m, *entries = (e for value in given for e in exprs(value))
    is_open = scope.at_event or scope.path is not None or not (n.is_const and m.is_const)
    if is_open or model.turning or all(map(model.is_steady, entries)):
        return None
    rows, columns = int(n.data), int(m.data)
    key = (rows, *entries)
    if key not in model.solutions:
        model.solutions[key] = _unknowns(scope, rows, columns, entries, span)
    return iter((*model.solutions[key], model.table.const(0)))


def _unknowns(
    scope: Scope, rows: int, columns: int, entries: Sequence[Expr], span: Span
) -> tuple[Expr, ...]:
    model, t = scope.model, scope.table
    matrix, right = entries[: rows * rows], entries[rows * rows :]
    first = len(model.added) + 1
    names = [f"{SOLUTION}{first + i}]" for i in range(rows * columns)]
    x = tuple(map(t.symbol, names))
    for i, name in enumerate(names):
        row, column = divmod(i, columns)
        terms = (t.mul(matrix[row * rows + k], x[k * columns + column]) for k in range(rows))
        equation = dae.Equation(t.add(*terms), right[i], span, model.component)
        model.added.append((dae.Variable(name, protected=True, span=span), equation))
    return x
