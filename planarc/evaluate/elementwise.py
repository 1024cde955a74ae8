"""The functions of the language on NumPy arrays, element by element."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, reduce
from typing import Any

_SAME = "abs sin cos tan sinh cosh tanh exp log log10 sqrt sign floor ceil"


@cache
def functions() -> Mapping[str, Callable[..., Any]]:
    """By their names in `Op.CALL`."""
    import numpy as np

    return {
        **{name: getattr(np, name) for name in _SAME.split()},
        "asin": np.arcsin,
        "acos": np.arccos,
        "atan": np.arctan,
        "atan2": np.arctan2,
        "pow": np.power,
        "min": lambda *values: reduce(np.minimum, values),
        "max": lambda *values: reduce(np.maximum, values),
        "div": lambda x, y: np.trunc(x / y),
        "mod": lambda x, y: x - np.floor(x / y) * y,
        "rem": lambda x, y: x - np.trunc(x / y) * y,
    }
