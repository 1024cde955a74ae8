"""Figures that a model's documentation proposes (18.4.3 of the specification, `figures`)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Plot:
    """`curves` are names of variables over time."""

    title: str
    curves: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Figure:
    title: str
    plots: tuple[Plot, ...]
    preferred: bool = False
