"""String variables: held between events, chosen, compared and shown, alike in both back ends."""

from __future__ import annotations

import subprocess
import sys

import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.ir import store
from planarc.ir.expr import Exprs
from planarc.request.request import Request
from planarc.runtime.texts import number_of, text_of


def _told(text: str, backend: Backend, stop: float = 2.0) -> list[str]:
    """The messages of a run's warnings."""
    options = RunOptions(stop=stop, intervals=20, backend=backend)
    result = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    assert result.ended is None, result.ended
    return [w.message.split(": ", 1)[1].split(" (")[0] for w in result.warnings]


@pytest.mark.parametrize("backend", list(Backend))
@pytest.mark.parametrize(
    ("declared", "equations", "shown", "expected"),
    [
        ('String s = "a" + "b";', "", "s", "ab"),
        ("String s;", 's = if time > 1 then "late" else "early";', "s", "late"),
        ("String s[2];", 'for i in 1:2 loop s[i] = "n" + String(i); end for;', "s[2]", "n2"),
        (
            'String s(start = "none", fixed = true); Integer n(start = 0, fixed = true);',
            "when sample(0.5, 0.5) then n = pre(n) + 1; s = String(n, minimumLength = 3,"
            " leftJustified = false) + pre(s); end when;",
            "s",
            "  3  2  1none",
        ),
        (
            "String s;",
            'algorithm s := "quiet"; if time > 1 then s := "very " + s; end if; equation',
            "s",
            "very quiet",
        ),
        ("Boolean b = time > 1;", "", "String(b)", "true"),
        (
            "type E = enumeration(low, high); E e = if time > 1 then E.high else E.low;",
            "",
            "String(e, minimumLength = 6) + String(E.low)",
            "high  low",
        ),
        ("Integer n = 1234567;", "", "String(n)", "1234567"),
        ("parameter Real x = 2.0/3;", "", "String(x, significantDigits = 3)", "0.667"),
        ("", "", 'String(2.0/3, format = "6.2f")', "  0.67"),
        (
            "record R Real x; String name; end R; R r[2];",
            'r.x = {1, 2}; r.name = {"one", "two"};',
            "r[2].name",
            "two",
        ),
        (
            "function word input Boolean yes; output String s;"
            ' algorithm if yes then s := "yes"; else s := "no"; end if; end word;',
            "",
            "word(time > 1)",
            "yes",
        ),
    ],
)
def test_texts_are_shown_as_they_are_at_the_time(
    backend: Backend, declared: str, equations: str, shown: str, expected: str
) -> None:
    text = f"""model M
      {declared}
      Boolean end_(start = false, fixed = true) = time > 1.75;
    equation
      {equations}
      assert(not end_, {shown}, AssertionLevel.warning);
    end M;"""
    assert _told(text, backend) == [expected]


@pytest.mark.parametrize("backend", list(Backend))
def test_equal_texts_are_equal_however_they_were_made(backend: Backend) -> None:
    options = RunOptions(stop=2, intervals=20, backend=backend)
    text = """model M
      String s(start = "", fixed = true);
      Integer n(start = 0, fixed = true);
      Integer changes(start = 0, fixed = true);
      Boolean third = s == "turn 3";
      Boolean none = s == "";
    equation
      when sample(0.5, 0.5) then
        n = pre(n) + 1;
        s = "turn " + String(if n > 3 then 3 else n);
      end when;
      when change(s) then
        changes = pre(changes) + 1;
      end when;
    end M;"""
    result = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    assert result["third"][result.time > 1.5].all() and not result["third"][result.time < 1.5].any()
    assert result["none"][0] == 1 and not result["none"][-1]
    assert result["changes"][-1] == 3  # the fourth turn's text is that of the third
    assert "s" not in result


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("L343", 's = "at " + String(time);'),
        ("L305", 's = if time > 1 then "a" else "b"; b = s < "b";'),
    ],
)
def test_what_no_variable_can_hold_is_refused(code: str, text: str) -> None:
    model = f"model M String s; Boolean b = true; equation {text} end M;"
    if code == "L305":
        model = model.replace("b = true", "b")
    with pytest.raises(PlanarcError) as problem:
        compiler.compile_model(Request(text=model), Backend.NUMPY)
    assert problem.value.diagnostics[0].code == code


def test_another_process_reads_texts_from_what_was_stored(tmp_path: object) -> None:
    table = Exprs()
    kept = store.dumps((table.text("kept"), table), table)
    script = (
        "import sys; from planarc.ir import store; from planarc.runtime.texts import text_of\n"
        "e, table = store.loads(sys.stdin.buffer.read()); print(text_of(e.data), end='')"
    )
    read = subprocess.run([sys.executable, "-c", script], input=kept, capture_output=True)
    assert read.stdout == b"kept", read.stderr


def test_a_number_stands_for_its_text_alone() -> None:
    assert number_of("") == 0 and text_of(0) == ""
    assert number_of("a") == number_of("a") != number_of("b")
    assert text_of(number_of("ä\n")) == "ä\n"
    assert repr(Exprs().text("shown")) == '"shown"'
