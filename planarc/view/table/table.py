"""A table of results, whoever wrote it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from planarc.core.data import Data

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Table(Data):
    """Columns over time. `units` only holds those that the file told; `model` is the class
    of the model, where it is said."""

    time: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    units: Mapping[str, str]
    model: str = ""

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.time if name == "time" else self.columns[name]

    def __contains__(self, name: str) -> bool:
        return name == "time" or name in self.columns
