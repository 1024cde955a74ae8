"""A table of results, whoever wrote it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Generic, TypeVar

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.view.table.origin import Origin

Place = TypeVar("Place")


class Columns(Mapping[str, "Vector"], Generic[Place]):
    """Columns by name, each read from its place when it is asked for."""

    def __init__(self, places: Mapping[str, Place], read: Callable[[Place], Vector]) -> None:
        self._places, self._read = places, read

    def __getitem__(self, name: str) -> Vector:
        return self._read(self._places[name])

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


class Table(Data):
    """Columns over time. `units` only holds those that the file told; `model` is the class
    of the model, where it is said, and `origin` tells where that stands."""

    time: Vector
    columns: Mapping[str, Vector]
    units: Mapping[str, str]
    model: str = ""
    origin: Origin | None = None

    def __getitem__(self, name: str) -> Vector:
        return self.time if name == "time" else self.columns[name]

    def __contains__(self, name: str) -> bool:
        return name == "time" or name in self.columns

    def refuse_unknown(self, names: Iterable[str]) -> None:
        """Raise UnknownName for the first name that is not there."""
        from planarc.core.unknown import refuse_unknown

        refuse_unknown("variable", (n for n in names if n != "time"), self.columns)
