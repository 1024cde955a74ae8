"""Each construct of the language: it parses, and prints as text with the same tree."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from planarc.core.source import Source
from planarc.ir import syntax
from planarc.parse.parser import parse_annotation, parse_text
from tests.ir.text.syntax import definition_text

ELEMENTS = """
import A.B
import C = A.B
import A.B.*
import A.B.{x, y}
extends A.B(x = 1, redeclare model M = N) annotation(a = 1)
extends .A(break x, break connect(a.b, c[1]), y = 2)
Real x, y[2], z(start = 1) = 3 "d" annotation(a = 1)
parameter Real[3, :] x[n](each unit = "m", each final min = 0) = a if b > 0 "d" + "e"
flow discrete input Real x
stream constant output Real x
redeclare final inner outer replaceable parameter .A.B x(y = z) constrainedby C(u = 1) "d"
replaceable Internal.Circle curve1(phi = frame_a.phi) extends Interfaces.BaseCurve(phi = 1, r = 2)
inner World world
Real x = break
Real x(a(b(c = 1))) = 2
Real x(final a.b = 1 "d", redeclare replaceable model M = N constrainedby P "d", final y)
Real x(redeclare each final parameter Real z[2] = 1, replaceable A b extends C)
class A end A
partial model A "d" end A
encapsulated package A end A
record A end A
operator record A end A
operator A end A
block A end A
connector A end A
expandable connector A end A
type A end A
function A end A
pure function A end A
impure function A end A
operator function A end A
pure operator function A end A
type A = B
type A = input Real[3, n](unit = "m") "d" annotation(a = 1)
connector A = flow Real
type A = enumeration(a, b "d", c annotation(x = 1)) "d"
type A = enumeration()
type A = enumeration(:)
function A = der(f, x, y) "d"
redeclare model extends A(x = 1) "d" Real y; equation y = 1; end A
replaceable package Medium = A constrainedby B(x = 1) "d" annotation(a = 1)
replaceable function f end f
final replaceable model A = B
""".strip().splitlines()

EQUATIONS = """
a = b
a + b = c "d"
-a = if b then c elseif d then e else f
(a, , b) = f(x)
(a, b)[1] = c
(a).b = c
assert(a > b, "m", AssertionLevel.warning)
Connections.branch(a.R, b.R)
connect(a.b[1, :], c) annotation(Line(points = {{1, 2}, {3, 4}}))
connect(.a, b) "d"
if a then b = 1; c = 2; elseif d then e = 3; else f = 4; end if
if a then end if
if a then else b = 1; end if
for i in 1:n, j in {1, 3}, k loop a[i] = b[j]; end for
for i loop end for
when a then b = pre(b) + 1; elsewhen {c, initial(), d} then reinit(e, 0); end when
der(x) = [1, 2; 3, 4]*y[end]
x = {i^2 for i in 1:3}
x = {{1, 2}, {a, b}}
x = 1:2:n
x = pure(f(y))
x = initial() or terminal()
x = f(function g(a = 1), b = function h())
x = a.b[1].c[:, 2:end]
x = .A.B.c
""".strip().splitlines()

STATEMENTS = """
a := b
a.b[1] := b "d"
(a, , b[2]) := f(x)
(, a) := f(x)
f(x)
assert(a, "m")
if a then b := 1; elseif c then d := 2; else e := 3; end if
for i in 1:n, j loop a := 1; break; end for
while a > 1 loop a := a - 1; return; end while
when a then b := 1; elsewhen c then b := 2; end when
break
return
""".strip().splitlines()

EXTERNALS = """
external
external "C"
external "C" f(x, y)
external "FORTRAN 77" y = f(x, size(x, 1)) annotation(Library = "a")
external "builtin" annotation(a = 1)
""".strip().splitlines()


def assert_prints_as_itself(text: str) -> syntax.StoredDefinition:
    tree = parse_text(Source("test.pmo", text))
    printed = definition_text(tree)
    again = parse_text(Source("printed.pmo", printed))
    assert again == tree, printed
    assert definition_text(again) == printed
    return tree


@pytest.mark.parametrize("text", ELEMENTS)
@pytest.mark.parametrize("access", ["", "public ", "protected "])
def test_elements(text: str, access: str) -> None:
    tree = assert_prints_as_itself(f"model M {access}{text}; end M;")
    body = tree.classes[0].body
    assert isinstance(body, syntax.Composition)
    assert len(body.elements) == text.count(", y[2], z(") * 2 + 1


@pytest.mark.parametrize("text", EQUATIONS)
@pytest.mark.parametrize("section", ["equation", "initial equation"])
def test_equations(text: str, section: str) -> None:
    tree = assert_prints_as_itself(f"model M {section} {text}; end M;")
    body = tree.classes[0].body
    assert isinstance(body, syntax.Composition)
    (found,) = body.sections
    assert isinstance(found, syntax.EquationSection)
    assert len(found.equations) == 1
    assert found.initial == section.startswith("initial")


@pytest.mark.parametrize("text", STATEMENTS)
@pytest.mark.parametrize("section", ["algorithm", "initial algorithm"])
def test_statements(text: str, section: str) -> None:
    tree = assert_prints_as_itself(f"model M {section} {text}; end M;")
    body = tree.classes[0].body
    assert isinstance(body, syntax.Composition)
    (found,) = body.sections
    assert isinstance(found, syntax.AlgorithmSection)
    assert len(found.statements) == 1


@pytest.mark.parametrize("text", EXTERNALS)
def test_external_functions(text: str) -> None:
    tree = assert_prints_as_itself(f"function f input Real x; {text}; annotation(b = 1); end f;")
    body = tree.classes[0].body
    assert isinstance(body, syntax.Composition)
    assert body.external is not None
    assert tree.classes[0].annotation is not None


@pytest.mark.parametrize(
    ("text", "within"),
    [
        ("", None),
        ("within;", ()),
        ("within A.B; model M end M;", ("A", "B")),
        ("final model M end M; package P end P;", None),
    ],
)
def test_files(text: str, within: tuple[str, ...] | None) -> None:
    assert assert_prints_as_itself(text).within == within


def test_the_constraint_of_the_2008_paper() -> None:
    old = "model M replaceable A a(x=1) extends B(y=2); end M;"
    new = "model M replaceable A a(x=1) constrainedby B(y=2); end M;"
    assert parse_text(Source("a", old)) == parse_text(Source("a", new))


def test_sections_keep_their_order_and_protection_its_elements() -> None:
    text = """model M
      Real a; protected Real b; import X; extends E; public Real c;
      equation a = 1; protected Real d; algorithm b := 1; initial equation c = 1;
    end M;"""
    body = assert_prints_as_itself(text).classes[0].body
    assert isinstance(body, syntax.Composition)
    protected = {
        e.name: e.prefixes.protected for e in body.elements if isinstance(e, syntax.Component)
    }
    assert protected == {"a": False, "b": True, "c": False, "d": True}
    assert [e.protected for e in body.elements if isinstance(e, syntax.Extends)] == [True]
    kinds = [(type(s).__name__, s.initial) for s in body.sections]
    assert kinds == [
        ("EquationSection", False),
        ("AlgorithmSection", False),
        ("EquationSection", True),
    ]


@pytest.mark.parametrize(
    "text",
    [
        "model M annotation(a = 1); Real x; equation x = 1; end M;",
        "model M Real x; annotation(a = 1); protected Real y; equation x = 1; end M;",
        "model M Real x; equation x = 1; annotation(a = 1); end M;",
        "model M Real x; algorithm x := 1; annotation(a = 1); equation end M;",
    ],
)
def test_the_class_annotation_may_stand_anywhere(
    text: str, parse: Callable[[str], syntax.StoredDefinition]
) -> None:
    annotation = parse(text).classes[0].annotation
    assert annotation is not None
    assert annotation.span.text == "(a = 1)"


@pytest.mark.parametrize(
    "body",
    [
        "()",
        '(a = ")", b = "\\")")',
        "(a = 1 /* ) */, b // )\n = 2)",
        "('a)' = ((1) + (2))/3)",
    ],
)
def test_the_body_of_an_annotation_is_found_without_reading_it(
    body: str, parse: Callable[[str], syntax.StoredDefinition]
) -> None:
    annotation = parse(f"model M annotation /* ( */ {body}; end M;").classes[0].annotation
    assert annotation is not None
    assert annotation.span.text == body
    assert len(parse_annotation(annotation)) == body.count(" = ")


def test_what_a_declaration_says(parse: Callable[[str], syntax.StoredDefinition]) -> None:
    body = (
        parse('model M final parameter input Real[2] x[3](start = 1) = y if c "text"; end M;')
        .classes[0]
        .body
    )
    assert isinstance(body, syntax.Composition)
    (x,) = body.elements
    assert isinstance(x, syntax.Component)
    assert (x.name, str(x.type), x.comment) == ("x", "Real", "text")
    assert (len(x.type_dimensions), len(x.dimensions)) == (1, 1)
    assert x.variability is syntax.Variability.PARAMETER
    assert x.causality is syntax.Causality.INPUT
    assert x.prefixes == syntax.Prefixes(final=True)
    assert x.modification is not None
    assert isinstance(x.modification.binding, syntax.Ref)
    assert isinstance(x.condition, syntax.Ref)
    assert x.span.text == "x[3](start = 1) = y"


def test_spans_of_classes(parse: Callable[[str], syntax.StoredDefinition]) -> None:
    tree = parse("within A;\npartial model M\nend M;\n")
    assert tree.classes[0].span.text == "partial model M\nend M"
    assert tree.classes[0].name_span.text == "M"
    assert (tree.classes[0].name_span.line, tree.classes[0].name_span.column) == (2, 15)
