"""Each place at which a text writes a name, with what is needed to find out what it means.

In:   Text
Out:  Mention   of a declared name, of each part of a reference, of modifiers and arguments

Example: `Body b(m = k.x);` in the class `M` writes

    Body   REFERENCE    path (Body,)
    b      DECLARATION
    m      MODIFIER     path (m,) of the class Body
    k, x   REFERENCE    paths (k,) and (k, x)

Names of annotations are read, too, as far as they are expressions: `Dialog(enable = on)`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from enum import Enum
from itertools import dropwhile, islice
from typing import TypeAlias

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.editor.texts import Text
from planarc.ir import syntax
from planarc.parse.parser import read

_WORD = re.compile(
    r"//[^\n]*|/\*.*?\*/|(?P<name>'(?:[^'\\\n]|\\.)+'|[A-Za-z_]\w*)|(?P<mark>[\"=(])", re.DOTALL
)
_PREFIXES = frozenset(("each", "final", "redeclare", "replaceable", "break", "import"))
_LOOPS = syntax.Comprehension | syntax.ForEquation | syntax.ForStatement

Locals: TypeAlias = Mapping[str, syntax.Iterator]


class Kind(Enum):
    REFERENCE = "reference"
    IMPORT = "import"  # a full name
    MODIFIER = "modifier"  # a member of the class `base`
    DECLARATION = "declaration"
    ITERATOR = "iterator"
    LITERAL = "literal"  # of an enumeration, where it is declared


class Mention(Data):
    """A place that writes a name. `owner` are the classes around, from the outermost of the text.
    `path` ends in `name`."""

    kind: Kind
    name: str
    span: Span
    owner: tuple[str, ...]
    path: tuple[str, ...] = ()
    absolute: bool = False
    base: syntax.Ref | None = None
    #: the declaration, or for a reference the iterator that its first name means
    declared: syntax.Node | None = None
    is_type: bool = False  # where a class is to be named


Target: TypeAlias = tuple[syntax.Ref | None, tuple[str, ...]]


class Walk:
    """A walk over a text; with `at`, only over classes and equations that hold that place; with
    `word`, annotations are read only where they hold it."""

    def __init__(self, text: Text, at: int | None = None, word: str = "") -> None:
        self._text, self._at, self._word = text, at, word
        self._owner: tuple[str, ...] = ()

    def mentions(self) -> Iterator[Mention]:
        yield from self._within()
        for definition in self._text.tree.classes:
            if self._near(definition.span):
                yield from self._class(definition)

    def _near(self, span: Span) -> bool:
        return self._at is None or span.start <= self._at <= span.end

    def _within(self) -> Iterator[Mention]:
        tree = self._text.tree
        if tree.within:
            end = tree.classes[0].span.start if tree.classes else tree.span.end
            places = dropwhile(
                lambda place: place.text != "within", _names(Span(tree.span.source, 0, end))
            )
            for count, place in enumerate(islice(places, 1, len(tree.within) + 1), 1):
                yield Mention(Kind.IMPORT, place.text, place, (), tree.within[:count])

    # Classes

    def _class(self, definition: syntax.ClassDef, redeclared: bool = False) -> Iterator[Mention]:
        if not redeclared:
            yield self._declared(definition, definition.name, definition.name_span)
        outside = self._owner
        body = definition.body
        if definition.composition is not None:
            end = definition.span.end
            span = Span(definition.span.source, end - len(definition.name), end)
            if span.text == definition.name and span.start > definition.name_span.start:
                yield self._declared(definition, definition.name, span)
            self._owner = (*outside, definition.name)
        match body:
            case syntax.Composition():
                yield from self._composition(body)
            case syntax.ExtendsClass():
                yield from self._modification(body.modification, (None, ()))
                yield from self._composition(body.composition)
            case syntax.ShortClass():
                yield from self._ref(body.base, {}, True)
                yield from self._expressions(body.dimensions, {})
                yield from self._modification(body.modification, (body.base, ()))
            case syntax.Enumeration():
                for literal in body.literals or ():
                    span = _first(literal.span, literal.name)
                    yield Mention(
                        Kind.LITERAL, literal.name, span, (*outside, definition.name),
                        declared=literal,
                    )  # fmt: skip
            case syntax.DerivativeClass():
                yield from self._ref(body.function, {}, True)
        yield from self._constraint(definition.constraint)
        yield from self._annotation(definition.annotation)
        self._owner = outside

    def _declared(self, node: syntax.Declaration, name: str, span: Span) -> Mention:
        return Mention(Kind.DECLARATION, name, span, self._owner, (name,), declared=node)

    def _composition(self, body: syntax.Composition) -> Iterator[Mention]:
        last: syntax.Ref | None = None
        for element in body.elements:
            match element:
                case syntax.Import():
                    yield from self._import(element)
                case syntax.Extends():
                    yield from self._ref(element.base, {}, True)
                    yield from self._modification(element.modification, (element.base, ()))
                    yield from self._annotation(element.annotation)
                case syntax.Component():
                    clause = element.type is not last
                    if clause:
                        last = element.type
                        yield from self._ref(element.type, {}, True)
                        yield from self._expressions(element.type_dimensions, {})
                    yield from self._component(element, clause=clause)
                case syntax.ClassDef():
                    if self._near(element.span):
                        yield from self._class(element)
                    else:
                        yield self._declared(element, element.name, element.name_span)
        for section in body.sections:
            if self._near(section.span):
                yield from self._expressions(
                    section.equations
                    if isinstance(section, syntax.EquationSection)
                    else section.statements,
                    {},
                )
        if body.external is not None:
            parts = (body.external.result, *body.external.arguments)
            yield from self._expressions(tuple(p for p in parts if p is not None), {})

    def _component(
        self, node: syntax.Component, redeclared: bool = False, clause: bool = True
    ) -> Iterator[Mention]:
        """A component; with `clause` the first one of its clause, whose constraint all have."""
        if not redeclared:
            yield self._declared(node, node.name, _first(node.span, node.name))
        yield from self._expressions(node.dimensions, {})
        yield from self._modification(node.modification, (node.type, ()))
        yield from self._expressions(() if node.condition is None else (node.condition,), {})
        yield from self._constraint(node.constraint if clause else None)
        yield from self._annotation(node.annotation)

    def _constraint(self, constraint: syntax.Constraint | None) -> Iterator[Mention]:
        if constraint is not None:
            yield from self._ref(constraint.base, {}, True)
            yield from self._modification(constraint.modification, (constraint.base, ()))

    def _import(self, clause: syntax.Import) -> Iterator[Mention]:
        words = [p for p in _names(clause.span, '"') if p.text != "import"]
        if clause.alias is not None and words:
            words = words[1:]
        for count, place in enumerate(words[: len(clause.path)], 1):
            path = clause.path[:count]
            yield Mention(Kind.IMPORT, place.text, place, self._owner, path, is_type=True)
        for place in words[len(clause.path) :][: len(clause.names)]:
            path = (*clause.path, place.text)
            yield Mention(Kind.IMPORT, place.text, place, self._owner, path, is_type=True)

    # Modifications

    def _modification(
        self, modification: syntax.Modification | None, target: Target
    ) -> Iterator[Mention]:
        if modification is None:
            return
        base, outer = target
        for argument in modification.arguments:
            match argument:
                case syntax.ElementModification():
                    path = (*outer, *argument.name)
                    places = (p for p in _names(argument.span) if p.text not in _PREFIXES)
                    for count, place in zip(range(len(argument.name)), places, strict=False):
                        yield self._modifier(place, path[: len(outer) + count + 1], base)
                    yield from self._modification(argument.modification, (base, path))
                case syntax.ElementRedeclaration():
                    yield from self._redeclared(argument.element, base, outer)
                case syntax.Deselection() if not isinstance(argument.target, str):
                    yield from self._expressions((argument.target,), {})
                case syntax.Deselection():
                    places = (p for p in _names(argument.span) if p.text == argument.target)
                    for place in places:
                        yield self._modifier(place, (*outer, place.text), base)
        if modification.binding is not None:
            yield from self._expressions((modification.binding,), {})

    def _modifier(self, place: Span, path: tuple[str, ...], base: syntax.Ref | None) -> Mention:
        return Mention(Kind.MODIFIER, place.text, place, self._owner, path, base=base)

    def _redeclared(
        self, element: syntax.Declaration, base: syntax.Ref | None, outer: tuple[str, ...]
    ) -> Iterator[Mention]:
        if isinstance(element, syntax.Component):
            yield from self._ref(element.type, {}, True)
            place = _first(element.span, element.name)
            yield self._modifier(place, (*outer, element.name), base)
            yield from self._component(element, redeclared=True)
        else:
            yield self._modifier(element.name_span, (*outer, element.name), base)
            yield from self._class(element, redeclared=True)

    # Expressions, equations and statements

    def _expressions(self, trees: tuple[syntax.Node, ...], local: Locals) -> Iterator[Mention]:
        stack: list[tuple[object, Locals]] = [(t, local) for t in reversed(trees)]
        while stack:
            node, known = stack.pop()
            if isinstance(node, tuple) and not isinstance(node, Span):
                stack += [(part, known) for part in reversed(node)]
                continue
            if not isinstance(node, syntax.Node):
                continue
            if isinstance(node, syntax.Ref):
                yield from self._ref(node, known)
                continue
            if isinstance(node, _LOOPS):
                known = {**known, **{i.name: i for i in node.iterators}}
            elif isinstance(node, syntax.Iterator):
                span = _first(node.span, node.name)
                yield Mention(Kind.ITERATOR, node.name, span, self._owner, declared=node)
            elif isinstance(node, syntax.Call | syntax.PartialApplication):
                for argument in node.named:
                    place = _first(argument.span, argument.name)
                    yield self._modifier(place, (argument.name,), node.function)
            fields = [getattr(node, name) for name in node.__struct_fields__ if name != "span"]
            stack += [(part, known) for part in reversed(fields)]

    def _ref(self, ref: syntax.Ref, local: Locals, is_type: bool = False) -> Iterator[Mention]:
        names = ref.names
        for count, part in enumerate(ref.parts, 1):
            place = _first(part.span, part.name)
            declared = None if ref.absolute else local.get(names[0])
            yield Mention(
                Kind.REFERENCE, part.name, place, self._owner, names[:count],
                ref.absolute, declared=declared, is_type=is_type,
            )  # fmt: skip
            yield from self._expressions(part.subscripts, local)

    def _annotation(self, annotation: syntax.Annotation | None) -> Iterator[Mention]:
        if annotation is None or not self._near(annotation.span):
            return
        if self._word not in annotation.span.text:
            return
        try:
            found = read("annotation_text", annotation.span)
        except PlanarcError:
            return
        yield from self._arguments(found.tree or ())

    def _arguments(self, arguments: tuple[syntax.Argument, ...]) -> Iterator[Mention]:
        for argument in arguments:
            if isinstance(argument, syntax.ElementRedeclaration):
                element = argument.element
                if isinstance(element, syntax.Component):
                    yield from self._ref(element.type, {}, True)
            elif isinstance(argument, syntax.ElementModification) and argument.modification:
                yield from self._arguments(argument.modification.arguments)
                if argument.modification.binding is not None:
                    yield from self._expressions((argument.modification.binding,), {})


def mentions_of(text: Text, word: str = "") -> Iterator[Mention]:
    """All mentions of a text, or those of one name."""
    if word and word not in text.source.text:
        return
    for mention in Walk(text, word=word).mentions():
        if not word or mention.name == word:
            yield mention


def mention_at(text: Text, offset: int) -> Mention | None:
    """The mention at a place of a text, or just before it."""
    found = None
    for mention in Walk(text, offset).mentions():
        if mention.span.start <= offset <= mention.span.end and mention.name:
            if offset < mention.span.end:
                return mention
            found = found or mention
    return found


def _first(span: Span, name: str) -> Span:
    return Span(span.source, span.start, span.start + len(name))


def _names(span: Span, marks: str = '"=(') -> Iterator[Span]:
    """The names in a piece of text, up to the first of some marks; none in comments."""
    for match in _WORD.finditer(span.source.text, span.start, span.end):
        if match["mark"] and match["mark"] in marks:
            return
        if match["name"]:
            yield Span(span.source, match.start(), match.end())
