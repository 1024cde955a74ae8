"""Entries of arrays in functions that are read before they have a value."""

from __future__ import annotations

import pytest

import planarc

HEAD = "function f input Real x[2]; output Real y; protected Real z[2]; Real m[2, 2]; algorithm"


def warnings_of(body: str) -> list[str]:
    model = planarc.load(f"model M {HEAD} {body} end f; Real y = f({{time, 1}}); end M;")
    return [w.message for w in model.warnings if w.code == "L301"]


@pytest.mark.parametrize(
    ("body", "entry"),
    [
        ("z[1] := x[1]; y := sum(z);", "z[2]"),
        ("z[1] := x[1]; y := z[2];", "z[2]"),
        ("z[2] := z[1] + x[1]; y := z[2];", "z[1]"),
        ("y := z*x; z := x;", "z[1]"),
        ("m[1] := x; y := m[2, 1];", "m[2, 1]"),
        ("m[:, 1] := x; y := sum(m[2, :]);", "m[2, 2]"),
        ("if x[1] > 1 then z[1] := 1; end if; y := z[1] + z[2];", "z[2]"),
        ("for i in 1:2 loop y := z[1]; end for; z := x;", "z[1]"),
        ("while z[1] < 1 loop z[1] := 2; end while; y := x[1]*z[1];", "z[1]"),
    ],
)
def test_an_entry_without_a_value_is_told_where_it_is_read(body: str, entry: str) -> None:
    assert warnings_of(body) == [f"`{entry}` is used before it has a value: it is 0"]


@pytest.mark.parametrize(
    "body",
    [
        "z := x; y := sum(z);",
        "z[1] := x[1]; z[2] := z[1]; y := sum(z);",
        "z[1] := x[1]; y := z[1] + size(z, 1);",
        "for i in 1:size(z, 1) loop z[i] := x[i]; end for; y := sum(z);",
        "for i in 1:2 loop if i > 1 then y := z[1]; else z[1] := x[1]; end if; end for;",
        "if x[1] > 1 then z[1] := 1; end if; y := z[1];",
        "m[1, :] := x; m[2] := x; y := sum(m);",
        "y := sum(z + 1 for z in x); z := x;",
        "z[integer(x[1])] := 1; y := sum(z);",
    ],
)
def test_an_entry_that_may_have_one_is_not(body: str) -> None:
    assert warnings_of(body) == []
