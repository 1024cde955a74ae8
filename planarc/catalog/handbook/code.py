"""Texts of the language with colours: comments, strings, keywords.

In:   str   text of the language
Out:  str   HTML, in which everything else is escaped

Example: `Real x "a<b"; // c` becomes

    Real x <span>&quot;a&lt;b&quot;</span>; <i>// c</i>
"""

from __future__ import annotations

import html
import re

_KEYWORDS = """
algorithm and annotation block break class connect connector constant constrainedby der discrete
each else elseif elsewhen encapsulated end enumeration equation expandable extends external false
final flow for function if import impure in initial inner input loop model not operator or outer
output package parameter partial protected public pure record redeclare replaceable return stream
then true type when while within
"""
_PIECE = re.compile(
    r"(?P<c>//[^\n]*|/\*.*?\*/)"
    r'|(?P<s>"(?:[^"\\]|\\.)*")'
    rf"|(?P<k>\b(?:{'|'.join(_KEYWORDS.split())})\b)",
    re.DOTALL,
)
_TAGS = {"c": "i", "s": "span", "k": "b"}


def colored(text: str) -> str:
    """The text as HTML, its pieces in elements with short names: a handbook has thousands."""
    out, done = [], 0
    for piece in _PIECE.finditer(text):
        tag = _TAGS[piece.lastgroup or ""]
        out.append(html.escape(text[done : piece.start()]))
        out.append(f"<{tag}>{html.escape(piece[0])}</{tag}>")
        done = piece.end()
    return "".join([*out, html.escape(text[done:])])
