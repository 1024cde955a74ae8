"""Texts as pieces, some of them numbers that are written when they are shown.

Where a text is chosen, compared or held by a variable it is a number that stands for it
(`runtime.texts`). A Boolean or an enumeration as text is a choice between known texts.

Example:  "at " + String(n)  has the parts "at " and (n, "d"); as a number it is
          the call  planarc_text("at ", TEXT, n, "d")  with numbers for the texts
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.expr import Expr, Exprs
from planarc.lower.scope import Model, Scope, unsupported
from planarc.lower.values import Text, Value, expr
from planarc.runtime import external
from planarc.runtime.texts import TEXT, formatted

MAX_PARTS = 10_000  # of one text
MAX_WIDTH = 10_000  # of a number in it, and of its digits


def number(table: Exprs, value: Value) -> Expr:
    """A scalar as a number, which stands for it if it is a text."""
    if not isinstance(value, Text):
        return expr(value)
    if value.constant is not None:
        return table.text(value.constant)
    first = value.parts[0]
    if len(value.parts) == 1 and isinstance(first, tuple) and first[1] == TEXT:
        return first[0]
    pairs = ((table.text(p), TEXT) if isinstance(p, str) else p for p in value.parts)
    given = tuple(e for value, form in pairs for e in (value, table.text(form)))
    return table.apply(external.JOINED, given)


def number_held(scope: Scope, value: Value, span: Span) -> Expr:
    """The number that a variable takes here; one of texts changes at events only."""
    if not isinstance(value, Text):
        return expr(value)
    found = number(scope.table, value)
    if scope.at_event or scope.model.is_steady(found):
        return found
    message = "a String variable cannot follow a value that changes between events"
    hint = "set it in a `when`, or make the text where it is shown"
    raise error("L343", message, span, hint=hint)


def decided(model: Model, text: Text) -> Text:
    """A text with the numbers that parameters alone give, which become structural."""
    parts: list[str | tuple[Expr, str]] = []
    for part in text.parts:
        e = None if isinstance(part, str) else model.decided(part[0])
        parts.append(part if e is None or not e.is_const else formatted(e.data, part[1]))
    return Text(tuple(parts))


def held(e: Expr) -> Text:
    """The text that a number stands for."""
    return Text(((e, TEXT),))


def choice(table: Exprs, condition: Expr, then: Text, otherwise: Text) -> Text:
    if then == otherwise:
        return then
    return held(table.if_(condition, number(table, then), number(table, otherwise)))


def binary(table: Exprs, op: str, a: Text, b: Text, span: Span) -> Value:
    """Two texts side by side, or compared."""
    if op in ("+", ".+"):
        if len(a.parts) + len(b.parts) > MAX_PARTS:
            raise error("L315", "a text of so many parts is not supported", span)
        return Text(a.parts + b.parts)
    left, right = a.constant, b.constant
    if op in ("==", "<>"):
        same = table.equal(number(table, a), number(table, b))
        return same if op == "==" else table.not_(same)
    if left is None or right is None:
        raise error("L305", f"texts that change while running cannot be compared by `{op}`", span)
    truth = {"<": left < right, "<=": left <= right, ">": left > right, ">=": left >= right}
    return table.const(truth[op])


def written(
    model: Model, value: Value, options: Sequence[Value], type_: flat.Type, span: Span
) -> Text:
    """`String(value, ...)`: with a format, or with digits, a minimum length and the side."""
    if isinstance(value, Text):
        return value
    table, e = model.table, expr(value)
    if type_.base is flat.Base.BOOLEAN:
        names: tuple[str, ...] = ("false", "true")
        e = table.if_(e, table.const(2), table.one)
    else:
        names = type_.literals
    width, form = _layout(model, options, type_, span)
    if not names:
        return Text((formatted(e.data, form) if e.is_const else (e, form),))
    texts = [Text((f"{name:{width}}",)) for name in names]
    if e.is_const:
        return texts[int(e.data) - 1]
    found = texts[-1]
    for place in range(len(texts) - 1, 0, -1):
        found = choice(table, table.equal(e, table.const(place)), texts[place - 1], found)
    return found


def _layout(
    model: Model, options: Sequence[Value], type_: flat.Type, span: Span
) -> tuple[str, str]:
    """How a word is put into its width, and the format of a number."""
    kind = "d" if type_.base is flat.Base.INTEGER else ""
    if not options:
        return "", kind
    if isinstance(options[0], Text):
        form = decided(model, options[0]).constant
        if form is None:
            raise unsupported("a format that changes while running", span)
        _refuse_width(map(int, re.findall(r"\d+", form)), span)
        return "", form
    given = [model.number(expr(o)) for o in options]
    if not all(o.is_const for o in given):
        raise unsupported("a number of digits that changes while running", span)
    digits, length, left = (int(o.data) for o in given)
    _refuse_width((digits, length), span)
    sign, width = "-" if left else "", str(max(length, 0) or "")
    form = f"{sign}{width}{kind or f'.{max(digits, 0)}g'}"
    return f"{'<' if left else '>'}{width}", form


def _refuse_width(numbers: Iterable[int], span: Span) -> None:
    if max(numbers, default=0) > MAX_WIDTH:
        raise error("L315", f"a number in a text has at most {MAX_WIDTH} characters", span)
