"""Examples that were run once for all tests of insight."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import planarc


@pytest.fixture(scope="session")
def run_of() -> Callable[..., Any]:
    """`run_of("Loops.FourBar", tolerance=1e-8)`: the result and a kernel of an example."""
    known: dict[object, Any] = {}

    def make(name: str, **options: Any) -> Any:
        key = (name, *sorted(options.items()))
        if key not in known:
            model = planarc.load(f"PlanarMultiBody.Examples.{name}")
            known[key] = model.simulate(**options).rows, model.compiled().load()
        return known[key]

    return make
