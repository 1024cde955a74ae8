"""Quick fixes: each makes the message go away."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.core.diagnostic import Diagnostic
from planarc.editor.check import all_of, check_text
from planarc.editor.fixes import Fix, fixes_of
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text, Texts

NEAREST = """model M
  PlanarMultiBody.Joints.Revolute r(phi(start=1));
  Rael x;
equation
  x = r.phj;
end M;
"""


def checked(content: str) -> tuple[Text, tuple[Diagnostic, ...]]:
    texts = Texts()
    text = texts.put(Path("untitled:1"), content)
    return text, all_of(text, list(check_text(Shelf(texts), text, lambda: True)))


def fixed(text: Text, fix: Fix) -> str:
    content = text.source.text
    for edit in sorted(fix.edits, key=lambda e: -e.span.start):
        content = content[: edit.span.start] + edit.text + content[edit.span.end :]
    return content


@pytest.mark.parametrize(
    ("code", "wrong", "right"),
    [
        ("P101", "model M\n  Real x\n  Real y=1;\n  Real z=x;\nend M;\n", "  Real x;\n"),
        ("F210", "model M\n  Rael x=1;\nend M;\n", "  Real x=1;"),
        ("F224", "model L\n  parameter Real m=1;\nend L;\nmodel M\n  L l[3](m=2);\nend M;\n",
         "l[3](each m=2)"),
        ("P111", "model M\n  Real x;\nequation\n  x := 1;\nend M;\n", "x = 1"),
        ("P102", "model M\n  Real x=1;\nend N;\n", "end M;"),
        ("F262", "model M\n  PlanarMultiBody.Parts.Fixed f;\nend M;\n",
         "  inner PlanarMultiBody.World world;\n  Planar"),
        ("P101", "model M\n  Real x=3**2;\nend M;\n", "x=3^2;"),
        ("P101", "model M\n  Real x=0,5*2;\nend M;\n", "x=0.5*2;"),
        ("P101", "model M 'a text'\n  Real x=1;\nend M;\n", 'M "a text"\n'),
        ("P101", "model M\n  Real x;\nequation\n  if time > 1:\n    x = 1;\n  else\n    x = 2;\n"
         "  end if;\nend M;\n", "if time > 1 then\n"),
        ("P102", "model M\n  Real x;\nequation\n  if time > 1 then\n    x = 1;\n  else\n"
         "    x = 2;\n  end;\nend M;\n", "  end if;"),
        ("P103", "model M\n  Real x[2]={1, 2;\nend M;\n", "{1, 2};"),
        ("P104", "model M\n  Real x=2×3;\nend M;\n", "x=2*3;"),
        ("P104", "model M\n  Boolean b=true && false;\nend M;\n", "true and false"),
        ("F210", "model M\n  import PlanarMultiBody.Parts.Bodi;\n  Body b;\nend M;\n",
         "import PlanarMultiBody.Parts.Body;"),
        ("F226", "model M\n  Real x=1;\n  annotation(experiment(Stoptime=2));\nend M;\n",
         "experiment(StopTime=2)"),
        ("F290", "model M\n  Real x=atan(1, 2);\nend M;\n", "atan2(1, 2)"),
    ],
)  # fmt: skip
def test_the_first_fix_makes_the_message_go_away(code: str, wrong: str, right: str) -> None:
    text, found = checked(wrong)
    (diagnostic,) = [d for d in found if d.code == code]
    new = fixed(text, next(fixes_of(text, diagnostic)))
    assert right in new
    again = checked(new)[1]
    assert all((d.code, d.message) != (code, diagnostic.message) for d in again)


def test_a_member_that_is_nearly_right() -> None:
    text, found = checked(NEAREST.replace("Rael", "Real"))
    (diagnostic,) = [d for d in found if d.code == "F213"]
    assert "x = r.phi;" in fixed(text, next(fixes_of(text, diagnostic)))


def test_a_world_without_inner() -> None:
    content = "model M\n  PlanarMultiBody.World world;\n  PlanarMultiBody.Parts.Fixed f;\nend M;\n"
    text, found = checked(content)
    fixes = [fix for d in found for fix in fixes_of(text, d)]
    assert any("  inner PlanarMultiBody.World world;" in fixed(text, f) for f in fixes)
