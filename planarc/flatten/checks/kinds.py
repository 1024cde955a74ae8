"""What a class of its kind may hold, extend and be called.

In:   the classes that a run opened, each with its layout
Out:  errors F229, F237, F238, once for each text

    kind                    sections   protected   prefixes that its components may not have
    record                  none       none        input, output, flow, stream, inner, outer
    connector               none       none        inner, outer
    expandable connector    none       none        inner, outer, flow
    package, type           none       any
    function                one        any         inner, outer

Reference: Modelica Language Specification 3.6, sections 2.3.3, 4.6, 4.9.5, 7.1.3, 9.1.3, 12.2.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.prose import ticked
from planarc.core.source import Span
from planarc.flatten.tree.naming import name_span
from planarc.flatten.tree.nodes import Class, Part, Session
from planarc.ir import syntax
from planarc.ir.syntax import ClassKind


class _Rule(Data):
    """What a class of one kind may not hold."""

    prefixes: frozenset[str] = frozenset()
    sections: bool = True
    protected: bool = True
    #: whether what is protected may be an input or an output
    hidden: bool = True


_SHARED = frozenset({"inner", "outer"})
_CONNECTOR = _Rule(_SHARED, sections=False, protected=False)
_RECORD = _Rule(_SHARED | {"input", "output", "flow", "stream"}, sections=False, protected=False)
_RULES = {
    ClassKind.RECORD: _RECORD,
    ClassKind.OPERATOR_RECORD: _RECORD,
    ClassKind.CONNECTOR: _CONNECTOR,
    ClassKind.EXPANDABLE_CONNECTOR: _Rule(_SHARED | {"flow"}, sections=False, protected=False),
    ClassKind.PACKAGE: _Rule(sections=False),
    ClassKind.TYPE: _Rule(sections=False),
    ClassKind.FUNCTION: _Rule(_SHARED, hidden=False),
    ClassKind.OPERATOR_FUNCTION: _Rule(_SHARED, hidden=False),
}

#: the kinds that a class of a kind may extend, beside its own and `class` (7.1.3)
_BASES = {
    ClassKind.CLASS: {
        ClassKind.RECORD,
        ClassKind.CONNECTOR,
        ClassKind.EXPANDABLE_CONNECTOR,
        ClassKind.BLOCK,
        ClassKind.MODEL,
        ClassKind.TYPE,
    },
    ClassKind.OPERATOR_FUNCTION: {ClassKind.FUNCTION},
    ClassKind.CONNECTOR: {ClassKind.TYPE, ClassKind.RECORD, ClassKind.OPERATOR_RECORD},
    ClassKind.BLOCK: {ClassKind.RECORD},
    ClassKind.MODEL: {ClassKind.RECORD, ClassKind.BLOCK},
}

#: names of predefined types, which no other element may have (2.3.3)
_RESERVED = frozenset({"Real", "Integer", "Boolean", "String"})
#: attributes of enumerations, which no literal may be called (4.9.5)
_ATTRIBUTES = frozenset({"quantity", "min", "max", "start", "fixed"})


def check_classes(session: Session) -> None:
    """Report what the classes of the model may not be."""
    seen: set[int] = set()
    for cls in session.opened:
        if id(cls.definition) not in seen:
            seen.add(id(cls.definition))
            session.errors += _errors(cls)


def _errors(cls: Class) -> Iterator[Diagnostic]:
    definition, layout = cls.definition, cls.layout
    assert layout is not None
    yield from _names(definition)
    yield from _imports(layout.parts[0].imports)
    yield from _bases(definition, layout.parts)
    body = definition.body
    if isinstance(body, syntax.ExtendsClass):
        body = body.composition
    if isinstance(body, syntax.Composition):
        yield from _content(definition, body)
        yield from _alone(definition, body, layout.parts)


def _names(definition: syntax.ClassDef) -> Iterator[Diagnostic]:
    body, names = definition.body, [(definition.name, definition.name_span)]
    if isinstance(body, syntax.Composition):
        named = (e for e in body.elements if isinstance(e, syntax.Component | syntax.ClassDef))
        names += [(e.name, name_span(e)) for e in named]
    if isinstance(body, syntax.Enumeration):
        for literal in body.literals or ():
            if literal.name in _ATTRIBUTES:
                message = f"`{literal.name}` is an attribute of enumerations, and so no literal"
                yield Diagnostic("F229", message, literal.span, hint="choose another name")
    for name, span in names:
        if name in _RESERVED:
            message = f"`{name}` is a predefined type, and nothing else can have its name"
            yield Diagnostic("F229", message, span, hint="choose another name")


def _imports(clauses: tuple[syntax.Import, ...]) -> Iterator[Diagnostic]:
    """Each name is imported once (13.2.1.1)."""
    seen: dict[str, syntax.Import] = {}
    for clause in clauses:
        for name in clause.names or (() if clause.wildcard else (clause.alias or clause.path[-1],)):
            first = seen.setdefault(name, clause)
            if first is not clause:
                related = (Related("first here", first.span),)
                message = f"`{name}` is imported twice"
                yield Diagnostic("F212", message, clause.span, related=related)


def _content(definition: syntax.ClassDef, body: syntax.Composition) -> Iterator[Diagnostic]:
    kind = definition.kind
    rule = _RULES.get(kind)
    if rule is None:
        return
    article = "an" if kind is ClassKind.EXPANDABLE_CONNECTOR else "a"
    for section in () if rule.sections else body.sections:
        what = "equations" if isinstance(section, syntax.EquationSection) else "algorithms"
        yield _refused(f"{article} {kind.value} cannot have {what}", section.span, definition)
    for element in body.elements:
        if not isinstance(element, syntax.Component):
            continue
        if element.prefixes.protected and not rule.protected:
            message = f"{article} {kind.value} has no protected elements"
            yield _refused(message, element.span, definition)
        if element.prefixes.protected and element.causality.value and not rule.hidden:
            message = f"the {element.causality.value} `{element.name}` of {article} {kind.value}"
            yield _refused(f"{message} cannot be protected", element.span, definition)
        for word in prefixes_of(element):
            if word in rule.prefixes:
                message = f"a component of {article} {kind.value} cannot be `{word}`"
                yield _refused(message, element.span, definition)


def _refused(message: str, span: Span, definition: syntax.ClassDef) -> Diagnostic:
    place = Related(f"`{definition.name}` begins here", definition.name_span)
    return Diagnostic("F237", message, span, related=(place,))


def prefixes_of(element: syntax.Component | syntax.ShortClass) -> list[str]:
    """The words before a component's type that say what it is, as written."""
    words = [element.flow.value, element.causality.value]
    if isinstance(element, syntax.Component):
        prefixes = element.prefixes
        words = [*words, element.variability.value]
        words += ["inner"] * prefixes.inner + ["outer"] * prefixes.outer
    return [word for word in words if word]


def _bases(definition: syntax.ClassDef, parts: list[Part]) -> Iterator[Diagnostic]:
    """Kinds may be derived from their own, from `class`, and few others."""
    allowed = {definition.kind, ClassKind.CLASS} | _BASES.get(definition.kind, set())
    for part in parts[1:]:
        base = part.definition
        if part.derived == 0 and base.kind not in allowed and base.name not in _OPEN_TYPES:
            yield Diagnostic(
                "F238",
                f"the {definition.kind.value} `{definition.name}` cannot extend the "
                f"{base.kind.value} `{part.cls.name}`",
                _place(definition, base.name),
                related=(Related("the base class", base.name_span),) if base.span.text else (),
            )


def _place(definition: syntax.ClassDef, name: str) -> Span:
    """The extends clause, or the right side of a short class."""
    body = definition.body
    if isinstance(body, syntax.Composition):
        clauses = [e for e in body.elements if isinstance(e, syntax.Extends)]
        found = [e.span for e in clauses if e.base.names[-1] == name]
        return next(iter([*found, *(e.span for e in clauses)]), definition.name_span)
    return body.span if isinstance(body, syntax.ShortClass) else definition.name_span


def _alone(
    definition: syntax.ClassDef, body: syntax.Composition, parts: list[Part]
) -> Iterator[Diagnostic]:
    """A type, an array class, or one with a prefix is extended by itself or not at all (7.1)."""
    bases = [p for p in parts if p.derived == 0]
    own = [e.name for e in body.elements if isinstance(e, syntax.Component)]
    if len(bases) + len(own) < 2:
        return
    for part in bases:
        layout = part.cls.layout
        if layout is None or not (
            layout.dimensions
            or (layout.builtin is not None and layout.builtin.name not in _OPEN_TYPES)
            or layout.causality is not syntax.Causality.NONE
            or layout.flow is not syntax.Flow.NONE
        ):
            continue
        others = own or [p.cls.name for p in bases if p is not part]
        yield Diagnostic(
            "F238",
            f"`{definition.name}` extends `{part.cls.name}`, which is no plain class, "
            f"and so cannot have {ticked(others[:3])} as well",
            _place(definition, part.definition.name),
        )


_OPEN_TYPES = ("ExternalObject",)
