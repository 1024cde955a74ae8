"""Whatever the text: a tree or diagnostics with places, soon."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planarc.core.diagnostic import PlanarcError
from planarc.core.render import render_all
from planarc.core.source import Source, decode
from planarc.parse.build.expressions import MAX_OPERATORS
from planarc.parse.parser import parse_expression, parse_file, parse_text

MODEL = """within A.B;
model M "text" // comment
  extends P(final x = 1, redeclare model Q = R(y = 2));
  parameter Real a[3](each start = 1e-3) = {1, 2, 3} if n > 0 "d" annotation(Dialog(x = "("));
protected
  replaceable function f = g constrainedby h;
  type E = enumeration(u "first", v);
initial equation
  a[end] = if b then 1 elseif c then 2 else 3;
equation
  connect(a.b[1], c); /* comment */
  when {sample(0, 1), x > 1} then y = pre(y) + 1; elsewhen z then reinit(w, -2); end when;
  for i in 1:3, j loop der(a[i]) = sum(b[k]^2 for k in 1:n)*not_; end for;
algorithm
  (p, , q) := f(x, y = function g(z = 1));
  while p or not q and r <= s loop break; end while;
  annotation(Icon());
end M;
"""
SIGNS = ["'", '"', "/*", "*/", "end", "(", ")", "[", "]", ";", ":=", "=", "\\", "é"]
WORDS = [*MODEL.split(), *SIGNS]

Steps: TypeAlias = "Callable[[Callable[[], object]], int]"
#: Calls of functions that a text may take, and those for each of its letters.
MOST, PER_LETTER = 1_000_000, 200


def outcome(text: str) -> tuple[str, ...]:
    """The codes of the errors; any other exception than `PlanarcError` fails the test."""
    source = Source("test.pmo", text)
    try:
        tree = parse_text(source)
    except PlanarcError as error:
        assert error.diagnostics
        for diagnostic in error.diagnostics:
            assert diagnostic.code.startswith("P1")
            assert diagnostic.span is not None
            assert 0 <= diagnostic.span.start <= len(text)
        assert "Traceback" not in render_all(error.diagnostics)
        return tuple(d.code for d in error.diagnostics)
    assert tree.span == (source, 0, len(text))
    return ()


def test_the_model_of_these_tests_is_right() -> None:
    assert outcome(MODEL) == ()


@settings(max_examples=150)
@given(st.integers(0, len(MODEL)), st.integers(0, 30), st.sampled_from(["", *WORDS]))
def test_a_piece_replaced(at: int, length: int, piece: str) -> None:
    outcome(MODEL[:at] + piece + MODEL[at + length :])


@settings(max_examples=150)
@given(st.lists(st.sampled_from(WORDS), max_size=60))
def test_words_in_any_order(words: list[str]) -> None:
    outcome(" ".join(words))


@settings(max_examples=150)
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    outcome(text)


@settings(max_examples=60)
@given(st.binary(max_size=400))
def test_any_bytes(data: bytes) -> None:
    outcome(decode(data))


@pytest.mark.parametrize(
    ("value", "codes"),
    [
        ("(" * 10000 + "1" + ")" * 10000, {"P106"}),
        ("{" * 10000, {"P106"}),
        ("f(" * 10000 + ")" * 10000, {"P106"}),
        ("if a then b else " * 5000 + "c", {"P106"}),
        (")" * 10000, {"P101", "P103"}),
        ("a" * 1_000_000, {"P106"}),
        ("1" * 1_000_000, {"P108"}),
        ("1e" + "9" * 1_000_000, {"P108"}),
        ("a" + "+a" * 20000, {"P106"}),
        ("a" + ".a" * 20000 + " b", {"P101"}),
        ('"' + "x\\" * 100_000, {"P103"}),
        ("'" * 10001, {"P103", "P101"}),
        ("/*" * 100_000, {"P103"}),
        ("!" * 100_000, {"P104", "P101"}),
        ("é ! " * 20_000, {"P104", "P101"}),
        ("1\0", {"P100"}),
        ("1; y = " * 20_000 + "= 2", {"P101"}),
    ],
    ids=range(17),
)
def test_sizes_are_bounded(value: str, codes: set[str], steps_of: Steps) -> None:
    text = f"model M equation x = {value}; end M;"
    found: list[str] = []
    assert steps_of(lambda: found.extend(outcome(text))) < MOST + PER_LETTER * len(text)
    assert found
    assert set(found) <= codes


@pytest.mark.parametrize(
    "text",
    [
        "model M equation " + "for i in 1:2 loop " * 3000 + "end for;" * 3000 + " end M;",
        "model M " * 3000 + "end M;" * 3000,
        "model M annotation(" + "(" * 100_000,
        "model M Real x" + "(y" * 5000 + ")" * 5000 + "; end M;",
        "model M " + ";" * 10000 + " end M;",
        "end " * 20000,
        ";" * 10000,
        "model M equation " + "x = ; " * 3000 + "end M;",
        " ".join(random.Random(1).choices(WORDS, k=20000)),
    ],
    ids=range(9),
)
def test_broken_files_are_bounded(text: str, steps_of: Steps) -> None:
    found: list[str] = []
    assert steps_of(lambda: found.extend(outcome(text))) < MOST + PER_LETTER * len(text)
    assert 0 < len(found) <= 50


def test_an_annotation_is_skipped_however_deep() -> None:
    assert outcome(f"model M annotation({'(' * 20000}{')' * 20000}); end M;") == ()


def test_a_long_chain_of_operators_up_to_its_bound() -> None:
    parse_expression("a" + " + a" * (MAX_OPERATORS - 1))
    with pytest.raises(PlanarcError, match="operators in a row"):
        parse_expression("a" + " + a" * (MAX_OPERATORS + 1))


@pytest.mark.parametrize(
    "data",
    [
        "model M \"größe\" Real 'größe'; end M;".encode(),
        "\ufeffmodel M \"größe\" Real 'größe'; end M;".encode(),
        "model M \"größe\" Real 'größe'; end M;".encode("latin-1"),
        "model M \"größe\"\r\n  Real 'größe'; end M;\r\n".encode(),
        "model M \"größe\"\r\f\tReal 'größe'; end M;".encode(),
    ],
)
def test_encodings(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "M.mo"
    path.write_bytes(data)
    (model,) = parse_file(path).classes
    assert model.comment == "größe"


def test_an_empty_text_holds_no_class() -> None:
    assert parse_text(Source("a", "")).classes == ()
    assert parse_text(Source("a", "// nothing\n/* here */ ")).classes == ()
