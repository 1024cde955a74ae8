"""Libraries on disk: which file holds a class, and which root owns a name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.parse.parser import parse_text

Make = Callable[..., Library]


def write(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


PLANAR = {
    "Planar/package.mo": "package Planar constant Real k = 1; model Inside end Inside; end Planar;",
    "Planar/package.order": "Parts\nInside\nJoint\n",
    "Planar/Joint.mo": "within Planar; model Joint end Joint;",
    "Planar/Parts/package.pmo": "within Planar; package Parts end Parts;",
    "Planar/Parts/Body.pmo": "within Planar.Parts; model Body end Body;",
}


def test_one_class_a_file(library: Make, tmp_path: Path) -> None:
    made = library(write(tmp_path, PLANAR))
    body = made.lookup("Planar.Parts.Body")
    assert body is not None and body.name == "Body"
    assert made.lookup("Planar.Inside") is not None
    assert made.lookup("Planar.Parts.Absent") is None
    assert made.lookup("Absent") is None


def test_names_of_a_package_follow_its_order(library: Make, tmp_path: Path) -> None:
    made = library(write(tmp_path, PLANAR))
    assert made.class_names() == ("Planar",)
    assert made.class_names("Planar") == ("Inside", "Parts", "Joint")
    assert made.class_names("Planar.Parts") == ("Body",)


def test_files_are_read_when_asked_for(tmp_path: Path) -> None:
    read: list[str] = []

    def parse(path: Path):  # type: ignore[no-untyped-def]
        read.append(path.name)
        return parse_text(Source(path.name, path.read_text("utf-8")))

    made = Library([write(tmp_path, PLANAR)], parse, lambda annotation: ())
    made.lookup("Planar.Joint")
    assert read == ["package.mo", "Joint.mo"]


@pytest.mark.parametrize("root", [".", "Planar", "Planar/package.mo"])
def test_a_root_is_a_folder_of_libraries_a_package_or_its_file(
    library: Make, tmp_path: Path, root: str
) -> None:
    made = library(write(tmp_path, PLANAR) / root)
    assert made.lookup("Planar.Parts.Body") is not None
    assert "Planar" in made.class_names()


def test_a_root_may_be_one_file_with_several_classes(library: Make, tmp_path: Path) -> None:
    write(tmp_path, {"both.mo": "model A end A; model B end B;"})
    made = library(tmp_path / "both.mo")
    assert made.class_names() == ("A", "B")
    assert made.lookup("B") is not None


def test_the_first_root_owns_a_name(library: Make, tmp_path: Path) -> None:
    first = write(
        tmp_path / "first", {"Planar.mo": "package Planar model Mine end Mine; end Planar;"}
    )
    second = write(tmp_path / "second", PLANAR)
    made = library(first, second)
    assert made.lookup("Planar.Mine") is not None
    assert made.lookup("Planar.Joint") is None


def test_the_highest_version_of_a_folder_is_taken(library: Make, tmp_path: Path) -> None:
    for version in ("3.2", "4.0.0", "10.1"):
        text = f'package Planar "version {version}" end Planar;'
        write(tmp_path, {f"Planar {version}/package.mo": text})
    found = library(tmp_path).lookup("Planar")
    assert found is not None and found.comment == "version 10.1"
    assert library(tmp_path).class_names() == ("Planar",)


def test_a_file_in_the_wrong_place_says_so(library: Make, tmp_path: Path) -> None:
    write(tmp_path, PLANAR | {"Planar/Joint.mo": "within Other; model Joint end Joint;"})
    with pytest.raises(PlanarcError) as caught:
        library(tmp_path).lookup("Planar.Joint")
    assert [d.code for d in caught.value.diagnostics] == ["F205"]


def test_a_file_without_its_class_says_so(library: Make, tmp_path: Path) -> None:
    write(tmp_path, PLANAR | {"Planar/Joint.mo": "within Planar; model Hinge end Hinge;"})
    with pytest.raises(PlanarcError) as caught:
        library(tmp_path).lookup("Planar.Joint")
    assert [d.code for d in caught.value.diagnostics] == ["F206"]


def test_an_added_file_joins_the_package_of_its_within(library: Make, tmp_path: Path) -> None:
    made = library(write(tmp_path, PLANAR))
    stored = parse_text(Source("mine.mo", "within Planar.Parts; model Mine end Mine;"))
    assert made.add_file(stored) == ("Planar.Parts.Mine",)
    assert made.lookup("Planar.Parts.Mine") is not None
    assert made.class_names("Planar.Parts") == ("Body", "Mine")


def test_an_added_file_needs_the_package_of_its_within(library: Make) -> None:
    stored = parse_text(Source("mine.mo", "within Absent; model Mine end Mine;"))
    with pytest.raises(PlanarcError) as caught:
        library().add_file(stored)
    assert [d.code for d in caught.value.diagnostics] == ["F204"]


def test_a_class_added_twice_is_refused(library: Make) -> None:
    made = library()
    made.add_file(parse_text(Source("a.mo", "model A end A;")))
    with pytest.raises(PlanarcError) as caught:
        made.add_file(parse_text(Source("b.mo", "model A end A;")))
    assert [d.code for d in caught.value.diagnostics] == ["F203"]
