"""The component whose count is off is named, and what nothing determines."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir import flat

Flatten = Callable[..., flat.FlatModel]


@pytest.mark.parametrize(
    ("equations", "notes"),
    [
        ("x = 1;", ["the component `m` (a `M`) has 1 equation too few", "no equation names `m.y`"]),
        ("x = 1; y = 2; x = y;", ["the component `m` (a `M`) has 1 equation too many"]),
    ],
)
def test_the_component_is_named(flatten_text: Flatten, equations: str, notes: list[str]) -> None:
    with pytest.raises(PlanarcError) as caught:
        flatten_text(f"model M Real x; Real y; equation {equations} end M; model T M m; end T;")
    (problem,) = caught.value.diagnostics
    assert problem.code == "F320"
    assert [r.message for r in problem.related] == notes
