"""Models as text in, flat models out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir import flat
from planarc.parse.parser import parse_annotation, parse_file, parse_text
from tests.ir.check.flat import check_model


@pytest.fixture
def library() -> Callable[..., Library]:
    def make(*roots: Path) -> Library:
        return Library(roots, parse_file, parse_annotation)

    return make


@pytest.fixture
def flatten_text(library: Callable[..., Library]) -> Callable[..., flat.FlatModel]:
    """The flat model of the last class of a text."""

    def run(text: str, *roots: Path) -> flat.FlatModel:
        made = library(*roots, stdlib())
        names = made.add_file(parse_text(Source("test.mo", text)))
        model = flatten(made, names[-1])
        check_model(model)
        return model

    return run
