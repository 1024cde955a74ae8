"""Expressions get types, however long they are."""

from __future__ import annotations

from collections.abc import Callable

from planarc.ir import flat
from planarc.ir.text.flat import print_model

Flatten = Callable[..., flat.FlatModel]


def test_a_long_sum_does_not_exhaust_the_stack(flatten_text: Flatten) -> None:
    model = flatten_text("model T Real x = " + "+".join(["time"] * 900) + "; end T;")
    assert print_model(model).count("time") == 900
