"""Modifications and redeclarations: from the grammar's rules to `ir.syntax` (7.2, 7.3)."""

from __future__ import annotations

from typing import Any

from planarc.ir import syntax
from planarc.parse.build.parts import Builder, Description, Part, cover, made, nodes, part, texts
from planarc.parse.grammar.lexer import Token

_ARGUMENT_ORDER = (("redeclare",), ("each",), ("final",), ("replaceable",))
_TYPE_ORDER = (("flow", "stream"), ("discrete", "parameter", "constant"), ("input", "output"))
_TYPE_WORDS = (syntax.Flow, syntax.Variability, syntax.Causality)
#: No constraining clause, and the comment that one would bring.
NO_CLAUSE: tuple[syntax.Constraint | None, Description] = (None, Description())


class Modifications(Builder):
    # Modifications

    modification_arguments = made(syntax.Modification, lambda c: (c[0].value,))

    def modification_both(self, c: list[Any]) -> syntax.Modification:
        return self._with_binding(c, c[0].value)

    def modification_value(self, c: list[Any]) -> syntax.Modification:
        return self._with_binding(c, ())

    def _with_binding(self, c: list[Any], arguments: Any) -> syntax.Modification:
        value = c[-1]
        if isinstance(value, Token):  # `= break`
            return syntax.Modification(cover(c), arguments, broken=True)
        return syntax.Modification(cover(c), arguments, value)

    def class_modification(self, c: list[Any]) -> Part:
        return Part(nodes(c), c[0].span.to(c[-1].span))

    inheritance_modification = class_modification

    deselection = made(
        syntax.Deselection, lambda c: (c[1].text if isinstance(c[1], Token) else c[1],)
    )

    # Arguments

    def argument_prefixes(self, c: list[Token]) -> Part:
        self.check_order(c, _ARGUMENT_ORDER)
        return Part(frozenset(token.text for token in c), cover(c))

    def element_modification(self, c: list[Any]) -> syntax.ElementModification:
        prefixes, name, modification, comment = c
        words = prefixes.value if prefixes else frozenset()
        for word in ("redeclare", "replaceable"):
            if word in words:
                message = f"expected a declaration after `{word}`, not a modification"
                self.refuse("P101", message, name.span, f"write `{word} Type name`")
        return syntax.ElementModification(
            cover(c), texts(name), modification, "each" in words, "final" in words, comment or ""
        )

    def redeclared_class(self, c: list[Any]) -> syntax.ElementRedeclaration:
        prefixes, partial, kind, short, clause = c
        constraint, extra = clause or NO_CLAUSE
        kind_value, pure = kind.value
        element = syntax.ClassDef(
            kind.span.to(short.span),
            short.name.text,
            kind_value,
            short.body,
            short.name.span,
            partial=partial is not None,
            pure=pure,
            prefixes=_prefixes(prefixes.value),
            constraint=constraint,
            comment=short.description.comment or extra.comment,
            annotation=short.description.annotation or extra.annotation,
        )
        return self._redeclaration(prefixes, element)

    def redeclared_component(self, c: list[Any]) -> syntax.ElementRedeclaration:
        prefixes, type_prefix, type_name, declared, clause = c
        constraint, extra = clause or NO_CLAUSE
        name, dimensions, modification, description = declared.value
        element = syntax.Component(
            declared.span,
            name.text,
            type_name,
            dimensions=dimensions,
            modification=modification,
            prefixes=_prefixes(prefixes.value),
            constraint=constraint,
            comment=description.comment or extra.comment,
            annotation=description.annotation or extra.annotation,
            **(type_prefix.value if type_prefix else {}),
        )
        return self._redeclaration(prefixes, element)

    def _redeclaration(
        self, prefixes: Part, element: syntax.Declaration
    ) -> syntax.ElementRedeclaration:
        words = prefixes.value
        if not words & {"redeclare", "replaceable"}:
            hint = "write `redeclare` in front of it"
            self.refuse("P107", "a declaration here must redeclare", prefixes.span, hint)
        self.check_constraint(element.constraint, "replaceable" in words)
        said = (word in words for word in ("redeclare", "each", "final"))
        return syntax.ElementRedeclaration(prefixes.span.to(element.span), element, *said)

    def check_constraint(self, constraint: syntax.Constraint | None, replaceable: bool) -> None:
        if constraint and not replaceable:
            hint = "write `replaceable` in front of the declaration"
            message = "only what is replaceable has a constraint"
            self.refuse("P107", message, constraint.span, hint)

    redeclared_name = part(lambda c: (c[0], c[1].value if c[1] else (), c[2], c[3]))

    def constraining_clause(self, c: list[Any]) -> tuple[syntax.Constraint, Description]:
        _, base, arguments, description = c
        return syntax.Constraint(cover(c), base, modification_of(arguments)), description

    def type_prefix(self, c: list[Token]) -> Part:
        """`flow`, `parameter`, `input` ... as arguments of `Component` and `ShortClass`."""
        self.check_order(c, _TYPE_ORDER)
        words: dict[str, Any] = {}
        for token in c:
            kind = next(k for k in _TYPE_WORDS if token.text in {m.value for m in k})
            words[kind.__name__.lower()] = kind(token.text)
        return Part(words, cover(c))

    base_prefix = type_prefix


def modification_of(arguments: Part | None) -> syntax.Modification | None:
    return syntax.Modification(arguments.span, arguments.value) if arguments else None


def _prefixes(words: frozenset[str]) -> syntax.Prefixes:
    return syntax.Prefixes(**{word: True for word in words if word != "each"})
