"""Small models written in the tests, simulated to tight tolerance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

HEAD = """
  import PlanarMultiBody.{Curves, Forces, Frames, Interfaces, Joints, Parts, Sensors, Types, World};
"""


def simulate(body: str, stop: float = 1.0, tolerance: float = 1e-9, world: str = "") -> Any:
    """The result of a model: declarations and equations, with a world unless one is declared.

    `world` are the modifiers of the world; 101 rows, more at events.
    """
    from planarc.compiler import compile_model, run
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

    ground = "" if "inner " in body else f"  inner World world({world});\n"
    text = f"model Test{HEAD}{ground}{body}\nend Test;\n"
    options = RunOptions(stop=stop, intervals=100, tolerance=tolerance)
    return run(compile_model(Request(text=text)), options)


@pytest.fixture
def run() -> Callable[..., Any]:
    return simulate
