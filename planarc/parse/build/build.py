"""Classes and their elements: from the grammar's rules to `ir.syntax` (chapters 4, 5, 7, 13)."""

from __future__ import annotations

from typing import Any

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.mend import Write
from planarc.core.source import Span
from planarc.ir import syntax
from planarc.parse.build.equations import Equations
from planarc.parse.build.expressions import Expressions
from planarc.parse.build.modifications import NO_CLAUSE, Modifications, modification_of
from planarc.parse.build.parts import Description, Part, cover, made, nodes, part, texts
from planarc.parse.grammar.lexer import Token

_ELEMENT_ORDER = (("redeclare",), ("final",), ("inner",), ("outer",), ("replaceable",))
_NO_PREFIXES = syntax.Prefixes()


class WrongEnd(Diagnostic):
    """`end B` of a class `A`."""


class Specifier(Data):
    """The part of a class that follows its kind and its name."""

    name: Token
    body: syntax.ClassBody
    description: Description
    span: Span


class Build(Expressions, Modifications, Equations):
    """One method for each rule of the grammar; `errors` holds what the grammar lets pass."""

    # Files

    def stored_definition(self, c: list[Any]) -> syntax.StoredDefinition:
        classes: list[syntax.ClassDef] = []
        final = False
        for child in c:
            if isinstance(child, syntax.ClassDef):
                prefixes = syntax.Prefixes(final=True) if final else child.prefixes
                classes.append(replace(child, prefixes=prefixes))
            final = isinstance(child, Token) and child.type == "FINAL"
        return syntax.StoredDefinition(self.whole, tuple(classes), c[0].value if c[0] else None)

    def expression_text(self, c: list[Any]) -> Any:
        return c[0]

    def annotation_text(self, c: list[Any]) -> Any:
        return c[0].value

    within = part(lambda c: texts(c[1]) if c[1] else ())

    # Classes

    def class_definition(self, c: list[Any]) -> syntax.ClassDef:
        encapsulated, partial, kind, specifier = c
        kind_value, pure = kind.value
        return syntax.ClassDef(
            cover(c),
            specifier.name.text,
            kind_value,
            specifier.body,
            specifier.name.span,
            partial=partial is not None,
            encapsulated=encapsulated is not None,
            pure=pure,
            comment=specifier.description.comment,
            annotation=specifier.description.annotation,
        )

    def class_kind(self, c: list[Token]) -> Part:
        words = [token.text for token in c]
        pure = {"pure": True, "impure": False}.get(words[0])
        return Part((syntax.ClassKind(" ".join(words[pure is not None :])), pure), cover(c))

    def long_class(self, c: list[Any]) -> Specifier:
        name, comment, inside, _, end = c
        self._check_end(name, end)
        composition, annotation = self._composition(inside, name.span.to(end.span))
        return Specifier(name, composition, Description(comment or "", annotation), cover(c))

    def extends_class(self, c: list[Any]) -> Specifier:
        _, name, arguments, comment, inside, _, end = c
        self._check_end(name, end)
        span = cover(c)
        composition, annotation = self._composition(inside, name.span.to(end.span))
        body = syntax.ExtendsClass(span, composition, modification_of(arguments))
        return Specifier(name, body, Description(comment or "", annotation), span)

    def _check_end(self, name: Token, end: Token) -> None:
        if name.text != end.text:
            message = f"`end {end.text}` does not match `{name.text}`"
            hint, mend = f"write `end {name.text}`", Write(name.text)
            opened = (Related(f"`{name.text}` begins here", name.span),)
            self.errors.append(
                WrongEnd("P102", message, end.span, hint=hint, related=opened, mend=mend)
            )

    def short_class(self, c: list[Any]) -> Specifier:
        name, _, prefix, base, subscripts, arguments, description = c
        words = prefix.value if prefix else {}
        body = syntax.ShortClass(
            cover(c[2:]),
            base,
            subscripts.value if subscripts else (),
            modification_of(arguments),
            **words,
        )
        return Specifier(name, body, description, cover(c))

    def enumeration_class(self, c: list[Any]) -> Specifier:
        literals = nodes(c[4:-1])
        every = any(isinstance(child, Token) and child.type == "COLON" for child in c)
        body = syntax.Enumeration(cover(c[2:]), None if every else literals)
        return Specifier(c[0], body, c[-1], cover(c))

    def enumeration_literal(self, c: list[Any]) -> syntax.EnumerationLiteral:
        return syntax.EnumerationLiteral(c[0].span, c[0].text, c[1].comment)

    def derivative_class(self, c: list[Any]) -> Specifier:
        body = syntax.DerivativeClass(cover(c[2:]), c[4], tuple(t.text for t in c[6:-1:2]))
        return Specifier(c[0], body, c[-1], cover(c))

    # What a class holds

    def composition(self, c: list[Any]) -> list[Any]:
        return c

    def _composition(
        self, c: list[Any], span: Span
    ) -> tuple[syntax.Composition, syntax.Annotation | None]:
        elements: list[syntax.Element] = []
        sections: list[syntax.EquationSection | syntax.AlgorithmSection] = []
        annotations: list[Token] = []
        external: syntax.External | None = None
        protected = False
        for child in c:
            if isinstance(child, Token):
                if child.type == "ANNOTATION":
                    annotations.append(child)
                elif child.type in ("PUBLIC", "PROTECTED"):
                    protected = child.type == "PROTECTED"
            elif isinstance(child, syntax.External):
                if external is not None:
                    self.refuse("P107", "a function has one `external` clause", child.span)
                external = child
            elif isinstance(child, Part):  # sections, and component clauses
                if isinstance(child.value[0], syntax.Component):
                    elements += map(_protect, child.value) if protected else child.value
                else:
                    sections.append(child.value[0])
                    annotations += child.value[1]
            else:
                elements.append(_protect(child) if protected else child)
        for second in annotations[1:]:
            self.refuse("P107", "a class has one annotation, this is another one", second.span)
        composition = syntax.Composition(span, tuple(elements), tuple(sections), external)
        return composition, self.annotation(annotations[0] if annotations else None)

    def external(self, c: list[Any]) -> syntax.External:
        _, language, call, annotation = c
        result, function, arguments = call.value if call else (None, None, ())
        return syntax.External(
            cover(c),
            self.text_of(language) if language else None,
            result,
            function,
            arguments,
            self.annotation(annotation),
        )

    def external_call(self, c: list[Any]) -> Part:
        result = c[0] if isinstance(c[0], syntax.Ref) else None
        arguments = c[-2].value if c[-2] else ()
        return Part((result, c[-4].text, arguments), cover(c))

    # Elements

    import_as = made(syntax.Import, lambda c: (texts(c[3]), c[1].text))
    import_class = made(syntax.Import, lambda c: (_dotted(c[1:-1]),))
    import_all = made(syntax.Import, lambda c: (_dotted(c[1:-2]), None, True))

    def import_some(self, c: list[Any]) -> syntax.Import:
        brace = next(i for i, child in enumerate(c) if child.type == "LBRACE")
        return syntax.Import(cover(c), _dotted(c[1:brace]), names=_dotted(c[brace:-1]))

    def extends_clause(self, c: list[Any]) -> syntax.Extends:
        _, base, arguments, annotation = c
        return syntax.Extends(
            cover(c[:3]), base, modification_of(arguments), annotation=self.annotation(annotation)
        )

    def element_prefixes(self, c: list[Token]) -> syntax.Prefixes:
        self.check_order(c, _ELEMENT_ORDER)
        return syntax.Prefixes(**{token.text: True for token in c})

    def class_element(self, c: list[Any]) -> Any:
        prefixes, definition, clause = c
        if prefixes is None and clause is None:
            return definition
        constraint, description = clause or NO_CLAUSE
        prefixes = prefixes or _NO_PREFIXES
        self.check_constraint(constraint, prefixes.replaceable)
        return replace(
            definition,
            prefixes=prefixes,
            constraint=constraint,
            comment=definition.comment or description.comment,
            annotation=definition.annotation or description.annotation,
        )

    def component_element(self, c: list[Any]) -> Part:
        prefixes, type_prefix, type_name, subscripts, *declared, clause = c
        constraint, extra = clause or NO_CLAUSE
        prefixes = prefixes or _NO_PREFIXES
        self.check_constraint(constraint, prefixes.replaceable)
        words = type_prefix.value if type_prefix else {}
        dimensions = subscripts.value if subscripts else ()
        components = []
        for name, own, modification, condition, description in declared[::2]:
            span = cover(x for x in (name, own, modification) if x)
            components.append(
                syntax.Component(
                    span,
                    name.text,
                    type_name,
                    dimensions,
                    own.value if own else (),
                    modification,
                    condition,
                    prefixes=prefixes,
                    constraint=constraint,
                    comment=description.comment or extra.comment,
                    annotation=description.annotation or extra.annotation,
                    **words,
                )
            )
        return Part(tuple(components), type_name.span)

    def component(self, c: list[Any]) -> list[Any]:
        return c

    def condition(self, c: list[Any]) -> Any:
        return c[1]


def _dotted(c: list[Any]) -> tuple[str, ...]:
    return tuple(token.text for token in c if token.type == "IDENT")


def _protect(element: Any) -> Any:
    if isinstance(element, syntax.Import):
        return element
    if isinstance(element, syntax.Extends):
        return replace(element, protected=True)
    return replace(element, prefixes=replace(element.prefixes, protected=True))
