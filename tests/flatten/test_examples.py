"""The flat models of the examples, beside their text."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planarc.core.resources import stdlib
from planarc.flatten.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir.flatcheck import check_model
from planarc.ir.flattext import print_model
from planarc.parse.parser import parse_annotation, parse_file

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("name", ["pendulum", "double_pendulum", "crank_slider", "four_bar"])
def test_flat_model(name: str, golden: Callable[[str, str], None]) -> None:
    path = EXAMPLES / f"{name}.pmo"
    library = Library([stdlib()], parse_file, parse_annotation)
    names = library.add_file(parse_file(path))
    model = flatten(library, names[-1])
    check_model(model)
    text = path.read_text(encoding="utf-8") + "\n// Flat model:\n\n" + print_model(model)
    golden(f"flat/{name}.txt", text)
