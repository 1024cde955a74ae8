"""Small models around a world, for tests of components by law."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import planarc

both_backends = pytest.mark.parametrize("backend", ["native", "numpy"])

#: Examples that take minutes with NumPy: where their runs end there, in seconds.
BEGINNINGS = {"chain_over_peg": 0.02}

G = 9.81
FREE = "gravityType=PlanarMultiBody.Types.GravityTypes.NoGravity"


@cache
def model(body: str, world: str, backend: str) -> planarc.Model:
    """Declarations and equations with a world of these modifiers, compiled once."""
    text = (
        f"model Test\n  import PlanarMultiBody.*;\n  inner World world({world});\n{body}end Test;\n"
    )
    return planarc.load(text, backend=backend)


def run(body: str, stop: float, backend: str, world: str = "", **options: Any) -> Any:
    options = {"tolerance": 1e-10, **options}
    return model(body, world, backend).simulate(stop_time=stop, backend=backend, **options)
