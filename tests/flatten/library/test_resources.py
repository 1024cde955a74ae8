"""Files that libraries bring along, named by URIs."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir import flat
from planarc.parse.parser import parse_annotation, parse_file, parse_text

MODEL = """\
function load
  input String uri;
  output String path;
external "builtin" path = planarc_loadResource(uri);
end load;
model M
  parameter String file = load("{}");
end M;
"""


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A library with a package that is a folder and one that stands in a file."""
    inner = tmp_path / "lib" / "Lib 1.2" / "Inner"
    inner.mkdir(parents=True)
    (inner.parent / "package.mo").write_text("package Lib\n package Text end Text;\nend Lib;\n")
    (inner / "package.mo").write_text("within Lib;\npackage Inner end Inner;\n")
    for folder in (inner, inner.parent):
        (folder / "Resources").mkdir()
        (folder / "Resources" / "some data.txt").write_text("1")
    (tmp_path / "lib" / "Single.mo").write_text("package Single end Single;\n")
    (tmp_path / "lib" / "beside.txt").write_text("1")
    return tmp_path / "lib"


def path_of(uri: str, root: Path) -> str:
    library = Library([root, stdlib()], parse_file, parse_annotation)
    library.add_file(parse_text(Source("m.mo", MODEL.replace("{}", uri))))
    binding = flatten(library, "M").variables[0].binding
    assert isinstance(binding, flat.Literal)
    return str(binding.value)


@pytest.mark.parametrize(
    ("uri", "wanted"),
    [
        ("modelica://Lib/Resources/some data.txt", "Lib 1.2/Resources/some data.txt"),
        ("modelica://Lib/Resources/some%20data.txt", "Lib 1.2/Resources/some data.txt"),
        ("modelica:/Lib/Resources/some data.txt", "Lib 1.2/Resources/some data.txt"),
        ("Modelica://Lib.Inner/Resources/some data.txt", "Lib 1.2/Inner/Resources/some data.txt"),
        ("modelica://Lib.Text/Resources/some data.txt", "Lib 1.2/Resources/some data.txt"),
        ("modelica://Single/beside.txt", "beside.txt"),
        ("modelica://Lib", "Lib 1.2"),
    ],
)
def test_a_uri_is_a_file_of_the_library(uri: str, wanted: str, root: Path) -> None:
    assert path_of(uri, root) == (root / wanted).as_posix()


def test_other_names_are_files_of_the_machine(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(root)
    assert path_of("beside.txt", root) == (root / "beside.txt").as_posix()
    assert path_of("file:///data/a%20b.txt", root).endswith("/data/a b.txt")


def test_a_file_that_is_not_there_is_told_with_the_nearest_name(root: Path) -> None:
    with pytest.raises(PlanarcError) as caught:
        path_of("modelica://Lib/Resources/some date.txt", root)
    (found,) = caught.value.diagnostics
    assert found.code == "F278"
    assert found.hint == "did you mean `some data.txt`?"
    assert found.span is not None and found.span.text == (
        'load("modelica://Lib/Resources/some date.txt")'
    )


def test_a_library_that_is_not_there_is_told(root: Path) -> None:
    with pytest.raises(PlanarcError) as caught:
        path_of("modelica://Nowhere/a.txt", root)
    assert caught.value.diagnostics[0].code == "F278"
    assert "names no package" in caught.value.diagnostics[0].message
