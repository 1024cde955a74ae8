"""One of the models that a live page may be moved to: other classes, other structural values."""

from __future__ import annotations

from functools import cached_property

from planarc.api.model import Model
from planarc.view.page.controls import Field, Group, groups_of


class Variant:
    """One compiled model with its fields."""

    def __init__(self, model: Model, key: str, seconds: float) -> None:
        self.model, self.key, self.seconds = model, key, seconds
        # Where the last run began, and the start values that it was given: the next one follows.
        self.began: tuple[float, ...] | None = None
        self.began_with: dict[str, float] = {}

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        return groups_of(self.model.program, self.model.compiled().parameters())

    @cached_property
    def names(self) -> dict[str, Field]:
        """The names of the fields; of a start value its variable's with `.start`."""
        return {_field_name(f): f for g in self.groups for f in g.fields}


def _field_name(f: Field) -> str:
    return f"{f.name}.start" if f.start else f.name
