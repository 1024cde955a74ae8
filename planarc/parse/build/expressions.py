"""Expressions, references and comments: from the grammar's rules to `ir.syntax`.

Each method is called with the children of the rule of its name, all tokens
included (`grammar/modelica.lark`).
"""

from __future__ import annotations

import math
import re
from typing import Any

from planarc.ir import syntax
from planarc.parse.build.parts import (
    Builder,
    Description,
    Part,
    cover,
    made,
    nodes,
    part,
    separated,
)
from planarc.parse.grammar.lexer import Token

#: Digits of an integer, far beyond what any machine integer holds.
_MAX_DIGITS = 300
#: Operators in a row in one expression, which is the depth of its tree.
MAX_OPERATORS = 1000
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
#: 2.4.4
_ESCAPES = {
    "'": "'",
    '"': '"',
    "?": "?",
    "\\": "\\",
    "a": "\a",
    "b": "\b",
    "f": "\f",
    "n": "\n",
    "r": "\r",
    "t": "\t",
    "v": "\v",
}


class Expressions(Builder):
    def integer(self, c: list[Token]) -> syntax.Integer:
        token = c[0]
        if len(token.text) > _MAX_DIGITS:
            self.refuse("P108", "this integer has too many digits", token.span)
            return syntax.Integer(token.span, 0)
        return syntax.Integer(token.span, int(token.text))

    def real(self, c: list[Token]) -> syntax.Real:
        token = c[0]
        value = float(token.text)
        if math.isinf(value):
            self.refuse("P108", "this number is larger than any Real", token.span)
        return syntax.Real(token.span, value, token.text)

    def string(self, c: list[Token]) -> syntax.String:
        return syntax.String(c[0].span, self.text_of(c[0]))

    def text_of(self, token: Token) -> str:
        """The value of a string token, escapes resolved."""
        body = token.text[1:-1]
        if "\\" not in body:
            return body
        for found in _ESCAPE.finditer(body):
            if found[1] not in _ESCAPES:
                start = token.span.start + 1 + found.start()
                span = token.span._replace(start=start, end=start + 2)
                self.refuse("P109", f"`{found[0]}` is no escape sequence", span, "write `\\\\`")
        return _ESCAPE.sub(lambda found: _ESCAPES.get(found[1], found[0]), body)

    boolean = made(syntax.Boolean, lambda c: (c[0].text == "true",))
    end = made(syntax.End, lambda c: ())
    colon = made(syntax.Colon, lambda c: ())

    # Operators

    def unary(self, c: list[Any]) -> syntax.Unary:
        op, operand = c
        return syntax.Unary(op.span.to(operand.span), op.text, operand)

    def binary(self, c: list[Any]) -> syntax.Binary:
        left, op, right = c
        node = syntax.Binary(left.span.to(right.span), op.text, left, right)
        # The nodes of a text live until its parse ends, so that an id means one of them.
        length = self.chains.get(id(left), 0) + 1
        self.chains[id(node)] = length
        if length == MAX_OPERATORS:
            message = f"this has more than {MAX_OPERATORS} operators in a row"
            hint = "write `sum({...})`, or give parts of it a name of their own"
            self.refuse("P106", message, left.span, hint)
        return node

    if_expression = made(
        syntax.If, lambda c: (tuple((c[i], c[i + 2]) for i in range(1, len(c) - 2, 4)), c[-1])
    )
    range = made(syntax.Range, lambda c: (c[0], c[2] if len(c) == 5 else None, c[-1]))

    # Parentheses and brackets

    def parentheses(self, c: list[Any]) -> syntax.Expression:
        """`(a)` is `a` itself; `(a, , b)` is a tuple."""
        items = separated(c[1:-1])
        if len(items) > 1:
            return syntax.Tuple(cover(c), tuple(items))
        if items[0] is None:
            self.refuse("P101", "expected an expression between `(` and `)`", c[-1].span)
            return syntax.Tuple(cover(c), ())
        inner: syntax.Expression = items[0]
        return inner

    def index(self, c: list[Any]) -> syntax.Index:
        return syntax.Index(cover(c), self.parentheses(c[:-1]), c[-1].value)

    def member(self, c: list[Any]) -> syntax.Member:
        return syntax.Member(cover(c), self.parentheses(c[:-2]), c[-1].text)

    matrix = made(syntax.Matrix, lambda c: (tuple(row.value for row in c[1::2]),))

    def array(self, c: list[Any]) -> syntax.Array:
        inner = c[1]
        if inner is None:
            self.refuse("P101", "expected an expression: an array has at least one entry", cover(c))
        items = inner.value if isinstance(inner, Part) else (inner,) if inner else ()
        return syntax.Array(cover(c), items)

    expressions = part(lambda c: tuple(c[::2]))
    comprehension = made(syntax.Comprehension, lambda c: (c[0], tuple(c[2::2])))
    iterator = made(syntax.Iterator, lambda c: (c[0].text, c[2] if len(c) == 3 else None))

    # Calls

    def call(self, c: list[Any]) -> syntax.Call:
        function, arguments = c
        if isinstance(function, Token):  # `der`, `initial`, `pure`
            part = syntax.RefPart(function.span, function.text)
            function = syntax.Ref(function.span, (part,))
        return syntax.Call(function.span.to(arguments.span), function, *arguments.value)

    def call_arguments(self, c: list[Any]) -> Part:
        """Positional and named arguments."""
        items = nodes(c)
        named = tuple(i for i in items if isinstance(i, syntax.NamedArgument))
        positional = tuple(i for i in items if not isinstance(i, syntax.NamedArgument))
        if named and positional and positional[-1] is items[-1]:
            message = "a positional argument cannot follow a named one"
            self.refuse("P107", message, positional[-1].span)
        return Part((positional, named), cover(c))

    named_argument = made(syntax.NamedArgument, lambda c: (c[0].text, c[2]))
    partial_application = made(syntax.PartialApplication, lambda c: (c[1], nodes(c[2:])))

    # Names

    subscripts = part(nodes)

    def name(self, c: list[Token]) -> Part:
        """The words of a dotted name, each where it stands."""
        return Part(c[::2], c[0].span.to(c[-1].span))

    def type_specifier(self, c: list[Any]) -> syntax.Ref:
        name = c[-1]
        parts = tuple(syntax.RefPart(word.span, word.text) for word in name.value)
        return syntax.Ref(cover(c), parts, len(c) == 2)

    def component_reference(self, c: list[Any]) -> syntax.Ref:
        absolute = isinstance(c[0], Token)
        return syntax.Ref(c[0].span.to(c[-1].span), tuple(c[absolute::2]), absolute)

    def reference_part(self, c: list[Any]) -> syntax.RefPart:
        name, subscripts = c
        if subscripts is None:
            return syntax.RefPart(name.span, name.text)
        return syntax.RefPart(name.span.to(subscripts.span), name.text, subscripts.value)

    # Comments

    def description(self, c: list[Any]) -> Description:
        comment, annotation = c
        if comment is None and annotation is None:
            return _NO_DESCRIPTION
        return Description(comment or "", self.annotation(annotation))

    def description_string(self, c: list[Token]) -> str:
        return "".join(self.text_of(token) for token in c[::2])

    def annotation(self, token: Token | None) -> syntax.Annotation | None:
        return None if token is None else syntax.Annotation(token.span)


_NO_DESCRIPTION = Description()
