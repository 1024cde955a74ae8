"""Precedence and associativity (3.2), numbers and strings (2.4), by their trees."""

from __future__ import annotations

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir import syntax
from planarc.ir.text.expression import expression_text
from planarc.parse.parser import parse_expression


def with_parentheses(e: syntax.Expression) -> str:
    """Every operator in parentheses of its own."""
    match e:
        case syntax.Binary():
            return f"({with_parentheses(e.left)} {e.op} {with_parentheses(e.right)})"
        case syntax.Unary():
            return f"({e.op} {with_parentheses(e.operand)})"
        case syntax.Range():
            parts = (e.start, e.stop) if e.step is None else (e.start, e.step, e.stop)
            return f"({' : '.join(map(with_parentheses, parts))})"
        case _:
            return expression_text(e)


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("a + b - c", "((a + b) - c)"),
        ("a/b*c", "((a / b) * c)"),
        ("a - b*c", "(a - (b * c))"),
        ("-a^2", "(- (a ^ 2))"),
        ("-a*b + c", "((- (a * b)) + c)"),
        ("a^(-b)", "(a ^ (- b))"),
        ("a .* b ./ c .^ d", "((a .* b) ./ (c .^ d))"),
        ("a .+ b .- c", "((a .+ b) .- c)"),
        (".-a .+ b", "((.- a) .+ b)"),
        ("a + b < c*d", "((a + b) < (c * d))"),
        ("not a < b and c or d", "(((not (a < b)) and c) or d)"),
        ("a or b and c", "(a or (b and c))"),
        ("a or b or c", "((a or b) or c)"),
        ("1:n + 1", "(1 : (n + 1))"),
        ("a:b:c", "(a : b : c)"),
        ("a == b or c <> d", "((a == b) or (c <> d))"),
        ("((a))", "a"),
    ],
)
def test_operators_bind_as_the_specification_says(text: str, meaning: str) -> None:
    assert with_parentheses(parse_expression(text)) == meaning


@pytest.mark.parametrize(
    "text",
    [
        *("a^b^c", "a < b < c", "a == b == c", "a*-b", "a + -b", "--a", "not not a", "a:b:c:d"),
        *("f(a = 1, 2)", "a b", "{}", "()", "f(,)", "f(a,)", "[a;]", "{a,}", "(a)(b)", "a[]"),
        *(".5", "1e", "1.2.3", "0x1", "1e+", '"a', "'a", "''", "if a then b", "end", "model"),
        *("a = b", "a := b", "function f()", "a.", "a..b", "a.1", "der", "1..2", "1e999"),
    ],
)
def test_what_is_no_expression_is_refused(text: str) -> None:
    with pytest.raises(PlanarcError) as caught:
        parse_expression(text)
    assert all(d.code.startswith("P1") and d.span for d in caught.value.diagnostics)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-6", 1e-6), ("1.", 1.0), ("1.5E+3", 1500.0), ("2.e1", 20.0), ("0.1", 0.1), ("7e0", 7.0)],
)
def test_reals_keep_how_they_were_written(text: str, value: float) -> None:
    number = parse_expression(text)
    assert isinstance(number, syntax.Real)
    assert (number.value, number.text) == (value, text)
    assert expression_text(number) == text


def test_integers_are_not_reals() -> None:
    number = parse_expression("12345678901234567890")
    assert isinstance(number, syntax.Integer)
    assert number.value == 12345678901234567890


def test_every_escape_of_a_string() -> None:
    text = r'''"\'\"\?\\\a\b\f\n\r\t\v'é"'''
    string = parse_expression(text)
    assert isinstance(string, syntax.String)
    assert string.value == "'\"?\\\a\b\f\n\r\t\v'é"
    assert parse_expression(expression_text(string)) == string


def test_a_string_may_have_several_lines() -> None:
    string = parse_expression('"a\nb"')
    assert isinstance(string, syntax.String)
    assert string.value == "a\nb"


def test_quoted_names_keep_their_quotes() -> None:
    name = parse_expression(r"'a b.c\'d'.x")
    assert isinstance(name, syntax.Ref)
    assert name.names == (r"'a b.c\'d'", "x")


def test_comments_do_not_nest() -> None:
    assert parse_expression("a /* b /* c */ + d // e */") == parse_expression("a + d")


def test_end_is_a_subscript_only() -> None:
    index = parse_expression("a[end - 1, f({end}), b[end]]")
    assert isinstance(index, syntax.Ref)
    first, second, third = index.parts[0].subscripts
    assert with_parentheses(first) == "(end - 1)"
    assert expression_text(second) == "f({end})"
    assert expression_text(third) == "b[end]"


def test_a_point_after_digits_belongs_to_the_number() -> None:
    """`1.*x` is `1. * x`: the longest number is read (2.4)."""
    product = parse_expression("1.*x")
    assert isinstance(product, syntax.Binary)
    assert (product.op, expression_text(product.left)) == ("*", "1.")


def test_arguments_by_place_and_by_name() -> None:
    call = parse_expression("f(a, function g(b = 1), c = {2}, d = function h())")
    assert isinstance(call, syntax.Call)
    assert [type(a) for a in call.arguments] == [syntax.Ref, syntax.PartialApplication]
    assert [n.name for n in call.named] == ["c", "d"]


def test_iterators_of_a_comprehension() -> None:
    call = parse_expression("sum(a[i]*b[j] for i in 1:n, j)")
    assert isinstance(call, syntax.Call)
    (inner,) = call.arguments
    assert isinstance(inner, syntax.Comprehension)
    assert [(i.name, i.range is None) for i in inner.iterators] == [("i", False), ("j", True)]


def test_spans_point_at_the_text() -> None:
    text = "x + f(a.b[1], 2*c)^2"
    total = parse_expression(text)
    assert isinstance(total, syntax.Binary)
    assert total.span.text == text
    assert total.right.span.text == "f(a.b[1], 2*c)^2"
    power = total.right
    assert isinstance(power, syntax.Binary)
    assert isinstance(power.left, syntax.Call)
    assert [a.span.text for a in power.left.arguments] == ["a.b[1]", "2*c"]
