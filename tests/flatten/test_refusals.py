"""Refusals that no text of an example shows: a class that is not there, and too many bases."""

from __future__ import annotations

from itertools import pairwise

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.parse.parser import parse_annotation, parse_file, parse_text


def codes_of(text: str, class_name: str) -> list[str]:
    library = Library([], parse_file, parse_annotation)
    library.add_file(parse_text(Source("t.mo", text)))
    with pytest.raises(PlanarcError) as caught:
        flatten(library, class_name)
    return [d.code for d in caught.value.diagnostics]


def test_a_class_that_is_not_there() -> None:
    assert codes_of("model Cart end Cart;", "Card") == ["F200"]


def test_bases_that_double_at_each_step() -> None:
    names = [f"M{i}" for i in range(12)]
    models = ["model M0 Real x = 1; end M0;"]
    for below, name in pairwise(names):
        copies = f"model A{name} extends {below}; end A{name};"
        models.append(f"{copies} model {name} extends {below}; extends A{name}; end {name};")
    assert codes_of("\n".join(models), names[-1]) == ["F230"]
