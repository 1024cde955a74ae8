"""What counts as the user's own text, and which component of theirs a name belongs to."""

from __future__ import annotations

from pathlib import Path

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Source, Span
from planarc.ir.flat import Part
from planarc.ir.places import is_own, own_names, point_home


class Model(Data):
    name: str
    span: Span
    parts: tuple[Part, ...]


def span(file: str) -> Span:
    return Span(Source(file, "text", Path("/home") / file), 0, 4)


LIBRARY = span("lib/Parts/Bar.pmo")
MODEL = Model(
    "Mine.Crank",
    span("models/Mine/Crank.pmo"),
    (
        Part("rod", "Lib.Parts.BodyShape", span("models/Mine/Crank.pmo")),
        Part("rod.bar", "Lib.Parts.Bar", LIBRARY),
    ),
)


def test_files_of_the_package_are_own_and_libraries_are_not() -> None:
    assert is_own(MODEL, MODEL.span)
    assert is_own(MODEL, span("models/Mine/Parts/Rod.pmo"))
    assert not is_own(MODEL, LIBRARY)
    assert not is_own(MODEL, NOWHERE)


def test_a_part_inside_of_a_part_is_called_by_the_one_that_the_user_declared() -> None:
    assert own_names(MODEL, ["rod.bar", "rod", "other"]) == ["rod", "other"]


def test_a_message_about_a_library_points_at_the_declaration_and_keeps_its_place_last() -> None:
    found = point_home(MODEL, Diagnostic("R412", "too short", LIBRARY), "rod.bar")
    assert found.span == MODEL.parts[0].span
    assert [r.span for r in found.related] == [LIBRARY]
