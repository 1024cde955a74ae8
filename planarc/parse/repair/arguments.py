"""Arguments without their parentheses.

In:   Trouble       a token that does not fit
Out:  Bare          what stands there as arguments; the message about it

Example: `der hinge.phi` and `connect world.frame_b, hinge.frame_a`.
"""

from __future__ import annotations

from typing import NamedTuple

from planarc.core.diagnostic import Diagnostic
from planarc.parse.grammar.lexer import Token
from planarc.parse.repair.trouble import Repair, Trouble, instead

#: Functions that are written without parentheses on paper.
_FUNCTIONS = frozenset(
    ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "log10")
)
_FUNCTIONS |= {"sqrt", "abs", "sign", "pre", "edge"}
_OPERANDS = frozenset(("IDENT", "INTEGER", "REAL"))
_PAIR = ("LPAR", "IDENT", "COMMA", "IDENT", "RPAR")


class Bare(NamedTuple):
    """The arguments, each with the token behind it, and what can be read in their place."""

    operands: list[tuple[int, int]]
    kinds: tuple[str, ...]

    @property
    def end(self) -> int:
        return self.operands[-1][1]


def bare_arguments(trouble: Trouble) -> Bare | None:
    word, token, at = trouble.previous, trouble.token, trouble.at
    if word is None or token.type not in _OPERANDS or trouble.on_new_line:
        return None
    if word.type == "DER" or (word.type == "IDENT" and word.text in _FUNCTIONS):
        return Bare([(at, _end_of_operand(trouble.tokens, at))], ("LPAR", "IDENT", "RPAR"))
    operands = _operands(trouble.tokens, at) if word.type == "CONNECT" else []
    return Bare(operands, _PAIR) if len(operands) > 1 else None


def _operands(tokens: list[Token], at: int) -> list[tuple[int, int]]:
    """All names up to the end of a `connect`, with commas between them or without."""
    found = []
    while tokens[at].type == "IDENT":
        end = _end_of_operand(tokens, at)
        found.append((at, end))
        at = end + (tokens[end].type == "COMMA")
    return found if tokens[at].type == "SEMICOLON" else []


def _end_of_operand(tokens: list[Token], at: int) -> int:
    """The token behind a number, or a name with its indices."""
    at += 1
    while at + 1 < len(tokens):
        if tokens[at].type == "DOT":
            at += 2
        elif tokens[at].type == "LSQB":
            at = next((k + 1 for k in range(at, len(tokens)) if tokens[k].type == "RSQB"), at)
            if tokens[at].type == "LSQB":
                break
        else:
            break
    return at


def explain_arguments(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    found, word, tokens = bare_arguments(trouble), trouble.previous, trouble.tokens
    if found is None or word is None or repair is None or repair.inserted != found.kinds:
        return None
    texts = [tokens[a].span.to(tokens[b - 1].span).text for a, b in found.operands]
    span = word.span.to(tokens[found.end - 1].span)
    message = f"the arguments of `{word.text}` stand in parentheses"
    if len(texts) > 2:  # which belong together is not known
        return Diagnostic("P101", message, span, hint="write one `connect(a, b)` for each pair")
    return instead(message, span, f"{word.text}({', '.join(texts)})")
