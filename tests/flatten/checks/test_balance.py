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


def test_parts_that_meet_at_an_inner_connector_are_balanced(flatten_text: Flatten) -> None:
    text = """
    connector Pin Real v; flow Real i; end Pin;
    model S Pin c; equation c.v = 5; end S;
    model L Pin c; equation c.v = 1; c.i = 2; end L;
    model Source outer Pin bus; S s; equation connect(s.c, bus); end Source;
    model Load outer Pin bus; L l; equation connect(l.c, bus); end Load;
    model T inner Pin bus; Source a; Load b; end T;
    """
    with pytest.raises(PlanarcError) as caught:
        flatten_text(text)
    (problem,) = caught.value.diagnostics
    notes = [r.message for r in problem.related]
    assert notes == ["the component `b.l` (a `L`) has 1 equation too many"]
