"""The step that closes loops at sample positions is the shortest one, also where loops repeat."""

from __future__ import annotations

import numpy as np
import pytest

from planarc.codegen.samples import _shortest


@pytest.mark.parametrize(
    "rows",
    [
        ((1.0, 2.0, 0.0), (0.0, 1.0, 3.0)),
        ((1.0, 2.0, 0.0), (2.0, 4.0, 0.0)),
        ((1.0, 2.0, 0.0), (0.0, 0.0, 0.0)),
        ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)),
    ],
    ids=["independent", "twice", "empty", "more conditions than unknowns"],
)
def test_shortest_step(rows: tuple[tuple[float, ...], ...]) -> None:
    jacobian, r = np.array(rows), np.arange(1.0, len(rows) + 1)
    assert _shortest(jacobian, r) == pytest.approx(np.linalg.pinv(jacobian) @ r, abs=1e-12)
