"""Syntax errors in words: what was expected, what stands there, what to do.

In:   Trouble, Repair   where the automaton stopped, and what would mend it
Out:  Diagnostic        the message for the one who wrote the text

The file is long because slips are many; each is told by one short function, the first that fits.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Once, Related
from planarc.core.mend import Insert, Meant, Write
from planarc.core.nearest import nearest
from planarc.core.source import Span
from planarc.parse.grammar.lexer import Token
from planarc.parse.repair.arguments import explain_arguments
from planarc.parse.repair.expected import expected
from planarc.parse.repair.habits import NUMBERS, OTHER_LANGUAGES, unit_hint
from planarc.parse.repair.quotes import explain_unquoted
from planarc.parse.repair.sections import explain_initial, explain_section
from planarc.parse.repair.trouble import (
    BLOCKS,
    ELSE_IF_ENDED,
    Repair,
    StrayEnd,
    Trouble,
    WrongSection,
    instead,
    shown,
)

_OPERATORS = frozenset({"PLUS", "SIGN", "TIMES", "EACH_TIMES", "POWER", "RELATION"})
_BRACKETS = {"RPAR": ("(", ")"), "RSQB": ("[", "]"), "RBRACE": ("{", "}")}

#: The names of rules that have ended, in words.
_ENDED = {
    "equality": "the equation",
    "call_equation": "the equation",
    "connect_equation": "`connect(...)`",
    "if_equation": "`end if`",
    "if_statement": "`end if`",
    "for_equation": "`end for`",
    "for_statement": "`end for`",
    "when_equation": "`end when`",
    "when_statement": "`end when`",
    "while_statement": "`end while`",
    "assignment": "the statement",
    "tuple_assignment": "the statement",
    "call_statement": "the statement",
    "break_statement": "`break`",
    "return_statement": "`return`",
    "component_element": "the declaration",
    "class_element": "the class",
    "class_definition": "the class",
    "extends_clause": "the `extends` clause",
    "import_as": "the import",
    "import_all": "the import",
    "import_some": "the import",
    "import_class": "the import",
    "external": "the `external` clause",
}


def explain(trouble: Trouble, repair: Repair | None) -> Diagnostic:
    """The diagnostic of the first explanation that knows the case."""
    for explanation in _EXPLANATIONS:
        diagnostic = explanation(trouble, repair)
        if diagnostic is not None:
            break
    else:
        diagnostic = expected(trouble)
    known = diagnostic.hint or diagnostic.mend == Insert(";")
    return diagnostic if known else _with_keyword(diagnostic, trouble)


# Cases that have a name ----------------------------------------------------------------


def _operators_in_a_row(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    token, previous = trouble.token, trouble.previous
    if token.type not in ("PLUS", "SIGN") or not previous or previous.type not in _OPERATORS:
        return None
    hint = f"put the sign and its operand in parentheses: `{previous.text} ({token.text}...)`"
    message = f"`{token.text}` cannot follow `{previous.text}`"
    return Diagnostic("P101", message, token.span, hint=hint)


def _chained(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain relations and powers in a row: they have no associativity (3.2)."""
    token = trouble.token
    if token.type not in ("POWER", "RELATION") or token.type not in trouble.open_symbols:
        return None
    first = next((t for t in trouble.tokens[trouble.begin : trouble.at] if t.text == "=="), None)
    if first is not None and trouble.open_bracket is None and not trouble.inside("IF"):
        message = "`==` compares, it makes no equation"
        return instead(message, first.span, "=", "P111")
    message, hint = "comparisons cannot be chained", "compare two at a time: `a < b and b < c`"
    if token.type == "POWER":
        message = f"`{token.text}` cannot be chained"
        hint = "say which comes first: `(a^b)^c` or `a^(b^c)`"
    return Diagnostic("P101", message, token.span, hint=hint)


def _text_in_single_quotes(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain a description in single quotes, behind a class's name or where no name fits."""
    before = trouble.tokens[max(trouble.begin - 2, 0) : trouble.at]
    named = (c for a, b, c in zip(before, before[1:], before[2:], strict=False) if _heads(a, b))
    for token in (trouble.token, *named):
        if token.type == "IDENT" and " " in token.text:
            message = f"{shown(token)} is a name: texts stand in double quotes"
            return instead(message, token.span, f'"{token.text[1:-1]}"')
    return None


def _heads(word: Token, name: Token) -> bool:
    return word.type in _KINDS and name.type == "IDENT"


_KINDS = frozenset(("MODEL", "BLOCK", "CLASS", "PACKAGE", "CONNECTOR", "RECORD", "FUNCTION"))


def _modifier_in_braces(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `bar{m=1}`."""
    previous = trouble.previous
    if trouble.token.type != "LBRACE" or previous is None or previous.type != "IDENT":
        return None
    message = f"the values of `{previous.text}` stand in `(...)`, not in `{{...}}`"
    return Diagnostic("P101", message, trouble.token.span, hint=f"write `{previous.text}(...)`")


def _open_brace(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `r={1, 0, m=2`, of which `repairs` knows where the brace belongs."""
    opened = trouble.open_bracket
    if not repair or repair.inserted != ("RBRACE",) or repair.at == trouble.at or not opened:
        return None
    before = trouble.tokens[repair.at]
    related = (Related("`{` opens here", opened.span),)
    message = f"expected `}}` before `, {trouble.tokens[trouble.at - 1].text} = ...`"
    return Diagnostic("P103", message, before.span, related=related, mend=Insert("}"))


def _wrong_section(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if not repair or repair.inserted not in _SECTIONS:
        return None
    message, hint = _SECTIONS[repair.inserted]
    span = trouble.tokens[trouble.begin].span.to(trouble.token.span)
    return WrongSection("P113", message, span, hint=hint)


_SECTIONS = {
    ("EQUATION",): ("an equation cannot stand among declarations", "write `equation` above it"),
    ("ALGORITHM",): ("a statement cannot stand among declarations", "write `algorithm` above it"),
    ("PUBLIC",): (
        "a declaration cannot stand here",
        "move it above `equation` or `algorithm`, or write `public` or `protected` above it",
    ),
}


def _equal_signs(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if not repair or repair.dropped != 1:
        return None
    pair = (trouble.token.type, *repair.inserted)
    if pair not in _SIGNS:
        return None
    message, meant = _SIGNS[pair]
    if pair == ("ASSIGN", "EQUAL"):
        what = "an equation" if trouble.in_equations else "a value"
        kind = f"{what} {trouble.opened_index}"  # who writes one so writes all of a section so
        hint, mend, message = f"write `{meant}`", Write(meant), f"{what} {message}"
        if (name := _counted(trouble)) is not None:
            kind = "count"
            hint = f"write `{name} = ...` in a `when`, with `pre({name})` for the value before"
            return Once("P111", message, trouble.token.span, hint=hint, kind=kind)
        return Once("P111", message, trouble.token.span, hint=hint, mend=mend, kind=kind)
    return instead(message, trouble.token.span, meant, "P111")


def _counted(trouble: Trouble) -> str | None:
    """The variable that counts on from its own value, as `n` of `n := n + 1`."""
    name, behind = trouble.previous, trouble.tokens[trouble.at + 1 : trouble.at + 3]
    if name is None or name.type != "IDENT" or trouble.at - trouble.begin != 1:
        return None
    counts = [t.type for t in behind] == ["IDENT", "PLUS"] and behind[0].text == name.text
    return name.text if counts else None


#: One sign for another: the one written and the one meant.
_SIGNS: dict[tuple[str, ...], tuple[str, str]] = {
    ("ASSIGN", "EQUAL"): ("is written with `=`; `:=` assigns, in algorithms only", "="),
    ("EQUAL", "ASSIGN"): ("a statement assigns with `:=`; `=` is for equations", ":="),
    ("EQUAL", "IN"): ("an iterator takes its values with `in`", "in"),
    ("EQUAL", "RELATION"): ("`=` does not compare", "=="),
}


def _separator(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if not repair or repair.inserted != ("COMMA",) or repair.dropped != 1:
        return None
    opened = trouble.open_bracket
    if opened is not None and opened.type == "LBRACE":
        message = "`;` cannot stand in `{...}`: it ends a row of a matrix in `[...]`"
        hint = "write `[1, 2; 3, 4]` or `{{1, 2}, {3, 4}}` for a matrix, `,` in a vector"
        return Once("P101", message, trouble.token.span, hint=hint, kind=f"row {opened.span.start}")
    message = "`;` cannot stand in parentheses: arguments are separated by `,`"
    kind = f"arguments {opened.span.start if opened else trouble.begin}"
    return Once("P101", message, trouble.token.span, hint="write `,`", mend=Write(","), kind=kind)


def _reserved(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    token = trouble.token
    is_name = repair is not None and repair.inserted == ("IDENT",) and repair.dropped == 1
    after_end = trouble.previous is not None and trouble.previous.type == "END"
    if not is_name or after_end or token.text not in trouble.terminals.keywords:
        return None
    if token.text == "annotation" and trouble.open_bracket is not None:
        message = "an annotation is no modifier"
        hint = "write it behind the parentheses, before the `;`"
        return Diagnostic("P101", message, token.span, hint=hint)
    operand = _operand(trouble)
    if token.text == "der" and (operand or trouble.open_bracket is not None):
        what = "declaration" if trouble.open_bracket is None else "modifier"
        message = f"`der(...)` is an operator, which no {what} changes"
        hint = "modify the variable that is equal to it, such as a speed `w` or `v`"
        if trouble.open_bracket is None:
            hint = "declare a variable that is equal to it, and give that one the start value"
        return Diagnostic("P101", message, operand or token.span, hint=hint)
    following = trouble.tokens[trouble.at + 1 : trouble.at + 2]
    if token.text == "connect" and following and following[0].type == "LPAR":
        message = "`connect(...)` is an equation, and no statement of an algorithm"
        hint = "write it behind `equation`"
        return Once("P101", message, token.span, hint=hint, kind="connect")
    return _no_name(token)


def _no_name(token: Token) -> Diagnostic:
    message = f"`{token.text}` is a reserved word and cannot be a name"
    hint = f"choose another name, or write it in single quotes: `'{token.text}'`"
    return Once("P105", message, token.span, hint=hint, kind=token.text)


def _operand(trouble: Trouble) -> Span | None:
    """The whole of `der(x)`, where the token begins it."""
    tokens = trouble.tokens[trouble.at : trouble.at + 4]
    if [t.type for t in tokens[1:]] != ["LPAR", "IDENT", "RPAR"]:
        return None
    return tokens[0].span.to(tokens[3].span)


def _wrong_end(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `end for` for `end if`, or no `end if` at all."""
    token, previous = trouble.token, trouble.previous
    if not repair:
        return None
    opened = trouble.opened
    if previous and previous.type == "END" and repair.dropped == 1 and repair.inserted:
        word = BLOCKS.get(repair.inserted[0]) or (opened.text if opened else "")
        if word == token.text:  # of a class of that name
            return _no_name(token)
        message = f"expected `end {word}`, not `end {token.text}`"
        return Diagnostic("P102", message, token.span, related=trouble.opening)
    blocks = [kind for kind in repair.inserted if kind in BLOCKS]
    if "END" in repair.inserted and blocks:
        found = f"end {token.text}" if repair.inserted[-1] == "END" else token.text
        message = f"missing `end {BLOCKS[blocks[0]]};` before `{found}`"
        return Diagnostic("P112", message, token.span, related=trouble.opening)
    return None


def _first_word(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if not repair or repair.at != trouble.begin or len(repair.inserted) != 1:
        return None
    word, first = trouble.text_of(repair.inserted[0]), trouble.tokens[trouble.begin]
    return Diagnostic("P101", f"expected `{word}` before {shown(first)}", first.span)


def _stray_end(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    token, previous = trouble.token, trouble.previous
    if not repair or repair.inserted or token.type not in BLOCKS:
        return None
    if not previous or previous.type != "END":
        return None
    span = previous.span.to(token.span)
    return StrayEnd("P112", f"no `{token.text}` is open for this `end {token.text}`", span)


_ALMOST = 0.8  # names may look like keywords, so that only a very near one counts


def _with_keyword(diagnostic: Diagnostic, trouble: Trouble) -> Diagnostic:
    """The same, with a hint at a name near the error that is almost a keyword."""
    words = [t for t in sorted(trouble.terminals.keywords) if len(t) > 2]
    near = range(trouble.at, max(trouble.at - 4, -1), -1)
    for index in dict.fromkeys((*near, trouble.begin)):
        token = trouble.tokens[index]
        if token.type != "IDENT":
            continue
        close = nearest(token.text.lower(), words, most=1, cutoff=_ALMOST)
        if close:
            hint = f"write `{close[0]}`, if that is what `{token.text}` means"
            mend = Meant(token.text, (close[0],)) if token.span == diagnostic.span else None
            return replace(diagnostic, hint=hint, mend=mend or diagnostic.mend)
    return diagnostic


def _misspelt_elseif(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if repair and repair.inserted == ("ELSEIF",):
        word = trouble.tokens[trouble.begin]
        return Diagnostic("P101", f"expected `elseif`, not `{word.text}`", word.span)
    return None


def _else_if(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    words = trouble.else_if
    if words is None or not repair or repair.inserted[:3] != ELSE_IF_ENDED:
        return None
    message = "`else if` begins an `if` of its own, whose `end if;` is missing"
    return Diagnostic("P112", message, words, hint="write `elseif`, or end both")


def _end_of_text(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if trouble.token.type != "$END":
        return None
    bracket = trouble.open_bracket
    if bracket is not None:
        message = f"this `{bracket.text}` is never closed"
        return Diagnostic("P103", message, bracket.span)
    if repair and repair.inserted == ("SEMICOLON",):
        return None
    opened = trouble.opened
    if opened is None:
        return None
    message = f"the text ends, `end {opened.text};` is missing"
    return Diagnostic("P112", message, trouble.after, related=trouble.opening)


def _missing(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain a token, or an expression, that was left out."""
    if not repair or repair.dropped or not repair.inserted:
        return None
    kind, token, previous = repair.inserted[0], trouble.token, trouble.previous
    if kind == "SEMICOLON":
        finished = trouble.automaton.finished(trouble.stack, "SEMICOLON")
        ended = next((_ENDED[name] for name in reversed(finished) if name in _ENDED), None)
        where = ended or (f"`{previous.text}`" if previous else "this")
        message = f"expected `;` after {where}"
        return Diagnostic("P101", message, trouble.after, mend=Insert(";"))
    if kind in _BRACKETS:
        opened = trouble.open_bracket
        related = (Related(f"`{opened.text}` opens here", opened.span),) if opened else ()
        closing = _BRACKETS[kind][1]
        message = f"expected `{closing}` before {shown(token)}"
        return Diagnostic("P103", message, trouble.after, related=related, mend=Insert(closing))
    if kind == "IDENT":
        return None
    if kind == "TIMES" and previous:
        message = f"expected an operator between `{previous.text}` and {shown(token)}"
        number = previous.type in NUMBERS
        unit = re.match(r"[A-Za-z]+(?:[./*^]?-?\w+)*", token.span.source.text[token.span.start :])
        written = unit[0] if unit else token.text
        hint = unit_hint(previous.text, written) if number else "write `*` for a product"
        return Diagnostic("P101", message, token.span, hint=hint)
    word = trouble.text_of(kind)
    message = f"expected `{word}` before {shown(token)}"
    if kind == "ELSE":
        message = "an `if` expression needs an `else` part"
    mend = _PUT.get(kind)
    return Diagnostic("P101", message, trouble.after, mend=mend)


_PUT = {"COMMA": Insert(","), "THEN": Insert(" then"), "LOOP": Insert(" loop")}


def _instead(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain one word for another."""
    if not repair or repair.dropped != 1 or repair.inserted not in (("THEN",), ("LOOP",)):
        return None
    token, word = trouble.token, repair.inserted[0].lower()
    message = f"expected `{word}`, not {shown(token)}"
    return Diagnostic("P101", message, token.span, mend=Write(word))


def _nameless_end(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    opened, previous = trouble.opened, trouble.previous
    if not opened or not previous or previous.type != "END" or trouble.token.type != "SEMICOLON":
        return None
    message = f"expected `{opened.text}` after `end`"
    hint, mend = f"write `end {opened.text};`", Insert(f" {opened.text}")
    return Diagnostic("P102", message, trouble.after, hint=hint, related=trouble.opening, mend=mend)


def _superfluous(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if not repair or repair.inserted or repair.dropped != 1:
        return None
    token = trouble.token
    for opening, closing in _BRACKETS.values():
        if token.text == closing:
            return Diagnostic("P103", f"no `{opening}` is open for this `{closing}`", token.span)
    return None


_EXPLANATIONS: tuple[Callable[[Trouble, Repair | None], Diagnostic | None], ...] = (
    explain_unquoted,
    explain_section,
    explain_initial,
    explain_arguments,
    _text_in_single_quotes,
    _modifier_in_braces,
    _open_brace,
    _separator,
    *OTHER_LANGUAGES,
    _operators_in_a_row,
    _chained,
    _end_of_text,
    _wrong_section,
    _first_word,
    _equal_signs,
    _reserved,
    _else_if,
    _wrong_end,
    _stray_end,
    _misspelt_elseif,
    _nameless_end,
    _missing,
    _instead,
    _superfluous,
)
