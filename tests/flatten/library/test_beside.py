"""A package whose folder lies where the file does is named, though no library holds it."""

from __future__ import annotations

from pathlib import Path

import pytest

import planarc


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "Machines").mkdir()
    (tmp_path / "Machines" / "package.pmo").write_text("package Machines end Machines;")
    return tmp_path


def hint_of(file: Path) -> str:
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(file)
    return str(caught.value.diagnostics[0].hint)


def test_a_file_that_names_another_package_than_its_own(place: Path) -> None:
    crank = place / "Machines" / "Crank.pmo"
    crank.write_text("within Machine;\nmodel Crank\n  Real x = 1;\nend Crank;\n")
    assert hint_of(crank) == "write `within Machines;`"


def test_a_file_in_no_package(place: Path) -> None:
    crank = place / "Crank.pmo"
    crank.write_text("within Machine;\nmodel Crank\n  Real x = 1;\nend Crank;\n")
    assert hint_of(crank).startswith("remove `within`")


def test_a_package_beside_the_file_that_uses_it(place: Path) -> None:
    use = place / "use.pmo"
    use.write_text("model Use\n  Machines.Crank crank;\nend Use;\n")
    assert hint_of(use) == (
        f"the package `Machines` stands beside this file: give `--library {place}`"
    )
