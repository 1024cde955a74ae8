"""Formatting changes blank space only, the tree never, and the second time nothing."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planarc.catalog.format.formatter import format_text
from planarc.catalog.format.pieces import cut
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Source
from planarc.parse.parser import parse_text
from tests.ir.text.syntax import definition_text

ROOT = Path(__file__).parents[3]
FOLDERS = [*(ROOT / "stdlib").iterdir(), ROOT / "examples", ROOT / "tests" / "cases"]


def files(folder: Path) -> list[Path]:
    if folder.is_file():
        return [folder]
    return sorted(p for p in folder.rglob("*") if p.suffix in {".pmo", ".mo"})


def tree(text: str) -> str:
    """The tree as text; the blank space in annotations, which it keeps, is left out."""
    shown = definition_text(parse_text(Source("m.pmo", text.replace("\r\n", "\n"))))
    return re.sub(r"\s+", "", shown)


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda p: p.name)
def test_our_files_keep_their_tree_and_their_lines(folder: Path) -> None:
    assert files(folder)
    for path in files(folder):
        text = path.read_text("utf-8")
        formatted = format_text(text)
        assert format_text(formatted) == formatted, path
        assert tree(formatted) == tree(text), path
        words = [line.split() for line in text.splitlines() if line.strip()]
        kept = [line.split() for line in formatted.splitlines() if line.strip()]
        assert ["".join(w) for w in kept] == ["".join(w) for w in words], path


def test_the_examples_are_formatted() -> None:
    for path in files(ROOT / "examples"):
        assert format_text(path.read_text("utf-8")) == path.read_text("utf-8"), path


TEXTS = [p.read_text("utf-8") for folder in FOLDERS for p in files(folder)][::7]


@settings(max_examples=60)
@given(st.sampled_from(TEXTS), st.data())
def test_disturbed_blank_space_is_put_right(text: str, data: st.DataObject) -> None:
    """Whatever blanks stand between the pieces of a line, the tree and the fixed point hold."""
    blanks = st.sampled_from(["", " ", "  ", "\t", " \t "])
    disturbed = []
    for before, piece in zip([None, *cut(text)], cut(text), strict=False):
        touching = before is None or (before.text[-1:].isalnum() and piece.text[:1].isalnum())
        if piece.lines_before or before is None or touching or before.comment or piece.comment:
            disturbed.append(piece.blank + piece.text)
        else:
            blank = data.draw(blanks) if piece.blank else ""
            disturbed.append((blank or (" " if piece.blank else "")) + piece.text)
    changed = "".join(disturbed)
    formatted = format_text(changed)
    assert format_text(formatted) == formatted
    assert tree(formatted) == tree(text)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("x = - 1;", "x = -1;"),
        ("x =a+ b;", "x = a + b;"),
        ("x = a*b;", "x = a*b;"),
        ("f (x , y);", "f(x, y);"),
        ("x = if(a) then(b) else - c;", "x = if (a) then (b) else -c;"),
        ("connect (a . b , c [ 1 ]);", "connect(a.b, c[1]);"),
        ("x = y[end -1];", "x = y[end - 1];"),
        ("x = a<b  and not c;", "x = a < b and not c;"),
        ("x = [1,2;3 , 4];", "x = [1,2; 3, 4];"),
        ("x = {i for i in 1 : n};", "x = {i for i in 1 : n};"),
        ("x = 2 * ( - y );", "x = 2 * (-y);"),
        ("x = a.^ b;", "x = a .^ b;"),
        ("x = 1;// why", "x = 1; // why"),
        ("x = 1;    // why  ", "x = 1;    // why"),
        ("x = \"a  b\" ;", "x = \"a  b\";"),
    ],
)  # fmt: skip
def test_spaces_in_an_equation(before: str, after: str) -> None:
    formatted = format_text(f"model M\nequation\n{before}\nend M;\n")
    assert formatted == f"model M\nequation\n  {after}\nend M;\n"


def test_the_shape_of_a_class() -> None:
    ragged = """
  within A;
model  M "text
  that goes on"


  extends  .B.C ( x ( start = 1 ) );
        Real x=  1 "one"
annotation(Dialog(tab = "a",
group="b"));
protected
    function f = g(
a = 1);
  record R
 Real y;
   end R;
    /* kept
        as it is */
initial equation
if initial() then
x=1;
elseif a
or b then
   // why
   for i in 1:3 loop
     y = if a then
     1
     else if b then 2 else 3;
     end for;
    else
   end if;
annotation(
Icon(graphics={
Line(points={{0,0},{1, 1}})
}));
end M;
"""
    assert format_text(ragged) == (
        """within A;
model M "text
  that goes on"

  extends .B.C(x(start=1));
  Real x = 1 "one"
    annotation(Dialog(tab="a",
      group="b"));
protected
  function f = g(
    a=1);
  record R
    Real y;
  end R;
  /* kept
        as it is */
initial equation
  if initial() then
    x = 1;
  elseif a
      or b then
    // why
    for i in 1:3 loop
      y = if a then
          1
        else if b then 2 else 3;
    end for;
  else
  end if;
  annotation(
    Icon(graphics={
      Line(points={{0,0},{1, 1}})
  }));
end M;
"""
    )


def test_ends_of_lines_stay_as_they_are() -> None:
    text = 'model M "a\r\nb"\r\nReal x;\r\nend M;\r\n'
    assert format_text(text) == 'model M "a\r\nb"\r\n  Real x;\r\nend M;\r\n'
    assert format_text("\ufeffmodel M end M;") == "\ufeffmodel M end M;\n"


@settings(max_examples=200)
@given(st.text(alphabet=" \n\t(){}[];,.=+-*/<>:\"'ax1\\modelendif"))
def test_no_text_stops_the_formatter(text: str) -> None:
    """Where it is no Modelica, nothing is lost or it is refused."""
    try:
        formatted = format_text(text)
    except PlanarcError as refusal:
        assert refusal.diagnostics[0].code == "X002"
    else:
        assert [p.text for p in cut(formatted)] == [p.text for p in cut(text)]
