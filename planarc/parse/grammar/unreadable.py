"""Characters with which no token begins, in words, and where reading goes on."""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Once
from planarc.core.mend import Write
from planarc.core.source import Source, Span

#: Characters that other languages or word processors have, and what is meant.
_MEANT = {
    "&": "and",
    "~": "not",
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{MULTIPLICATION SIGN}": "*",
    "\N{DOT OPERATOR}": "*",
    "\N{MIDDLE DOT}": "*",
    "\N{DIVISION SIGN}": "/",
    "\N{SUPERSCRIPT TWO}": "^2",
    "\N{SUPERSCRIPT THREE}": "^3",
    "\N{LESS-THAN OR EQUAL TO}": "<=",
    "\N{GREATER-THAN OR EQUAL TO}": ">=",
    "\N{NOT EQUAL TO}": "<>",
    "\N{GREEK SMALL LETTER PI}": "Modelica.Constants.pi",
}
#: What is to be said of others.
_HINTS = {
    "?": "write `if condition then a else b` for `condition ? a : b`",
    "!": "write `<>` for not equal, `not` for the opposite",
    "|": "write `or`, and `abs(x)` for a size",
    "%": "write `mod(a, b)` for a remainder, `//` for a comment",
    "#": "write `//` for a comment",
    "@": "write `*`, which multiplies matrices, too",
    "\N{DEGREE SIGN}": "angles are in radian: write `Modelica.Units.Conversions.from_deg(...)`",
}
#: Characters that begin comments in other languages.
_COMMENTS = frozenset("%#")
#: The quotes of word processors.
_QUOTES = frozenset("\u201c\u201d\u201e\u201f\u2018\u2019\u201a\u00ab\u00bb\u2033")
#: What is never closed: the length of what opens it, and what closes it.
_CLOSED_BY = {"comment": (2, "*/"), "string": (1, '"'), "quoted name": (1, "'")}


class Unclosed(Diagnostic):
    """A comment, a string or an annotation without its end."""


def never_closed(what: str, span: Span) -> Diagnostic:
    length, mark = _CLOSED_BY[what]
    opening = span._replace(end=min(span.end, span.start + length))
    hint = f"write `{mark}` where it ends"
    return Unclosed("P103", f"this {what} is never closed", opening, hint=hint)


def skip_illegal(source: Source, at: int, stop: int, errors: list[Diagnostic]) -> int:
    """Report characters with which no token begins; gives the place where reading goes on."""
    text = source.text
    character = text[at]
    if character == '"':
        errors.append(never_closed("string", Span(source, at, at + 1)))
        line_end = text.find("\n", at, stop)
        return stop if line_end < 0 else line_end
    if character == "'":
        quote = never_closed("quoted name", Span(source, at, at + 1))
        if at and (text[at - 1].isalnum() or text[at - 1] in ")]}"):
            hint = "write `der(x)` for a derivative, `transpose(x)` for a transpose"
            quote = replace(quote, hint=hint)
        errors.append(quote)
        return at + 1
    return _report_character(source, at, stop, errors)


def _report_character(source: Source, at: int, stop: int, errors: list[Diagnostic]) -> int:
    text = source.text
    character = text[at]
    begin, end = at, at + 1
    meant = _MEANT.get(character)
    hint = f"write `{meant}`" if meant else _HINTS.get(character)
    if character.isalpha():
        begin, end = _word_around(text, at, stop)
        hint = hint or "put names with other letters than a to z in single quotes"
        message = f"`{text[begin:end][:40]}` is no name: it holds `{character}`"
    else:
        while end < stop and text[end] == character:
            end += 1
        shown = character if character.isprintable() else f"U+{ord(character):04X}"
        message = f"the character `{shown}` has no meaning here"
        if character in _QUOTES:
            message, hint = "curved quotes have no meaning here", 'write straight quotes: `"`'
            quotes = Once("P104", message, Span(source, begin, end), hint=hint, kind="quotes")
            errors.append(quotes)
            return end
    mend = Write(meant) if meant and {*text[begin:end]} == {character} else None
    found = Diagnostic("P104", message, Span(source, begin, end), hint=hint, mend=mend)
    if character.isalpha():
        found = Once("P104", message, found.span, hint=hint, mend=mend, kind=text[begin:end])
    bars = Once("P104", message, found.span, hint=hint, kind="bars")  # two of them are one size
    errors.append(bars if character == "|" else found)
    line_end = text.find("\n", at, stop)
    behind = text[end : stop if line_end < 0 else line_end]
    if character in _COMMENTS and ";" not in behind:  # the rest is a comment
        return end + len(behind)
    return end


def _word_around(text: str, at: int, stop: int) -> tuple[int, int]:
    begin = end = at
    while begin > 0 and (text[begin - 1].isalnum() or text[begin - 1] == "_"):
        begin -= 1
    while end < stop and (text[end].isalnum() or text[end] == "_"):
        end += 1
    return begin, end
