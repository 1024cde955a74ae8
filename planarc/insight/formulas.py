"""Curves of expressions that a model's figures ask for, such as `revA.tau*revA.w`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from planarc.evaluate.rows import on_arrays
from planarc.ir.figure import Formula
from planarc.ir.insight import Series
from planarc.ir.result import Result
from planarc.runtime import elementary


def formula_series(result: Result) -> Iterator[Series]:
    """One for each formula of the figures whose variables are all in the result."""
    plots = (plot for figure in result.program.figures for plot in figure.plots)
    known = {f.text: f for plot in plots for f in plot.formulas}
    for formula in known.values():
        with np.errstate(all="ignore"):
            values = _evaluate(formula, result)
        if values is not None:
            rows = values + 0.0 * result.time
            yield Series(formula.text, "", "an expression of the model's figures", rows)


def _evaluate(formula: Formula, result: Result) -> Any:
    stack: list[Any] = []
    for step in formula.steps:
        if isinstance(step, float):
            stack.append(step)
            continue
        what, name = step
        if what == "variable":
            if name != "time" and name not in result:
                return None
            stack.append(result.time if name == "time" else result[name])
        else:
            count, function = _operation(name)
            operands = stack[len(stack) - count :]
            del stack[len(stack) - count :]
            stack.append(function(*operands))
    return stack[-1]


def _operation(name: str) -> tuple[int, Callable[..., Any]]:
    """Operand count and NumPy function, by the names of `flatten.sections.annotations`."""
    row = elementary.TABLE.get(name)
    if row is not None:
        return row.arity, on_arrays(row)
    operators = {
        "+": (2, np.add),
        "-": (2, np.subtract),
        "*": (2, np.multiply),
        "/": (2, np.divide),
        "^": (2, np.power),
        "negative": (1, np.negative),
    }
    return operators[name]
