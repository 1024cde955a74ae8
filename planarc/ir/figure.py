"""Figures that a model's documentation proposes (18.4.3 of the specification, `figures`)."""

from __future__ import annotations

from typing import Literal, TypeAlias

from planarc.core.data import Data

#: A step of an evaluation, operands first: a number, a variable, an operator or a function.
Step: TypeAlias = "float | tuple[Literal['variable', 'apply'], str]"


class Formula(Data):
    """An expression in variables of the result. `steps` take their operands from a stack."""

    text: str
    steps: tuple[Step, ...]


class Plot(Data):
    """A plot of a figure. `curves` are names of variables over time, or texts of formulas, which
    stand in `formulas` as well."""

    title: str
    curves: tuple[str, ...]
    formulas: tuple[Formula, ...] = ()


class Figure(Data):
    title: str
    plots: tuple[Plot, ...]
    preferred: bool = False
