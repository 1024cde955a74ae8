"""Pickles that hold data only: numbers, texts, containers, and planarc's own records.

An ordinary pickle may name any function, which is called when it is read. Here only classes of
data are found; whatever else is named ends the reading.
"""

from __future__ import annotations

import io
import pickle
from enum import Enum
from pathlib import PosixPath, WindowsPath
from typing import Any

from msgspec import Struct

from planarc.core.source import NOWHERE, Source

_CLASSES = (Struct, Enum, tuple, Source)
_OTHERS = {
    ("array", "array"),
    ("array", "_array_reconstructor"),
    # Python 3.13 pickles paths by the name of a module inside `pathlib`.
    *((kind.__module__, kind.__name__) for kind in (PosixPath, WindowsPath)),
}


class PlainReader(pickle.Unpickler):
    """Reads data. Raises UnpicklingError where anything else is named."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in _OTHERS:
            return super().find_class(module, name)
        if module.startswith("planarc.") and name.isidentifier():
            found = super().find_class(module, name)
            if isinstance(found, type) and issubclass(found, _CLASSES):
                return found
            if found is NOWHERE:
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is no data")


def loads(data: bytes) -> Any:
    """The value that `pickle.dumps` wrote, if it is data."""
    return PlainReader(io.BytesIO(data)).load()
