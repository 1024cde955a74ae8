"""Syntax errors as the user sees them: each file shows the text and what is reported.

A new case is a text in `tests/golden/parse/`; `--update-golden` writes the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.render import render_all
from planarc.core.source import Source
from planarc.parse.parser import parse_annotation, parse_file, parse_text

CASES = sorted((Path(__file__).parents[2] / "golden" / "parse").glob("*.txt"))
REPORTED = "======== reported ========\n"

Errors = Callable[[str], tuple[Diagnostic, ...]]


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_messages(path: Path, golden: Callable[[str, str], None]) -> None:
    text = path.read_text(encoding="utf-8").split(REPORTED)[0]
    with pytest.raises(PlanarcError) as caught:
        parse_text(Source("test.pmo", text))
    reported = render_all(caught.value.diagnostics)
    golden(f"parse/{path.name}", f"{text}{REPORTED}{reported}")


def test_every_error_has_a_place_and_they_come_in_order(errors_of: Errors) -> None:
    found = errors_of("model M\n Real x\n Real 1;\n f(a=1, 2) y;\nequation\n x = ;\nend N;")
    starts = [e.span.start for e in found if e.span]
    assert len(starts) == len(found) > 2
    assert starts == sorted(starts)


def test_errors_far_from_each_other_are_all_reported(errors_of: Errors) -> None:
    good = "  x = y + 1;\n" * 30
    text = f"model M\nequation\n{good}  a = ;\n{good}  b := 1;\n{good}  c = 2\n{good}end M;\n"
    assert [e.span.line for e in errors_of(text) if e.span] == [33, 64, 95]


def test_one_mistake_gives_one_error() -> None:
    """Every word of a model left out or doubled in turn gives one message, with few exceptions."""
    text = """
        model M parameter Real a ( start = 1 ) = 2 "d" ; Real b [ 3 ] ; equation
        a = f ( b [ 1 ] , 2 ) * { 1 , 2 } ; connect ( a . b , c ) ;
        if a > 1 then b = 1 ; elseif c then b = 2 ; else b = 3 ; end if ;
        for i in 1 : 3 loop b [ i ] = a ; end for ; when c then a = 1 ; end when ;
        algorithm a := b ; while c loop a := 1 ; end while ; end M ;"""
    words = text.split()
    several = []
    for index, word in enumerate(words):
        for changed in ([], [word, word]):
            try:
                mutant = " ".join([*words[:index], *changed, *words[index + 1 :]])
                parse_text(Source("test.pmo", mutant))
            except PlanarcError as error:
                if len(error.diagnostics) > 1:
                    several.append((mutant, error.diagnostics))
    assert len(several) <= 3, several


def test_errors_of_an_annotation_point_into_the_file() -> None:
    text = "model M\n  annotation(Icon(a = 1,\n    b = ));\nend M;\n"
    annotation = parse_text(Source("test.pmo", text)).classes[0].annotation
    assert annotation is not None
    with pytest.raises(PlanarcError) as caught:
        parse_annotation(annotation)
    (error,) = caught.value.diagnostics
    assert error.span is not None
    assert (error.span.line, error.span.column) == (3, 9)


def test_errors_name_the_file_they_were_asked_under(tmp_path: Path) -> None:
    path = tmp_path / "a.pmo"
    path.write_text("model", encoding="utf-8")
    with pytest.raises(PlanarcError) as caught:
        parse_file(path, "shown.pmo")
    assert "--> shown.pmo:1:6" in render_all(caught.value.diagnostics)
