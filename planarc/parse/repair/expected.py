"""The expected words of an error, from what the machine would accept.

The last resort of `hints`: nothing more special is known of the error.
"""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic
from planarc.core.prose import listed
from planarc.parse.repair.trouble import Trouble, shown

#: What may end an expression: worth naming before all operators that could go on.
_CLOSING = frozenset(
    ("`;`", "`)`", "`]`", "`}`", "`,`", "`=`", "`:=`", "`then`", "`else`", "`loop`", "`end`")
)


def expected(trouble: Trouble) -> Diagnostic:
    """`expected an expression, not `;``."""
    token = trouble.token
    accepted = frozenset(trouble.accepted)
    what = _in_words(trouble, accepted)
    hint = None
    if token.type == "WHILE":
        hint = "`while` loops stand in algorithms only"
    if token.text in trouble.terminals.keywords and what == "a name":
        hint = f"`{token.text}` is a reserved word: choose another name"
    if token.type == "END" and trouble.opened is None:
        hint = "all classes have ended: remove this `end`, or one before it"
    if token.type in ("INTEGER", "REAL") and what == "a name":
        hint = "a name begins with a letter"
    return Diagnostic("P101", f"expected {what}, not {shown(token)}", trouble.here, hint=hint)


def _in_words(trouble: Trouble, accepted: frozenset[str]) -> str:
    if {"IDENT", "INTEGER"} <= accepted:
        return "an equation" if "CONNECT" in accepted else "an expression"
    if {"MODEL", "PARAMETER", "END"} <= accepted:
        return "a declaration or `end`"
    if {"PARAMETER", "IDENT"} <= accepted:
        return "a declaration"
    if "MODEL" in accepted:
        return "a class, such as `model Name ... end Name;`"
    if {"IDENT", "WHILE"} <= accepted:
        return "a statement"
    if "IDENT" in accepted:
        return "a name"
    if accepted == {"$END"}:
        return "the end of the text"
    texts = [f"`{trouble.text_of(kind)}`" for kind in sorted(accepted - {"ANNOTATION", "STRING"})]
    likely = [text for text in texts if text in _CLOSING]
    shown = (likely or texts)[:4]
    return listed(shown, "or") or "something else"
