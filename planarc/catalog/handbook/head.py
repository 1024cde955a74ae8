"""The comments at the head of a class: its law, sign convention and limits, in comments.

In:   str   the text of a class
Out:  (keyword, text) of each, in their order

Example:

    model Spring "Linear spring along the line between two frames"
      // Law:   f = c*(s - s_unstretched).
      // Sign:  f > 0 when the spring pulls
      //        its ends together.
      extends ...

    ("Law", "f = c*(s - s_unstretched)."), ("Sign", "f > 0 when the spring pulls\\nits ends ...")

Lines that go on stand below the begin of their text; deeper ones keep their distance.
"""

from __future__ import annotations

import re

_KEYWORD = re.compile(r"( ([A-Z][a-z]+): +)(.*)")


def head_of(text: str) -> tuple[tuple[str, str], ...]:
    """The keywords of the comments between the first line of a class and its first element."""
    found: list[tuple[str, list[str]]] = []
    column = 0
    for line in _comments(text):
        match = _KEYWORD.fullmatch(line)
        if match:
            column = len(match[1])
            found.append((match[2], [match[3]]))
        elif found:
            goes_on = line[column:] if not line[:column].strip() else line.strip()
            found[-1][1].append(goes_on)
    return tuple((keyword, "\n".join(lines)) for keyword, lines in found)


def _comments(text: str) -> list[str]:
    """The texts behind `//` of the first lines that begin so."""
    found: list[str] = []
    for line in text.splitlines()[1:]:
        inner = line.strip()
        if inner.startswith("//"):
            found.append(inner[2:])
        elif found or (inner and not inner.endswith('"')):  # a description may need a line more
            break
    return found
