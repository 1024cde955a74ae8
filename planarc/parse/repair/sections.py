"""Words that were to begin a section: misspelt ones, and `initial` before a single equation.

In:   Trouble           a token that does not fit
Out:  what is meant, and the message about it; None where it is something else

Example: `equations` alone on its line, before the first `connect(...)`.
"""

from __future__ import annotations

from typing import NamedTuple

from planarc.core.diagnostic import Diagnostic
from planarc.core.nearest import nearest
from planarc.parse.repair.trouble import Repair, Trouble, instead

_SECTIONS = ("equation", "algorithm", "public", "protected")
#: Names may look like these words, so that only a very near one counts.
_ALMOST = 0.8
_INITIAL = ["INITIAL", "IDENT"]
#: Letters of an equation that a hint repeats.
_SHORT = 50


class Section(NamedTuple):
    """The place of a wrong word, and the terminals that are meant with what stands before it."""

    at: int
    kinds: tuple[str, ...]


def misspelt_section(trouble: Trouble) -> Section | None:
    """The word alone on its line that begins what holds the trouble, if it is nearly a section."""
    return _section_at(trouble, trouble.begin)


def _section_at(trouble: Trouble, at: int) -> Section | None:
    tokens = trouble.tokens
    initial = tokens[at].type == "INITIAL"
    at += initial
    word, *after = tokens[at : at + 2]
    if word.type != "IDENT" or not after or word.span.line == after[0].span.line:
        return None
    near = nearest(word.text.lower(), _SECTIONS[: 2 if initial else None], 1, _ALMOST)
    if not near:
        return None
    before = ("INITIAL_SECTION",) if initial else ()
    return Section(at, (*before, near[0].upper()))


def _section_before(trouble: Trouble) -> Section | None:
    """The last such word in the class that was read as the type of a variable."""
    for at in range(trouble.begin - 1, trouble.opened_index or 0, -1):
        if trouble.tokens[at - 1].type == "SEMICOLON" and (found := _section_at(trouble, at)):
            return found
    return None


def explain_section(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `equations` and `Equation`."""
    found = misspelt_section(trouble)
    if found is None:  # an equation before this one could be read as the value of a variable
        found = _section_before(trouble)
    if found is None or repair is None or repair.inserted != found.kinds:
        return None
    word = trouble.tokens[found.at]
    return instead(f"`{word.text}` begins no section", word.span, found.kinds[-1].lower())


def initial_equation(trouble: Trouble) -> int | None:
    """The `;` that ends `initial slide.s = 0.3;`."""
    tokens, first = trouble.tokens, trouble.begin
    if trouble.at > first + 1 or [t.type for t in tokens[first : first + 2]] != _INITIAL:
        return None
    for at in range(trouble.at, len(tokens)):
        if tokens[at].type == "SEMICOLON":
            return at
    return None


def explain_initial(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    end = initial_equation(trouble)
    if end is None or repair is None or repair.inserted:
        return None
    word = trouble.tokens[trouble.begin]
    written = trouble.tokens[trouble.begin + 1].span.to(trouble.tokens[end - 1].span).text
    shown = f"write `{written}`" if len(written) < _SHORT else "write it"
    message = "`initial` begins a section, and no single equation"
    return Diagnostic("P101", message, word.span, hint=f"{shown} below `initial equation`")
