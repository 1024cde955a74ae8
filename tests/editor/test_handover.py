"""What a check hands on to a live page is what the request would be compiled to."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.compiler import compile_model
from planarc.core.clock import Clock
from planarc.core.options import Backend
from planarc.editor.handover import draft_of, model_of
from planarc.editor.runs import request_of
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Texts
from planarc.probe.check import judge, look_at
from planarc.request.request import open_target

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.pmo"))
LED = """
model Led "Leads from x = 1 to x = 2"
  Real x(start=0);
equation
  homotopy(actual=x^2 - 4, simplified=x - 1) = 0;
  assert(x < 3, "too far", AssertionLevel.warning);
end Led;
"""


@pytest.mark.parametrize("text", [*EXAMPLES, LED], ids=lambda t: getattr(t, "stem", "led"))
def test_a_page_gets_what_compiling_gives(text: Path | str) -> None:
    texts = Texts()
    path = text if isinstance(text, Path) else Path("untitled:led.pmo")
    shown = texts.put(path, text.read_text("utf-8") if isinstance(text, Path) else text)
    request = request_of(Shelf(texts), shown, None)
    seen = look_at(open_target(request), Clock())
    draft = draft_of(seen, Backend.NUMPY, Clock())
    judge(seen, Clock())  # it goes on with the same expressions
    made = model_of(draft, request, Backend.NUMPY, Clock())
    direct = compile_model(request, Backend.NUMPY)
    handed = made.compiled()
    assert handed.code == direct.code
    assert handed.warnings == direct.warnings
    assert (handed.lead is None) == (direct.lead is None)
    assert made.program.mechanism == direct.program.mechanism
    assert made.program.figures == direct.program.figures
    assert made.program.columns == direct.program.columns
