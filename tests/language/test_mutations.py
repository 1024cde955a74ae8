"""A sample of mutated models; the long run is `python tests/language/mutations.py 20000`."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import ModuleType


def load() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "mutations", Path(__file__).parent / "mutations.py"
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_mutated_models_end_in_a_model_or_in_messages() -> None:
    assert load().run(300, seed=1, limit=math.inf) == []
