"""Discrete variables that are no number, or too large: told where they are given their values."""

from __future__ import annotations

import pytest

import planarc


@pytest.mark.parametrize(
    ("body", "code", "place"),
    [
        ("Integer x = div(1, n);", "R421", "div(1, n)"),
        ("Integer y = x + 1; Integer x = mod(3, n);", "R421", "mod(3, n)"),
        ("Integer x = rem(3, n);", "R421", "rem(3, n)"),
        ("Integer x = integer(1/n);", "R421", "integer(1/n)"),
        ("Integer x = div(3, integer(time));", "R421", "div(3, integer(time))"),
        ("parameter Integer m = integer((n + 3000000)^3);", "R439", "integer((n + 3000000)^3)"),
        ("Integer x = integer((n + 3000000)^3);", "R439", "integer((n + 3000000)^3)"),
    ],
)
def test_what_has_no_finite_value_is_told_at_its_line(body: str, code: str, place: str) -> None:
    model = planarc.load(f"model M parameter Integer n = 0; {body} end M;")
    with pytest.raises(planarc.PlanarcError) as refused:
        model.simulate(1.0)
    (told,) = refused.value.diagnostics
    assert told.code == code
    assert told.span is not None
    assert place in told.span.text


def test_an_integer_that_grows_at_events_is_told_at_its_equation() -> None:
    model = planarc.load("""
    model M
      Integer n(start = 1, fixed = true);
    equation
      when sample(0.1, 0.1) then n = 1000*pre(n) + 1; end when;
    end M;
    """)
    with pytest.raises(planarc.PlanarcError, match="R439") as refused:
        model.simulate(1.0)
    span = refused.value.diagnostics[0].span
    assert span is not None
    assert span.text == "n = 1000*pre(n) + 1"
