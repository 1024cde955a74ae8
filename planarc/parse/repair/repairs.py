"""Looks for the small change after which a text can be read on.

In:   Trouble, Place     a token that does not fit, and where its statement begins
Out:  Repair             tokens put in, left out or replaced, or text skipped

Tried are, in this order: errors with a form of their own (a section forgotten, a
stray `end if`); one token put in, left out or replaced, of which the one after
which most tokens fit is taken; and skipping to the next `;` or section.

Example: in `x = f(a; y = 2;` the token `;` does not fit; with `)` put in before
it, the eight tokens that follow do.

Promises:  the token that did not fit is behind the place where reading goes on,
           or fits there.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from planarc.parse.grammar.machine import Stack
from planarc.parse.repair.arguments import bare_arguments
from planarc.parse.repair.declarations import import_from, modified_type, modifiers_as_value
from planarc.parse.repair.habits import (
    assigned_expression,
    find_colon,
    joined_end,
    other_branch,
    trailing_if,
)
from planarc.parse.repair.quotes import unquoted
from planarc.parse.repair.sections import initial_equation, misspelt_section
from planarc.parse.repair.trouble import BLOCKS, ELSE_IF_ENDED, Repair, Trouble

#: Tokens after a repair that are looked at, and how many of them have to fit.
_AHEAD = 8
_ENOUGH = 3
_FAR_AHEAD = 60
#: Places tried when text is skipped.
_MAX_SKIPS = 300

_RESTARTS = frozenset({"EQUATION", "ALGORITHM", "INITIAL_SECTION", "PUBLIC", "PROTECTED", "END"})
_CLOSERS = frozenset({"SEMICOLON", "COMMA", "RPAR", "RSQB", "RBRACE"})
#: `2 x`, `2(a + b)`, `(a + b)(c + d)`
_PRODUCTS = frozenset(
    {(number, after) for number in ("INTEGER", "REAL") for after in ("IDENT", "LPAR")}
    | {("RPAR", "LPAR")}
)

#: The words that begin a block, by those that go on with it.
_BEGINS = {"THEN": ("IF", "ELSEIF", "WHEN"), "LOOP": ("WHILE", "FOR"), "IN": ("FOR",)}

#: The tokens that may be put in, most likely first.
_INSERTED: tuple[tuple[str, ...], ...] = (
    *(("SEMICOLON",), ("COMMA",), ("RPAR",), ("RSQB",), ("RBRACE",), ("THEN",), ("LOOP",)),
    *(("EQUAL",), ("ASSIGN",), ("IN",), ("ELSE", "IDENT")),
)
#: The tokens that may take the place of another.
_REPLACED = {
    "ASSIGN": ("EQUAL",),
    "EQUAL": ("ASSIGN", "RELATION", "IN"),
    "IDENT": ("THEN", "LOOP"),
    "SEMICOLON": ("COMMA",),
}
_INSERTED_LAST: tuple[tuple[str, ...], ...] = (
    ("IDENT",),
    ("LPAR",),
    *((block, "SEMICOLON", "END") for block in BLOCKS),
)
_INSERTED_LAST += tuple(("END", block, "SEMICOLON") for block in BLOCKS)


class Place(NamedTuple):
    """The begin of a statement, equation or declaration."""

    stack: Stack
    at: int


def find_repair(trouble: Trouble, begin: Place) -> Repair | None:
    """The repair, None where nothing helps: the rest of the text is not read."""
    kinds = [token.type for token in trouble.tokens]
    special = (_misspelt_elseif, _else_if, _joined_end, _stray_end, _colon, _other_branch)
    left_out = (_unquoted, _modified_type, _import_from, _assigned_expression, _trailing_if)
    misspelt = (_misspelt_section, _initial_equation, _bare_arguments, _modifiers_as_value)
    others = (_first_word, _other_section, _open_brace, _small_change, _skip)
    tries = (*special, *left_out, *misspelt, *others)
    return next(filter(None, (attempt(trouble, kinds, begin) for attempt in tries)), None)


def _small_change(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """A token put in, left out or replaced, so that most of the following ones fit."""
    automaton, at = trouble.automaton, trouble.at
    best: Repair | None = None
    best_score = 0
    for inserted, dropped in _candidates(trouble):
        stack: Stack | None = trouble.stack
        for kind in inserted:
            stack = automaton.shift(stack, kind, at) if stack else None
        if stack is None:
            continue
        ahead = kinds[at + dropped : at + dropped + _AHEAD]
        score = automaton.advance(stack, ahead)
        enough = 1 if inserted == ("SEMICOLON",) and trouble.on_new_line else _ENOUGH
        mended = inserted and "SEMICOLON" in ahead[:score]
        if score < min(enough, len(ahead)) and not mended and kinds[at] != "$END":
            continue
        if score > best_score:
            best, best_score = Repair(inserted, dropped, stack, at + dropped), score
    return best


def _candidates(trouble: Trouble) -> Iterator[tuple[tuple[str, ...], int]]:
    """The tokens to put in, with the number of those to leave out."""
    token, previous = trouble.token, trouble.previous
    if previous and (previous.type, token.type) in _PRODUCTS:
        yield ("TIMES",), 0
    for inserted in _INSERTED:
        yield inserted, 0
    if token.type == "$END":
        return
    for right in _REPLACED.get(token.type, ()):
        yield (right,), 1
    if token.text in trouble.terminals.keywords:
        yield ("IDENT",), 1
    if previous and previous.type == "END":
        for block in BLOCKS:
            yield (block,), 1
        for name in (*BLOCKS, "IDENT"):
            yield (name,), 0
    yield ("TIMES",), 0
    if token.type in _CLOSERS:  # rather an expression missing than one token too many
        yield ("IDENT",), 0
    yield (), 1
    for inserted in _INSERTED_LAST:
        yield inserted, 0


def _misspelt_elseif(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    word = trouble.tokens[begin.at]
    if begin.at != trouble.at - 1 or word.type != "IDENT":
        return None
    if word.text.lower() not in ("elif", "elsif", "elseif"):
        return None
    stack = trouble.automaton.shift(begin.stack, "ELSEIF", begin.at)
    return Repair(("ELSEIF",), 0, stack, trouble.at, begin.at) if stack else None


def _else_if(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """End the `if`s that are open because of an `else if`, before an `end` of something else."""
    at, stack, inserted = trouble.at, trouble.stack, tuple[str, ...]()
    if kinds[at - 1] != "END" or trouble.else_if is None:
        return None
    for _ in trouble.open_ifs:
        for kind in ELSE_IF_ENDED:
            following = trouble.automaton.shift(stack, kind, at)
            if following is None:
                return None
            stack = following
        inserted += ELSE_IF_ENDED
        if trouble.automaton.shift(stack, kinds[at], at):
            return Repair(inserted, 0, stack, at)
    return None


def _joined_end(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Read `endif;` as `end if;`."""
    kind = joined_end(trouble)
    stack = _read(trouble, begin, ["END", kind]) if kind else None
    return Repair(("END", kind), 0, stack, trouble.at, begin.at) if kind and stack else None


def _stray_end(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out an `end if` where no block is open."""
    at = trouble.at
    if begin.at != at - 1 or kinds[begin.at] != "END" or kinds[at] not in BLOCKS:
        return None
    if trouble.automaton.shift(trouble.stack, "IDENT", at) is None:
        return None
    return Repair((), 1, begin.stack, at + 1 + (kinds[at + 1] == "SEMICOLON"), begin.at)


def _first_word(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Put in the `if` of `a > 1 then`, or the `end` of `if;`."""
    at, automaton = trouble.at, trouble.automaton
    if kinds[at] == "SEMICOLON" and kinds[at - 1] in BLOCKS and begin.at == at - 1:
        tried = [("END",)]
    else:
        tried = [(block,) for block in _BEGINS.get(kinds[at], ())]
    best: Repair | None = None
    best_score = at - begin.at
    for inserted in tried:
        stack = automaton.shift(begin.stack, inserted[0], begin.at)
        if stack is None:
            continue
        score = automaton.advance(stack, kinds[begin.at : at + _FAR_AHEAD])
        if score > best_score:
            best, best_score = Repair(inserted, 0, stack, begin.at, begin.at), score
    return best


def _other_section(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Open another section for an equation among declarations, or the other way round."""
    automaton = trouble.automaton
    read = trouble.at - begin.at
    following = kinds[begin.at : begin.at + read + _ENOUGH]
    among_declarations = automaton.shift(begin.stack, "PARAMETER", begin.at) is not None
    if not among_declarations and "SEMICOLON" in following:
        following = following[: following.index("SEMICOLON") + 1]
    for section in ("EQUATION", "ALGORITHM") if among_declarations else ("PUBLIC",):
        stack = automaton.shift(begin.stack, section, begin.at)
        if not stack or automaton.advance(stack, following) < len(following):
            continue
        if among_declarations:
            return Repair((section,), 0, stack, begin.at, begin.at)
        ended = kinds.index("SEMICOLON", trouble.at) if "SEMICOLON" in kinds[trouble.at :] else 0
        if ended:  # the declaration is left out
            return Repair((section,), 0, begin.stack, ended + 1, begin.at)
    return None


def _colon(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Read the colon of `if x > 1:` as what is meant."""
    found = find_colon(trouble)
    if found is None or found[0] < begin.at:
        return None
    at, _, word = found
    stack = _read(trouble, begin, [*kinds[begin.at : at], word.upper()])
    return Repair((word.upper(),), 1, stack, at + 1, at) if stack else None


def _other_branch(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Read `elseif` in a `when` as `elsewhen`, and the other way round; pass an `else` over."""
    meant = other_branch(trouble.token, trouble.opened)
    if meant is None:
        return None
    inserted = (meant,) if meant else ()
    stack: Stack | None = trouble.stack
    for kind in inserted:
        stack = trouble.automaton.shift(stack, kind, trouble.at) if stack else None
    return Repair(inserted, 1, stack, trouble.at + 1) if stack else None


def _unquoted(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Read `terminate(The end)` as if its text had quotes."""
    found = unquoted(trouble)
    if found is None or found[0] < begin.at:
        return None
    stack = _read(trouble, begin, [*kinds[begin.at : found[0]], "STRING"])
    if stack is None or not trouble.automaton.advance(stack, kinds[found.stop : found.stop + 1]):
        return None
    return Repair(("STRING",), found.stop - trouble.at, stack, found.stop, found[0])


def _modified_type(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out the modifiers of `Real(min=0) x`."""
    end = modified_type(trouble)
    if end is None:
        return None
    return Repair((), end + 1 - trouble.at, trouble.stack, end + 1)


def _import_from(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out `from A import B;`."""
    first = import_from(trouble)
    if first is None or "SEMICOLON" not in kinds[trouble.at :]:
        return None
    after = kinds.index("SEMICOLON", trouble.at) + 1
    stack = tuple(item for item in trouble.stack if item.first < first)
    return Repair((), after - trouble.at, stack, after, first)


def _assigned_expression(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out `2*y := x`, where both sides are expressions."""
    found = assigned_expression(trouble)
    if found is None:
        return None
    sign, end = found
    for first, last in ((begin.at, sign), (sign + 1, end)):
        read = ["IDENT", "ASSIGN", *kinds[first:last], "SEMICOLON"]
        if trouble.automaton.advance(begin.stack, read) < len(read):
            return None
    return Repair((), end + 1 - trouble.at, begin.stack, end + 1, begin.at)


def _trailing_if(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out the statement that ends with `a if c else b`."""
    found = trailing_if(trouble)
    if found is None:
        return None
    end = found[1]
    return Repair((), end + 1 - trouble.at, begin.stack, end + 1, begin.at)


def _misspelt_section(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Read `equations` as `equation`, if the trouble fits behind that."""
    found = misspelt_section(trouble)
    stack = _read(trouble, begin, [*found.kinds]) if found else None
    if found is None or stack is None:
        return None
    at = found.at + 1
    following = kinds[at : trouble.at + 1]
    if trouble.automaton.advance(stack, following) < len(following):
        return None
    return Repair(found.kinds, 0, stack, at, begin.at)


def _initial_equation(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out `initial x = 0;`."""
    end = initial_equation(trouble)
    if end is None:
        return None
    return Repair((), end + 1 - trouble.at, begin.stack, end + 1, begin.at)


def _bare_arguments(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Read `der x` as `der(x)`."""
    found = bare_arguments(trouble)
    stack: Stack | None = trouble.stack
    for kind in found.kinds if found else ():
        stack = trouble.automaton.shift(stack, kind, trouble.at) if stack else None
    if found is None or stack is None:
        return None
    return Repair(found.kinds, found.end - trouble.at, stack, found.end)


def _modifiers_as_value(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Leave out the first `=` of `phi=(start=0)`."""
    sign = modifiers_as_value(trouble)
    stack = _read(trouble, begin, kinds[begin.at : sign]) if sign is not None else None
    if sign is None or stack is None:
        return None
    following = kinds[sign + 1 : trouble.at + 1]
    if trouble.automaton.advance(stack, following) < len(following):
        return None
    return Repair((), 0, stack, sign + 1, sign)


def _read(trouble: Trouble, begin: Place, kinds: list[str]) -> Stack | None:
    """What is read of a statement, when it is made of other tokens."""
    stack: Stack | None = begin.stack
    for place, kind in enumerate(kinds, begin.at):
        stack = trouble.automaton.shift(stack, kind, place) if stack else None
    return stack


def _open_brace(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Put in the `}` of `r={1, 0, m=2`: a comma, a name and `=` stand in no array."""
    at, bracket = trouble.at, trouble.open_bracket
    if bracket is None or bracket.type != "LBRACE":
        return None
    if kinds[max(at - 2, 0) : at + 1] != ["COMMA", "IDENT", "EQUAL"]:
        return None
    stack = _read(trouble, begin, [*kinds[begin.at : at - 2], "RBRACE"])
    if not stack or trouble.automaton.advance(stack, kinds[at - 2 : at + 2]) < _ENOUGH + 1:
        return None
    return Repair(("RBRACE",), 0, stack, at - 2, at - 2)


def _skip(trouble: Trouble, kinds: list[str], begin: Place) -> Repair | None:
    """Go on after the next `;` or at the next section, in the innermost place that fits."""
    automaton = trouble.automaton
    outer = [trouble.stack[:size] for size in range(len(trouble.stack), 0, -1)]
    tried = 0
    for at in range(trouble.at + 1, len(kinds)):
        after_semicolon = kinds[at - 1] == "SEMICOLON"
        if not after_semicolon and kinds[at] not in _RESTARTS:
            continue
        ahead = kinds[at : at + _AHEAD]
        if after_semicolon and automaton.advance(begin.stack, ahead):
            return Repair((), at - trouble.at, begin.stack, at, begin.at)
        for stack in outer:
            if automaton.advance(stack, ahead) == len(ahead):
                left_out = trouble.stack[len(stack) :]
                back_to = left_out[0].first if left_out else None
                return Repair((), at - trouble.at, stack, at, back_to)
        tried += 1
        if tried > _MAX_SKIPS:
            break
    return None
