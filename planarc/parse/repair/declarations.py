"""What writers of declarations and imports bring along from other languages.

In:   Trouble, Repair   as for `habits`
Out:  Diagnostic        None where it is something else

Example: `Real(min=0) x` is no declaration; what is meant is `Real x(min=0)`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

from planarc.core.diagnostic import Diagnostic, Once
from planarc.core.mend import Insert
from planarc.parse.grammar.lexer import Token
from planarc.parse.repair.trouble import Repair, Trouble, instead

#: Letters of modifiers that a hint repeats.
_SHORT = 30
_ATTRIBUTES = frozenset(("unit", "displayUnit", "start", "fixed", "min", "max", "nominal"))


def modified_type(trouble: Trouble) -> int | None:
    """The bracket that ends the modifiers of a type, where a name follows."""
    tokens, at = trouble.tokens, trouble.at
    kinds = [t.type for t in tokens[at - 1 : at + 3]] if at else []
    if kinds != ["IDENT", "LPAR", "IDENT", "EQUAL"]:
        return None
    depth = 0
    for end in range(at, len(tokens)):
        depth += (tokens[end].type == "LPAR") - (tokens[end].type == "RPAR")
        if not depth:
            return end if tokens[end + 1].type == "IDENT" else None
        if tokens[end].type == "SEMICOLON":
            break
    return None


def _modified_type(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `Real(min=0) x;`."""
    end = modified_type(trouble)
    if end is None:
        return None
    tokens = trouble.tokens
    span = trouble.token.span.to(tokens[end].span)
    inside = span.text if len(span.text) < _SHORT else "(...)"
    hint = f"write `{tokens[trouble.at - 1].text} {tokens[end + 1].text}{inside}`"
    return Diagnostic("P101", "modifiers stand behind the name", span, hint=hint)


def import_from(trouble: Trouble) -> int | None:
    """The place of the `from` in `from A.B import C`."""
    first = trouble.at - 1
    while first > 0 and trouble.tokens[first - 1].type == "DOT":
        first -= 2
    begins = first > 0 and trouble.tokens[first - 1].text == "from"
    return first - 1 if begins and trouble.token.type == "IMPORT" else None


def _import_from(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `from PlanarMultiBody import Parts, Joints;`."""
    tokens, first = trouble.tokens, import_from(trouble)
    if first is None:
        return None
    path = tokens[first + 1].span.to(tokens[trouble.at - 1].span).text
    names = []
    for token in tokens[trouble.at + 1 :]:
        if token.type == "SEMICOLON":
            break
        names.append(token.text)
    what = "".join(names).replace(",", ", ")
    what = what if len(names) == 1 else f"{{{what}}}"
    message = "an import begins with `import`, and its names follow the package"
    span = tokens[first].span.to(trouble.token.span)
    return Diagnostic("P101", message, span, hint=f"write `import {path}.{what};`")


def _hyphen(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `Real x-pos;`."""
    three = trouble.tokens[max(trouble.at - 1, 0) : trouble.at + 2]
    if [t.type == "IDENT" for t in three] != [True, False, True] or trouble.token.text != "-":
        return None
    span, text = three[0].span.to(three[2].span), "-".join((three[0].text, three[2].text))
    if trouble.open_bracket is not None or span.text != text:
        return None
    message = f"`{text}` is no name: names have letters, digits and `_`"
    return instead(message, span, text.replace("-", "_"))


def _import_as(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `import PlanarMultiBody as P;`."""
    words = trouble.tokens[trouble.begin : trouble.at + 2]
    begins = [k for k, word in enumerate(words) if word.type == "IMPORT"]
    if trouble.token.text != "as" or not begins or words[-1].type != "IDENT":
        return None
    path = words[begins[-1] + 1].span.to(words[-3].span).text
    message = "an import gives another name with `=`, not with `as`"
    hint = f"write `import {words[-1].text} = {path};`"
    return Diagnostic("P101", message, trouble.token.span, hint=hint)


def _modifier_behind_value(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `parameter Real m = 1 (unit="kg")`, with parentheses or without."""
    following = [t.type for t in trouble.tokens[trouble.at : trouble.at + 4]]
    bare = trouble.token.text in _ATTRIBUTES and following[1:2] == ["EQUAL"]
    if "EACH" in following[1:2]:
        del following[1]
    if not bare and following[:3] != ["LPAR", "IDENT", "EQUAL"]:
        return None
    if trouble.open_bracket is not None:
        return None
    since = trouble.tokens[trouble.begin : trouble.at]
    if "EQUAL" not in (t.type for t in since):
        return None
    pairs = [(a.text, b.type) for a, b in pairwise(since) if a.type == "IDENT"]
    names = [name for name, after in pairs if after in ("EQUAL", "LSQB")] or ["x"]
    message = "modifiers stand before the value"
    inside = f"{trouble.token.text}=..." if bare else "..."
    hint = f"write them behind the name: `{names[-1]}({inside}) = ...`"
    return Diagnostic("P101", message, trouble.token.span, hint=hint)


def modifiers_as_value(trouble: Trouble) -> int | None:
    """The first `=` of `phi=(start=0)`."""
    four = trouble.tokens[max(trouble.at - 4, 0) : trouble.at + 1]
    if [t.type for t in four] != ["IDENT", "EQUAL", "LPAR", "IDENT", "EQUAL"]:
        return None
    return None if trouble.in_equations else trouble.at - 3


def _modifiers_as_value(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    sign, tokens = modifiers_as_value(trouble), trouble.tokens
    if sign is None or repair is None or repair.back_to != sign:
        return None
    name, depth, end = tokens[sign - 1], 0, sign + 1
    for end in range(sign + 1, len(tokens)):
        depth += (tokens[end].type == "LPAR") - (tokens[end].type == "RPAR")
        if not depth:
            break
    inside = tokens[sign + 1].span.to(tokens[end].span)
    message = f"the modifiers of `{name.text}` stand behind the name, without a `=`"
    if depth or len(inside.text) > 2 * _SHORT:
        hint = f"write `{name.text}(...)`"
        return Diagnostic("P101", message, tokens[sign].span, hint=hint)
    return instead(message, name.span.to(inside), name.text + inside.text)


def _type_in_a_modifier(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `bar(SI.Mass m=1)` and `contact(Circle contour1)`."""
    name, previous, opened = trouble.token, trouble.previous, trouble.open_bracket
    if name.type != "IDENT" or previous is None or previous.type != "IDENT" or not opened:
        return None
    first = trouble.at - 1
    while trouble.tokens[first - 1].type == "DOT":
        first -= 2
    if opened.text != "(" or trouble.tokens[first - 1].text not in ("(", ",", "each", "final"):
        return None
    type_ = trouble.tokens[first].span.to(previous.span)
    if not previous.text[0].isupper():
        return None
    kind = f"type {opened.span.start}"
    if trouble.tokens[trouble.at + 1].text == "=":
        message = f"a modifier names what `{name.text}` is to be, without its type"
        hint = f"leave `{type_.text}` out: write `{name.text}=...`"
        return Once("P101", message, type_, hint=hint, kind=kind)
    message = f"another class for `{name.text}` is said with `redeclare`"
    hint = f"write `redeclare {type_.text} {name.text}`"
    return Once("P101", message, type_, hint=hint, mend=Insert("redeclare "), kind=kind)


#: What says how a variable varies, or what gives it its value.
_PREFIXES = frozenset(("parameter", "constant", "discrete", "input", "output", "flow", "stream"))


def _type_missing(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `parameter m = 0.5;`."""
    words = trouble.tokens[max(trouble.at - 2, 0) : trouble.at]
    if [w.text in _PREFIXES for w in words] != [True, False] or words[1].type != "IDENT":
        return None
    if trouble.token.text not in ("=", "(", ";") or trouble.open_bracket is not None:
        return None
    prefix, name = (w.text for w in words)
    message = f"the type of `{name}` is missing"
    return Diagnostic("P101", message, words[1].span, hint=f"write `{prefix} Real {name}`")


def _prefix_behind_type(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `Modelica.Units.SI.Length parameter L = 0.8;`."""
    prefix, first = trouble.token, trouble.at - 1
    if prefix.text not in _PREFIXES or trouble.open_bracket is not None or first < 0:
        return None
    if trouble.tokens[first].type != "IDENT" or trouble.tokens[trouble.at + 1].type != "IDENT":
        return None
    while trouble.tokens[first - 1].type == "DOT":
        first -= 2
    if trouble.on_new_line or first != trouble.begin:
        return None
    type_ = trouble.tokens[first].span.to(trouble.tokens[trouble.at - 1].span).text
    message = f"`{prefix.text}` stands before the type"
    hint = f"write `{prefix.text} {type_} {trouble.tokens[trouble.at + 1].text}`"
    return Diagnostic("P101", message, prefix.span, hint=hint)


#: Words after which the name of a class stands, or stands again.
_NAMING = frozenset(
    ("model", "block", "class", "package", "function", "record", "connector", "type", "end")
)
_BEHIND = 4  # tokens behind that word at most where the grammar sees that something is wrong


def _joined(words: Iterable[Token]) -> str:
    return "".join(w.text[0].upper() + w.text[1:] for w in words)


def is_end_of_two_words(tokens: Sequence[Token], first: int, end: Token) -> bool:
    """Whether a class whose name was written as two words ends with the name that is meant."""
    words = tokens[first : first + 2]
    return [w.type for w in words] == ["IDENT", "IDENT"] and _joined(words) == end.text


def _name_of_two_words(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `model Simple Pendulum`, and its end."""
    for at in range(trouble.at - 2, max(trouble.at - _BEHIND, 0) - 1, -1):
        word, *names, after = trouble.tokens[at : at + 4]
        if word.text not in _NAMING or [n.type for n in names] != ["IDENT", "IDENT"]:
            continue
        span = names[0].span.to(names[1].span)
        goes_on = after.type not in ("STRING", "SEMICOLON") and "\n" not in span.to(after.span).text
        if goes_on or "\n" in word.span.to(span).text:
            return None
        one = _joined(names)
        message = f"`{span.text}` is no name: a name is one word"
        return Once("P101", message, span, hint=f"write `{one}`", kind=f"two words {span.text}")
    return None


DECLARATIONS: tuple[Callable[[Trouble, Repair | None], Diagnostic | None], ...] = (
    _modifier_behind_value,
    _modified_type,
    _modifiers_as_value,
    _type_missing,
    _prefix_behind_type,
    _import_from,
    _import_as,
    _hyphen,
    _name_of_two_words,
    _type_in_a_modifier,
)
