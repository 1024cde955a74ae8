"""What writers bring along from other languages, and from paper: numbers, signs and words.

In:   Trouble, Repair   as for `hints`, which says it in the place of anything less special
Out:  Diagnostic        None where it is something else

Example: `s += x` is no statement; what is meant is `s := s + x`.

The file is long because habits are many; each is told by one short function, the first that fits.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise

from planarc.core.diagnostic import Diagnostic, Once
from planarc.core.mend import Write
from planarc.core.quantity import in_unit
from planarc.core.unit import parse, unit_text
from planarc.parse.grammar.lexer import Token
from planarc.parse.repair.declarations import DECLARATIONS
from planarc.parse.repair.trouble import Repair, Trouble, instead


def _power_sign(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    token, previous = trouble.token, trouble.previous
    if token.text == "*" and previous and previous.text == "*":
        span = previous.span.to(token.span)
        hint = "write `^` for a power"
        return Diagnostic("P101", "`**` is no operator", span, hint=hint, mend=Write("^"))
    return None


def _bare_fraction(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `.5`: a point and an integer, of which one does not fit."""
    for at in (trouble.at, trouble.at - 1):
        point, *digits = trouble.tokens[at : at + 2] if at >= 0 else (trouble.token,)
        if point.type != "DOT" or not digits or digits[0].type != "INTEGER":
            continue
        before = trouble.tokens[at - 1] if at else None
        touching = before is not None and before.span.end == point.span.start
        if touching and before and before.type in NUMBERS:
            span = before.span.to(digits[0].span)
            message = f"`{span.text}` is no number: it has two points"
            return Diagnostic("P101", message, span, hint="write one point, and no separators")
        if touching and before and before.type in ("IDENT", "RPAR", "RSQB"):
            continue
        number = f".{digits[0].text}"
        message = f"`{number}` is no number: a digit stands before the point"
        span = point.span.to(digits[0].span)
        return instead(message, span, f"0{number}")
    return None


def _decimal_comma(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `m=0,5` and `0,5*x`: a number, a comma and a number without a space."""
    for at in (trouble.at, trouble.at + 1):
        three = trouble.tokens[max(at - 2, 0) : at + 1]
        if [t.text == "," for t in three] != [False, True, False]:
            continue
        before, _, after = three
        span = before.span.to(after.span)
        text = f"{before.text},{after.text}"
        if not {before.type, after.type} <= set(NUMBERS):
            continue
        if span.text == text:
            message = f"`{text}` is no number: decimals stand behind a point"
            return instead(message, span, text.replace(",", "."))
    return None


def _assigning_operator(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `s += x` and `n++`."""
    for at in (trouble.at, trouble.at - 1):
        pair = trouble.tokens[at : at + 2] if at > 0 else []
        sign = "".join(t.text for t in pair)
        if sign not in _ASSIGNING or pair[0].span.to(pair[1].span).text != sign:
            continue
        name = trouble.tokens[trouble.begin].span.to(trouble.tokens[at - 1].span).text
        value = f"{name} {sign[0]} {'1' if sign[0] == sign[1] else '...'}"
        message = f"`{sign}` is no operator: a statement assigns with `:=`"
        span = pair[0].span.to(pair[1].span)
        return Diagnostic("P101", message, span, hint=f"write `{name} := {value}`")
    return None


_ASSIGNING = ("+=", "-=", "*=", "/=", "++", "--")


def _loop_of_c(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `for (i = 1; i <= n; i++) {`."""
    first, token = trouble.previous, trouble.token
    if token.text != "(" or first is None or first.text != "for":
        return None
    line = token.span.source.text[token.span.start :].partition("\n")[0].rstrip()
    span = first.span._replace(end=token.span.start + len(line))
    counter = trouble.tokens[trouble.at + 1]
    name = counter.text if counter.type == "IDENT" else "i"
    message = "a loop runs over values, without a condition and a step"
    return Diagnostic("P101", message, span, hint=f"write `for {name} in 1:n loop ... end for;`")


def _connect_of_three(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `connect(a, b, c)`."""
    bracket = trouble.open_bracket
    words = trouble.tokens[trouble.begin : trouble.at]
    if trouble.token.text != "," or not words or words[0].type != "CONNECT":
        return None
    if bracket is None or bracket is not words[1]:
        return None
    hint = "write one `connect` for each pair"
    return Diagnostic("P101", "`connect` joins two connectors", trouble.token.span, hint=hint)


def _index_in_parentheses(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `hinge(1).phi` and `x(2) := 1`: an index as in MATLAB."""
    tokens, at = trouble.tokens, trouble.at
    kinds = tuple(t.type for t in tokens[max(at - 4, 0) : at])
    if trouble.token.type not in ("DOT", "ASSIGN") or kinds not in _INDEXED:
        return None
    name, index = tokens[at - 4].text, tokens[at - 2].text
    span = tokens[at - 4].span.to(tokens[at - 1].span)
    message = f"`{span.text}` calls a function: elements of arrays stand in square brackets"
    return instead(message, span, f"{name}[{index}]")


_INDEXED = tuple(("IDENT", "LPAR", index, "RPAR") for index in ("INTEGER", "IDENT"))


def _arrow(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `a.y -> b.u`."""
    for at in (trouble.at, trouble.at + 1):
        pair = trouble.tokens[at - 1 : at + 1] if at else []
        sign = "".join(t.text for t in pair)
        if sign in ("->", "<-", "=>", "=<") and pair[0].span.to(pair[1].span).text == sign:
            message = f"`{sign}` is no operator"
            if sign[0] == "=":
                meant = ">=" if sign == "=>" else "<="
                return instead(message, pair[0].span.to(pair[1].span), meant)
            hint = "write `connect(a, b)` to join components, `a = b` for an equation"
            return Diagnostic("P101", message, pair[0].span.to(pair[1].span), hint=hint)
    return None


def find_colon(trouble: Trouble) -> tuple[int, Token, str] | None:
    """The colon of `if x > 1:` at the end of a line, which begins a range: its number, the word
    that begins the line, and the one that is meant."""
    for at in range(trouble.at, max(trouble.at - _NEAR, 1), -1):
        colon, before = trouble.tokens[at - 1 : at + 1]
        if colon.text != ":" or not _is_line_between(colon, before):
            continue
        first = at - 1
        while first and not _is_line_between(trouble.tokens[first - 1], trouble.tokens[first]):
            first -= 1
        word = trouble.tokens[first]
        opens = _OPENS.get(word.type)
        if opens is not None:
            return at - 1, word, opens
    return None


def _colon_for_then(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    found = find_colon(trouble)
    if found is None:
        return None
    at, word, opens = found
    message = f"`{word.text}` goes on with `{opens}`, not with `:`"
    return instead(message, trouble.tokens[at].span, opens)


def assigned_expression(trouble: Trouble) -> tuple[int, int] | None:
    """The statement `2*y := x`, which assigns to no name: its `:=`, and the `;` that ends it."""
    depth, sign = 0, None
    for at in range(trouble.begin, len(trouble.tokens)):
        kind = trouble.tokens[at].type
        depth += (kind in _OPENING) - (kind in _CLOSING)
        if kind == "SEMICOLON":
            return (sign, at) if sign is not None and sign > trouble.begin else None
        if kind == "ASSIGN" and not depth:
            sign = at
        if kind in _OPENS or kind == "END":
            return None
    return None


_OPENING = frozenset(("LPAR", "LSQB", "LBRACE"))
_CLOSING = frozenset(("RPAR", "RSQB", "RBRACE"))


def _assigned_expression(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    if repair is None or repair.inserted or repair.back_to != trouble.begin:
        return None
    found = assigned_expression(trouble)
    if found is None or repair.at != found[1] + 1:
        return None
    tokens, (sign, end) = trouble.tokens, found
    left = tokens[trouble.begin].span.to(tokens[sign - 1].span)
    right = tokens[sign + 1].span.to(tokens[end - 1].span)
    message = f"`{left.text}` is no name, so that `:=` has nothing to assign to"
    hint = "solve for the name, and write it alone before `:=`"
    if len(left.text) + len(right.text) < _SHORT:
        hint += f", or write `{left.text} = {right.text}` below `equation`"
    return Diagnostic("P101", message, left, hint=hint)


_SHORT = 50  # letters of an equation that a hint repeats


def joined_end(trouble: Trouble) -> str | None:
    """The kind of the block that `endif;` and the like end."""
    tokens, begin = trouble.tokens, trouble.begin
    word = tokens[begin]
    if word.type != "IDENT" or trouble.at != begin + 1 or trouble.token.type != "SEMICOLON":
        return None
    opened = trouble.opened
    joined = re.sub("[_-]", "", word.text.lower())
    return opened.type if opened and joined == f"end{opened.type.lower()}" else None


def _joined_end(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    kind = joined_end(trouble)
    if kind is None:
        return None
    word = trouble.tokens[trouble.begin]
    message = f"`{word.text}` is two words"
    return instead(message, word.span, f"end {kind.lower()}", related=trouble.opening)


def trailing_if(trouble: Trouble) -> tuple[int, int] | None:
    """The expression `a if c else b`, which has no `then`: its `if`, and the `;` that ends it."""
    kinds = [token.type for token in trouble.tokens]
    since = kinds[trouble.begin : trouble.at + 1]
    if since[-1] not in ("IF", "ELSE") or "IF" not in since:
        return None
    first = trouble.begin + since.index("IF")
    if "SEMICOLON" not in kinds[trouble.at :] or kinds[first - 1] not in _OPERANDS:
        return None
    end = kinds.index("SEMICOLON", trouble.at)
    rest = kinds[first + 1 : end]
    return (first, end) if "ELSE" in rest and not {"THEN", "IF", "END"} & {*rest} else None


_OPERANDS = frozenset(("IDENT", "INTEGER", "REAL", "TRUE", "FALSE", "STRING", *_CLOSING))


def _trailing_if(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `q = a if h > 0 else 0`."""
    found = trailing_if(trouble)
    if found is None:
        return None
    tokens, first = trouble.tokens, found[0]
    middle = next(i for i in range(first, len(tokens)) if tokens[i].type == "ELSE")
    condition = tokens[first + 1].span.to(tokens[middle - 1].span).text
    hint = f"write `if {condition if len(condition) < _SHORT else '...'} then ... else ...`"
    message = "the condition of a value stands before it"
    return Diagnostic("P101", message, tokens[first].span, hint=hint)


def other_branch(word: Token, opened: Token | None) -> str | None:
    """The word meant by `elseif` in a `when`, and by `elsewhen` in an `if`."""
    if opened is None:
        return None
    if opened.type not in _OPENS and word.type in _WITHOUT:
        return _WITHOUT[word.type]
    return _BRANCHES.get((opened.type, word.type))


_WITHOUT = {"ELSEWHEN": "WHEN", "ELSEIF": "IF"}


_BRANCHES = {("WHEN", "ELSEIF"): "ELSEWHEN", ("IF", "ELSEWHEN"): "ELSEIF", ("WHEN", "ELSE"): ""}


def _other_branch(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain branches of an `if` in a `when`, and the other way round."""
    token, opened = trouble.token, trouble.opened
    meant = other_branch(token, opened)
    if meant is None or opened is None:
        return None
    if opened.type not in _OPENS:
        message = f"no `{meant.lower()}` is open that this `{token.text}` could go on with"
        return instead(message, token.span, meant.lower())
    if meant:
        message = f"`{opened.text}` goes on with `{meant.lower()}`, not with `{token.text}`"
        return instead(message, token.span, meant.lower(), related=trouble.opening)
    message = "`when` has no `else`: it acts at the moment its condition becomes true"
    hint = (
        "write `elsewhen` and a condition of its own, or `if` instead of `when` for what "
        "holds as long as the condition does"
    )
    return Diagnostic("P101", message, token.span, hint=hint, related=trouble.opening)


def _value_of_return(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `return 2*x;`."""
    word = trouble.previous
    if word is None or word.type != "RETURN":
        return None
    before = trouble.tokens[: trouble.at]
    outputs = [k for k, token in enumerate(before) if token.type == "OUTPUT"]
    names = pairwise(before[outputs[-1] + 1 :] if outputs else ())
    name = next(
        (b.text for a, b in names if a.type in ("IDENT", "RSQB") and b.type == "IDENT"), "y"
    )
    message = "`return` takes no value: a function gives its outputs, which have names"
    hint = f"assign the value to the output: `{name} := ...;`, and leave `return` out"
    return Once("P101", message, trouble.token.span, hint=hint, kind="return")


def _row_of_spaces(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `[0 1; 2 3]`."""
    opened, previous, token = trouble.open_bracket, trouble.previous, trouble.token
    if opened is None or opened.text != "[" or previous is None:
        return None
    if previous.type not in (*NUMBERS, "IDENT") or token.type not in (*NUMBERS, "IDENT"):
        return None
    message = f"the values of a row are parted by `,`: `{previous.text}, {token.text}`"
    hint = "write a row as `[1, 2]`, a matrix as `[1, 2; 3, 4]`"
    return Once("P101", message, token.span, hint=hint, kind=f"row {opened.span.start}")


_NEAR = 6  # tokens of the next line that may be read before a colon is found wrong
_OPENS = {"IF": "then", "ELSEIF": "then", "WHEN": "then", "FOR": "loop", "WHILE": "loop"}


def _is_line_between(a: Token, b: Token) -> bool:
    return "\n" in a.span.source.text[a.span.end : b.span.start]


def unit_hint(number: str, unit: str) -> str:
    """What a user means by a unit behind a number."""
    if unit in _CONVERSIONS:
        return f"write `Modelica.Units.Conversions.{_CONVERSIONS[unit]}({number})`"
    if unit in _FACTORS:
        return f"write `{number}{_FACTORS[unit]}`: values are in SI units"
    if unit in _SI:
        return f"leave `{unit}` out: values are in SI units"
    dimension = parse(unit.replace("^", "")) if re.search(r"[/.^]", unit) else None
    if dimension is not None:
        value = in_unit(unit, f"{number} {unit}", unit_text(dimension))
        if value is None or value == float(number):
            return f"leave `{unit}` out: values are in SI units"
        return f"write `{value:.6g}`: values are in SI units"
    return "write `*` for a product"


NUMBERS = ("INTEGER", "REAL")
_CONVERSIONS = {
    "deg": "from_deg",
    "degree": "from_deg",
    "degrees": "from_deg",
    "rpm": "from_rpm",
    "degC": "from_degC",
    "bar": "from_bar",
}
_FACTORS = {"mm": "e-3", "cm": "e-2", "km": "e3", "g": "e-3", "t": "e3", "kN": "e3", "ms": "e-3"}
_SI = frozenset(("m", "kg", "s", "N", "Nm", "rad", "Hz", "J", "W", "K", "Pa", "V", "A"))


OTHER_LANGUAGES: tuple[Callable[[Trouble, Repair | None], Diagnostic | None], ...] = (
    _joined_end,
    *DECLARATIONS,
    _power_sign,
    _bare_fraction,
    _decimal_comma,
    _loop_of_c,
    _assigning_operator,
    _connect_of_three,
    _index_in_parentheses,
    _arrow,
    _colon_for_then,
    _assigned_expression,
    _trailing_if,
    _other_branch,
    _value_of_return,
    _row_of_spaces,
)
