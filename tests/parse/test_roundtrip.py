"""Random trees print as text that parses to the same tree."""

from __future__ import annotations

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from planarc.core.source import NOWHERE, Source, Span
from planarc.ir import syntax as s
from planarc.ir.text.expression import expression_text
from planarc.parse.parser import parse_expression, parse_text
from tests.ir.text.syntax import class_text, definition_text

ANNOTATION = Source("annotation", '(Icon(a = "(", b = {1, 2}))')
QUICK = settings(
    max_examples=120, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)


def node(kind: type, *parts: st.SearchStrategy, **named: st.SearchStrategy) -> st.SearchStrategy:
    return st.builds(kind, st.just(NOWHERE), *parts, **named)


def some(items: st.SearchStrategy, least: int = 0, most: int = 2) -> st.SearchStrategy:
    return st.lists(items, min_size=least, max_size=most).map(tuple)


def maybe(item: st.SearchStrategy) -> st.SearchStrategy:
    return st.none() | item


# Expressions

NAMES = st.sampled_from(["a", "b", "x_1", "R", "'q d'", r"'it\'s'", "initial_", "End"])
TEXTS = st.text(st.sampled_from('aé"\\\n\t\r /*<'), max_size=5)
COMMENTS = st.just("") | TEXTS
PLAIN = node(s.Ref, some(node(s.RefPart, NAMES), 1), st.booleans())
REALS = st.sampled_from(["1e-6", "1.", "2.50", "1E+3", "0.1e1"])

LEAVES = st.one_of(
    node(s.Integer, st.integers(0, 10**9)),
    REALS.map(lambda text: s.Real(NOWHERE, float(text), text)),
    node(s.String, TEXTS),
    node(s.Boolean, st.booleans()),
    PLAIN,
)
BINARY = [*("+", "-", ".+", ".-", "*", "/", ".*", "./", "^", ".^"), *("and", "or")]
BINARY += ["<", "<=", ">", ">=", "==", "<>"]


def compound(inner: st.SearchStrategy) -> st.SearchStrategy:
    subscripts = some(inner | node(s.Colon) | node(s.End), 1)
    references = node(
        s.Ref, some(node(s.RefPart, NAMES, st.just(()) | subscripts), 1), st.booleans()
    )
    functions = PLAIN | st.sampled_from(["der", "initial", "pure"]).map(
        lambda name: s.Ref(NOWHERE, (s.RefPart(NOWHERE, name),))
    )
    named = some(node(s.NamedArgument, NAMES, inner))
    partial = node(s.PartialApplication, PLAIN, named)
    iterators = some(node(s.Iterator, NAMES, maybe(inner)), 1)
    comprehension = node(s.Comprehension, inner, iterators).map(lambda c: (c,))
    return st.one_of(
        references,
        node(s.Unary, st.sampled_from(["-", "+", ".-", ".+", "not"]), inner),
        node(s.Binary, st.sampled_from(BINARY), inner, inner),
        node(s.If, some(st.tuples(inner, inner), 1), inner),
        node(s.Range, inner, maybe(inner), inner),
        node(s.Call, functions, some(inner | partial), named),
        node(s.Call, functions, comprehension),
        node(s.Array, some(inner, 1) | comprehension),
        node(s.Matrix, some(some(inner, 1), 1)),
        node(s.Tuple, some(maybe(inner), 2, 3)),
        node(s.Index, inner, subscripts),
        node(s.Member, inner, NAMES),
    )


EXPRESSIONS = st.recursive(LEAVES, compound, max_leaves=12)
REFERENCES = node(s.Ref, some(node(s.RefPart, NAMES, some(EXPRESSIONS, 0, 1)), 1), st.booleans())

# Modifications

TYPE_WORDS = {
    "variability": st.sampled_from(s.Variability),
    "causality": st.sampled_from(s.Causality),
    "flow": st.sampled_from(s.Flow),
}
ANNOTATIONS = maybe(st.just(s.Annotation(Span(ANNOTATION, 0, len(ANNOTATION.text)))))


def modification(arguments: st.SearchStrategy) -> st.SearchStrategy:
    return st.one_of(
        node(s.Modification, arguments, maybe(EXPRESSIONS)),
        node(s.Modification, arguments, broken=st.just(True)),
    )


def constraint(arguments: st.SearchStrategy) -> st.SearchStrategy:
    return node(s.Constraint, PLAIN, maybe(node(s.Modification, arguments)))


def short_bodies(arguments: st.SearchStrategy) -> st.SearchStrategy:
    literal = node(s.EnumerationLiteral, NAMES, COMMENTS)
    return st.one_of(
        node(
            s.ShortClass,
            PLAIN,
            some(EXPRESSIONS, 0, 1),
            maybe(node(s.Modification, arguments)),
            TYPE_WORDS["causality"],
            TYPE_WORDS["flow"],
        ),
        node(s.Enumeration, maybe(some(literal))),
    )


@st.composite
def redeclarations(draw: st.DrawFn, arguments: st.SearchStrategy) -> s.ElementRedeclaration:
    redeclare = draw(st.booleans())
    replaceable = draw(st.booleans()) or not redeclare
    final = draw(st.booleans())
    prefixes = s.Prefixes(redeclare=redeclare, replaceable=replaceable, final=final)
    common = {
        "prefixes": st.just(prefixes),
        "constraint": maybe(constraint(arguments)) if replaceable else st.none(),
        "comment": COMMENTS,
        "annotation": ANNOTATIONS,
    }
    component = node(
        s.Component,
        NAMES,
        PLAIN,
        dimensions=some(EXPRESSIONS, 0, 1),
        modification=maybe(modification(arguments)),
        **TYPE_WORDS,
        **common,
    )
    element = component | class_definitions(short_bodies(arguments), short=True, **common)
    return s.ElementRedeclaration(NOWHERE, draw(element), redeclare, draw(st.booleans()), final)


def class_definitions(
    bodies: st.SearchStrategy, short: bool = False, **common: st.SearchStrategy
) -> st.SearchStrategy:
    purity = st.sampled_from([s.ClassKind.FUNCTION, s.ClassKind.OPERATOR_FUNCTION])
    flags = {"partial": st.booleans(), "encapsulated": st.just(False) if short else st.booleans()}
    names = st.just(NOWHERE)
    return st.one_of(
        node(s.ClassDef, NAMES, st.sampled_from(s.ClassKind), bodies, names, **flags, **common),
        node(s.ClassDef, NAMES, purity, bodies, names, pure=st.booleans(), **flags, **common),
    )


def arguments_of(inner: st.SearchStrategy) -> st.SearchStrategy:
    element = node(
        s.ElementModification,
        some(NAMES, 1),
        maybe(modification(inner)),
        st.booleans(),
        st.booleans(),
        COMMENTS,
    )
    return some(element | redeclarations(inner))


ARGUMENTS = st.recursive(st.just(()), arguments_of, max_leaves=4)
MODIFICATIONS = maybe(modification(ARGUMENTS))
CLASS_MODIFICATIONS = maybe(node(s.Modification, ARGUMENTS))

# Equations and statements

CALLS = node(s.Call, PLAIN, some(EXPRESSIONS))


def iterators() -> st.SearchStrategy:
    return some(node(s.Iterator, NAMES, maybe(EXPRESSIONS)), 1)


def branches(body: st.SearchStrategy) -> st.SearchStrategy:
    return some(st.tuples(EXPRESSIONS, body), 1)


EQUATIONS = st.recursive(
    st.one_of(
        node(s.Equality, EXPRESSIONS, EXPRESSIONS, COMMENTS),
        node(s.Connect, REFERENCES, REFERENCES),
        node(s.CallEquation, CALLS),
    ),
    lambda inner: st.one_of(
        node(s.IfEquation, branches(some(inner)), some(inner)),
        node(s.WhenEquation, branches(some(inner))),
        node(s.ForEquation, iterators(), some(inner)),
    ),
    max_leaves=4,
)
STATEMENTS = st.recursive(
    st.one_of(
        node(s.Assignment, REFERENCES, EXPRESSIONS),
        node(s.TupleAssignment, some(maybe(REFERENCES), 2), CALLS),
        node(s.CallStatement, CALLS),
        node(s.Break),
        node(s.Return),
    ),
    lambda inner: st.one_of(
        node(s.IfStatement, branches(some(inner)), some(inner)),
        node(s.WhenStatement, branches(some(inner))),
        node(s.ForStatement, iterators(), some(inner)),
        node(s.WhileStatement, EXPRESSIONS, some(inner)),
    ),
    max_leaves=4,
)

# Classes


@st.composite
def prefixed(draw: st.DrawFn, protected: bool) -> dict[str, object]:
    words = ("redeclare", "final", "inner", "outer", "replaceable")
    flags = {word: draw(st.booleans()) for word in words}
    return {
        "prefixes": s.Prefixes(**flags, protected=protected),
        "constraint": draw(maybe(constraint(ARGUMENTS))) if flags["replaceable"] else None,
        "comment": draw(COMMENTS),
        "annotation": draw(ANNOTATIONS),
    }


@st.composite
def elements(draw: st.DrawFn, classes: st.SearchStrategy) -> s.Element:
    protected = draw(st.booleans())
    kind = draw(st.sampled_from(["component", "class", "extends", "import"]))
    if kind == "component":
        plain = node(
            s.Component,
            NAMES,
            PLAIN,
            some(EXPRESSIONS, 0, 1),
            some(EXPRESSIONS, 0, 1),
            MODIFICATIONS,
            maybe(EXPRESSIONS),
            **TYPE_WORDS,
            **{key: st.just(value) for key, value in draw(prefixed(protected)).items()},
        )
        return draw(plain)
    if kind == "class":
        return replace(draw(classes), **draw(prefixed(protected)))
    if kind == "extends":
        deselected = node(s.Deselection, NAMES | node(s.Connect, REFERENCES, REFERENCES))
        arguments = st.tuples(ARGUMENTS, some(deselected, 0, 1)).map(lambda pair: pair[0] + pair[1])
        change = maybe(node(s.Modification, arguments))
        return draw(node(s.Extends, PLAIN, change, st.just(protected), ANNOTATIONS))
    path = some(NAMES, 1)
    return draw(
        node(s.Import, path, maybe(NAMES))
        | node(s.Import, path, wildcard=st.just(True))
        | node(s.Import, path, names=some(NAMES, 1))
    )


def long_bodies(classes: st.SearchStrategy) -> st.SearchStrategy:
    sections = some(
        node(s.EquationSection, some(EQUATIONS), st.booleans())
        | node(s.AlgorithmSection, some(STATEMENTS), st.booleans())
    )
    call = {"function": NAMES, "arguments": some(EXPRESSIONS), "result": maybe(REFERENCES)}
    external = node(s.External, maybe(TEXTS), annotation=ANNOTATIONS) | node(
        s.External, maybe(TEXTS), annotation=ANNOTATIONS, **call
    )
    composition = node(s.Composition, some(elements(classes)), sections, maybe(external))
    return composition | node(s.ExtendsClass, composition, CLASS_MODIFICATIONS)


DERIVATIVES = node(s.DerivativeClass, PLAIN, some(NAMES, 1))
SHORT = class_definitions(
    short_bodies(ARGUMENTS) | DERIVATIVES, comment=COMMENTS, annotation=ANNOTATIONS
)
CLASSES = st.recursive(
    SHORT,
    lambda inner: class_definitions(long_bodies(inner), comment=COMMENTS, annotation=ANNOTATIONS),
    max_leaves=3,
)


@QUICK
@given(EXPRESSIONS)
def test_expressions(tree: s.Expression) -> None:
    inside = s.Ref(NOWHERE, (s.RefPart(NOWHERE, "v", (tree,)),))  # where `end` has a meaning
    assert parse_expression(expression_text(inside)) == inside


@QUICK
@given(EQUATIONS)
def test_equations(tree: s.Equation) -> None:
    body = s.Composition(NOWHERE, (), (s.EquationSection(NOWHERE, (tree,)),))
    assert_same_again(body)


@QUICK
@given(STATEMENTS)
def test_statements(tree: s.Statement) -> None:
    body = s.Composition(NOWHERE, (), (s.AlgorithmSection(NOWHERE, (tree,)),))
    assert_same_again(body)


def assert_same_again(body: s.Composition) -> None:
    cls = s.ClassDef(NOWHERE, "M", s.ClassKind.MODEL, body, NOWHERE)
    assert parse_text(Source("test.pmo", class_text(cls))).classes == (cls,)


@QUICK
@given(st.lists(CLASSES, max_size=2), maybe(some(NAMES)))
def test_files(classes: list[s.ClassDef], within: tuple[str, ...] | None) -> None:
    tree = s.StoredDefinition(NOWHERE, tuple(classes), within)
    assert parse_text(Source("test.pmo", definition_text(tree))) == tree
