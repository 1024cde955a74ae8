"""Products have the dimensions that NumPy gives them; sizes known only when run fit any."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import NOWHERE
from planarc.flatten.typing.operators import binary
from planarc.ir import flat

SHAPES = st.lists(st.integers(1, 3), max_size=2).map(tuple)


def value(dims: flat.Dims) -> flat.Expression:
    return flat.Reference(flat.REAL.with_dims(dims), NOWHERE, "x")


@given(SHAPES, SHAPES)
def test_products(a: tuple[int, ...], b: tuple[int, ...]) -> None:
    try:
        wanted = (np.ones(a) @ np.ones(b) if a and b else np.ones(a) * np.ones(b)).shape
    except ValueError:
        with pytest.raises(PlanarcError):
            binary("*", value(a), value(b), NOWHERE)
    else:
        assert binary("*", value(a), value(b), NOWHERE).type.dims == wanted


@given(SHAPES)
def test_sums_know_what_either_side_knows(a: tuple[int, ...]) -> None:
    unknown: flat.Dims = (None,) * len(a)
    assert binary("+", value(unknown), value(a), NOWHERE).type.dims == a
    assert binary(".*", value(a), value(unknown), NOWHERE).type.dims == a
