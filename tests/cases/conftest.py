"""The entry of the reference cases, as a fixture."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import accuracy


@pytest.fixture
def run() -> Callable[..., Any]:
    return accuracy.run
