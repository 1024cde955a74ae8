"""Curves of expressions that a model's figures ask for, such as `revA.tau*revA.w`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from planarc.ir.figure import Formula
from planarc.ir.insight import Series

if TYPE_CHECKING:
    from planarc.ir.result import Result


def formula_series(result: Result) -> Iterator[Series]:
    """One for each formula of the figures whose variables are all in the result."""
    import numpy as np

    plots = (plot for figure in result.program.figures for plot in figure.plots)
    known = {f.text: f for plot in plots for f in plot.formulas}
    for formula in known.values():
        with np.errstate(all="ignore"):
            values = _evaluate(formula, result)
        if values is not None:
            rows = np.broadcast_to(np.asarray(values, dtype=float), result.time.shape)
            yield Series(formula.text, "", "an expression of the model's figures", rows.copy())


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
            count, function = _functions()[name]
            operands = stack[len(stack) - count :]
            del stack[len(stack) - count :]
            stack.append(function(*operands))
    return stack[-1]


def _functions() -> dict[str, tuple[int, Callable[..., Any]]]:
    """Operand count and NumPy function, by the names of `flatten.sections.figures`."""
    import numpy as np

    one = ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "sqrt", "abs", "sign")
    inverse = {"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan}
    return {
        "+": (2, np.add),
        "-": (2, np.subtract),
        "*": (2, np.multiply),
        "/": (2, np.divide),
        "^": (2, np.power),
        "negative": (1, np.negative),
        "atan2": (2, np.arctan2),
        "max": (2, np.maximum),
        "min": (2, np.minimum),
        "log": (1, np.log),
        "log10": (1, np.log10),
        **{name: (1, getattr(np, name)) for name in one},
        **{name: (1, function) for name, function in inverse.items()},
    }
