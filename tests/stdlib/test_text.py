"""The library's files: all parse, lie where their names say, and describe what they declare."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from planarc.catalog.handbook.gather import gather
from planarc.catalog.handbook.pages import ClassPage
from planarc.core.resources import stdlib
from planarc.ir import syntax
from planarc.parse.parser import parse_annotation, parse_file
from planarc.request.request import Request, open_library

ROOT = stdlib()
FILES = sorted(ROOT.rglob("*.pmo"))
NAMES = [path.relative_to(ROOT).as_posix() for path in FILES]

#: Mathematical functions and constants have no unit.
PHYSICAL = [p for p in FILES if "PlanarMultiBody" in p.parts and "Frames" not in p.parts]

#: A model that is run says what its parts are by their names and its documentation.
LIBRARY = [p for p in FILES if "Examples" not in p.parts]

each_file = pytest.mark.parametrize("path", FILES, ids=NAMES)


@cache
def tree(path: Path) -> syntax.StoredDefinition:
    return parse_file(path)


def classes(cls: syntax.ClassDef) -> Iterator[syntax.ClassDef]:
    yield cls
    for element in elements(cls):
        if isinstance(element, syntax.ClassDef):
            yield from classes(element)


def elements(cls: syntax.ClassDef) -> tuple[syntax.Element, ...]:
    return cls.body.elements if isinstance(cls.body, syntax.Composition) else ()


@each_file
def test_a_file_holds_the_class_of_its_name_at_its_place(path: Path) -> None:
    stored = tree(path)
    folder = path.parent.relative_to(ROOT).parts
    is_package = path.stem == "package"
    assert [cls.name for cls in stored.classes] == [folder[-1] if is_package else path.stem]
    assert (stored.within or ()) == (folder[:-1] if is_package else folder)


@each_file
def test_annotations_are_well_formed(path: Path) -> None:
    for cls in classes(tree(path).classes[0]):
        components = (e for e in elements(cls) if isinstance(e, syntax.Component))
        for owner in (cls, *components):
            if owner.annotation is not None:
                parse_annotation(owner.annotation)


@pytest.mark.parametrize("path", LIBRARY, ids=[p.relative_to(ROOT).as_posix() for p in LIBRARY])
def test_classes_and_public_components_are_described(path: Path) -> None:
    undescribed = []
    for cls in classes(tree(path).classes[0]):
        is_short_type = cls.kind is syntax.ClassKind.TYPE and "Units" in path.parts
        if not cls.comment and not is_short_type:
            undescribed.append(cls.name)
        for e in elements(cls):
            if isinstance(e, syntax.Component) and not e.prefixes.protected and not e.comment:
                undescribed.append(f"{cls.name}.{e.name}")
    assert not undescribed


@each_file
def test_switches_are_described_as_truths(path: Path) -> None:
    for cls in classes(tree(path).classes[0]):
        for e in elements(cls):
            if isinstance(e, syntax.Component) and str(e.type) == "Boolean":
                assert e.comment.startswith("= true, if "), e.name


@pytest.mark.parametrize("path", PHYSICAL, ids=[p.stem for p in PHYSICAL])
def test_real_quantities_have_a_unit(path: Path) -> None:
    for cls in classes(tree(path).classes[0]):
        for e in elements(cls):
            if isinstance(e, syntax.Component) and str(e.type) == "Real" and e.name != "color":
                arguments = e.modification.arguments if e.modification else ()
                named = [a.name for a in arguments if isinstance(a, syntax.ElementModification)]
                assert ("unit",) in named, e.name


#: What a user puts into a model, and the functions of frames.
COMPONENTS = [
    p
    for p in LIBRARY
    if "PlanarMultiBody" in p.parts
    and p.stem not in ("package", "Types")
    and "Interfaces" not in p.parts
    and p.stem[0].isupper() | ("Frames" in p.parts)
]
each_component = pytest.mark.parametrize("path", COMPONENTS, ids=[p.stem for p in COMPONENTS])


@each_component
def test_a_component_names_the_tests_that_hold_it(path: Path) -> None:
    """Its head says where it is checked: test files, and folders of tests/cases."""
    head = re.search(r"// Check: (.*(?:\n  // {8}.*)*)", path.read_text(encoding="utf-8"))
    assert head is not None
    tests = Path(__file__).parents[1]
    files = []
    for place in re.findall(r"tests/[\w/]+(?:\.py)?|\b[a-i][0-9]_\w+", head[1]):
        found = tests.parent / place if place.startswith("tests/") else tests / "cases" / place
        assert found.exists(), place
        files += found.glob("*.pmo") if found.is_dir() else [found]
    name = re.compile(rf"\b{path.stem}\b")
    assert any(name.search(file.read_text(encoding="utf-8")) for file in files)


@cache
def handbook() -> dict[str, ClassPage]:
    library, _, _ = open_library(Request())
    return {page.name: page for page in gather(library, library.top_names())}


def in_packages(root: str) -> list[ClassPage]:
    """All classes but types that stand in packages, not in models."""
    pages = handbook()
    inside = {c for p in pages.values() if p.kind.endswith("package") for c in p.children}
    found = [p for p in pages.values() if p.name in inside and p.name.startswith(root)]
    return [p for p in found if p.kind != "type" and not p.name.endswith("Types.Defaults")]


def test_every_class_of_the_libraries_is_documented() -> None:
    pages = in_packages("")
    assert len(pages) > 300
    assert not [p.name for p in pages if "<p>" not in p.info]


def test_components_have_a_picture_a_law_and_an_example_of_their_use() -> None:
    pages = [p for p in in_packages("PlanarMultiBody.") if ".Examples" not in p.name]
    assert len(pages) > 100
    assert not [p.name for p in pages if not p.icon]
    assert not [p.name for p in pages if "<pre>" not in p.info]
    models = [p for p in pages if p.kind == "model"]
    assert len(models) > 60
    assert not [p.name for p in models if dict(p.head).keys().isdisjoint(("Law", "Lies"))]


def test_examples_say_how_long_they_run_and_what_they_show() -> None:
    pages = [p for p in in_packages("PlanarMultiBody.Examples.") if p.kind == "model"]
    assert len(pages) >= 23
    for page in pages:
        for part in ("experiment(StopTime=", "figures={", "<p>"):
            assert part in page.source, f"{page.name} has no {part}"


@pytest.mark.parametrize(
    "folder", sorted({p.parent for p in FILES if p.stem == "package"}), ids=lambda p: p.name
)
def test_package_order_lists_the_folder(folder: Path) -> None:
    listed = (folder / "package.order").read_text(encoding="utf-8").split()
    stored = {p.stem for p in folder.glob("*.pmo") if p.stem != "package"}
    stored |= {p.parent.name for p in folder.glob("*/package.pmo")}
    assert len(listed) == len(set(listed))
    assert set(listed) == stored


@pytest.mark.parametrize("library", ["PlanarMultiBody", "Modelica"])
def test_a_whole_library_checks_with_all_its_units(library: str) -> None:
    from planarc.cli.app import run

    assert run(["check", "--all", library, "--units", "error", "--quiet"]) == 0
