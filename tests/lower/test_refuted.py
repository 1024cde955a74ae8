"""What is wrong in a library's text by the values that it is given."""

from __future__ import annotations

import pytest

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.lower.pipeline import lower
from planarc.parse.parser import parse_annotation, parse_file, parse_text

WHEEL = """model Wheel
  parameter Integer n = 3 annotation(Evaluate = true);
  final parameter Real pitch = 6/n;
  Real x = pitch*time;
equation
  assert(n > 2, "a wheel has fewer than three teeth");
end Wheel;"""
BARE = """model Wheel
  parameter Integer n = 3 annotation(Evaluate = true);
  Real x;
equation
  x = 6*time/n;
end Wheel;"""
INITIAL = """model Wheel
  parameter Integer n = 3 annotation(Evaluate = true);
  Real x;
initial equation
  x = 6*cos(x)/n;
equation
  der(x) = 1;
end Wheel;"""


def told(library: str, own: str) -> Diagnostic:
    made = Library([], parse_file, parse_annotation)
    made.add_file(parse_text(Source("library.mo", library)))
    (name,) = made.add_file(parse_text(Source("t.mo", own)))
    with pytest.raises(PlanarcError) as caught:
        lower(flatten(made, name))
    (found,) = caught.value.diagnostics
    return found


def test_an_assertion_tells_why_there_is_no_value() -> None:
    found = told(WHEEL, "model M Wheel free, locked(n = 0), last; end M;")
    assert found.code == "L303"
    assert "assertion failed in `locked`: a wheel has fewer than three teeth" in found.message
    assert found.span is not None and found.span.source.name == "t.mo"
    assert found.span.text == "0"
    assert [r.span and r.span.source.name for r in found.related] == ["library.mo"] * 2


@pytest.mark.parametrize("library", [BARE, INITIAL], ids=["equation", "initial equation"])
def test_what_no_assertion_tells_is_told_at_the_part(library: str) -> None:
    found = told(library, "model M Wheel free, locked(n = 0), last; end M;")
    assert found.code == "L303"
    assert found.span is not None and found.span.text == "locked(n = 0)"
    assert found.hint == "check the values that `locked` is given"
    assert [r.span and r.span.source.name for r in found.related] == ["library.mo"]


def test_a_parameter_of_one_part_is_told_there() -> None:
    bare = "\n".join(line for line in WHEEL.splitlines() if "assert" not in line)
    found = told(bare, "model M Wheel locked(n = 0); end M;")
    assert found.code == "L303"
    assert found.span is not None and found.span.text == "locked(n = 0)"


def test_what_the_user_wrote_is_told_as_it_is() -> None:
    found = told(WHEEL, "model M Wheel free; constant Real a = 0; Real y = time/a; end M;")
    assert found.code == "L303"
    assert found.span is not None and found.span.text == "time/a"
