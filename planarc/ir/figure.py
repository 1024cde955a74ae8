"""Figures that a model's documentation proposes (18.4.3 of the specification, `figures`)."""

from __future__ import annotations

from planarc.core.data import Data


class Plot(Data):
    """`curves` are names of variables over time."""

    title: str
    curves: tuple[str, ...]


class Figure(Data):
    title: str
    plots: tuple[Plot, ...]
    preferred: bool = False
