"""The rendered form of diagnostics: marks stand under what they mean, nothing escapes."""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.render import WIDTH, in_order, render, render_all, to_json
from planarc.core.source import NOWHERE, Source, Span


def spanning(text: str, part: str, name: str = "a.pmo") -> Span:
    start = text.index(part)
    return Span(Source(name, text), start, start + len(part))


def test_place_line_mark_and_hint() -> None:
    text = "model A\n  Parts.Bodi rod;\nend A;\n"
    diagnostic = Diagnostic(
        "F201", "there is no class `Bodi`", spanning(text, "Bodi"), hint="write `Body`"
    )
    assert render(diagnostic) == (
        "error[F201]: there is no class `Bodi`\n"
        "  --> a.pmo:2:9\n"
        "   |\n"
        " 2 |   Parts.Bodi rod;\n"
        "   |         ^^^^\n"
        "  hint: write `Body`\n"
    )


def test_a_second_place_is_shown_with_what_it_means() -> None:
    text = "Real x(start=1);\nReal y(start=2);\n"
    first, second = spanning(text, "start=1"), spanning(text, "start=2")
    diagnostic = Diagnostic("S101", "m", first, related=(Related("the other one", second),))
    assert "  note: the other one\n  --> a.pmo:2:8\n" in render(diagnostic)


def test_the_mark_stands_under_tabs_and_wide_characters() -> None:
    text = '\t"\N{CJK UNIFIED IDEOGRAPH-65E5}" x'
    lines = render(Diagnostic("P1", "m", spanning(text, "x"))).splitlines()
    assert lines[-1] == "   | " + " " * 6 + "^"  # tab 1, quotes 2, wide character 2, blank 1


def test_a_span_of_several_lines_is_marked_to_the_end_of_the_first() -> None:
    text = "a = b +\n  c;"
    lines = render(Diagnostic("P1", "m", Span(Source("a", text), 4, 12))).splitlines()
    assert lines[-1] == "   |     ^^^"


def test_a_mark_at_the_end_of_the_text() -> None:
    lines = render(Diagnostic("P1", "m", Span(Source("a", "ab"), 2, 2))).splitlines()
    assert lines[-2:] == [" 1 | ab", "   |   ^"]


def test_a_long_line_is_cut_around_the_mark() -> None:
    text = "x" * 5000 + "HERE" + "y" * 5000
    lines = render(Diagnostic("P1", "m", spanning(text, "HERE"))).splitlines()
    assert len(lines[-2]) < WIDTH + 20
    start = lines[-1].index("^")
    assert lines[-2][start : start + 4] == "HERE"
    assert lines[-1].count("^") == 4


def test_control_characters_of_the_user_do_not_reach_the_terminal() -> None:
    text = "Real \x1b[31m\u202ex;"
    shown = render(Diagnostic("P1", "bad \x1b]0;t\x07", spanning(text, "x"), hint="\x9b1m"))
    assert not any(c in shown for c in "\x1b\x07\x9b\u202e")


def test_without_a_place_there_is_no_excerpt() -> None:
    assert render(Diagnostic("C1", "no such file")) == "error[C1]: no such file\n"
    assert render(Diagnostic("C1", "m", NOWHERE)) == "error[C1]: m\n"


def test_colour_is_only_there_when_asked_for() -> None:
    both = (Diagnostic("A1", "a"), Diagnostic("B1", "b", severity=Severity.WARNING))
    assert render_all(both) == "error[A1]: a\n\nwarning[B1]: b\n"
    assert "\x1b" in render_all(both, color=True)


def test_diagnostics_come_in_the_order_of_their_places_and_once() -> None:
    text = "Real x;\nReal y;\n"
    late = Diagnostic("F2", "late", spanning(text, "y"))
    early = Diagnostic("F1", "early", Span(late.span.source, 5, 6) if late.span else None)
    assert in_order((late, early, late)) == (early, late)


def test_json_holds_the_place_or_null() -> None:
    placed = to_json(Diagnostic("P1", "m", spanning("\n  x", "x"), hint="h"))
    assert placed == {
        "code": "P1",
        "severity": "error",
        "message": "m",
        "file": "a.pmo",
        "line": 2,
        "column": 3,
        "hint": "h",
    }
    assert to_json(Diagnostic("C1", "m"))["line"] is None
